"""From recorded blocks to measurements and verdicts: the same for a fresh run and for a bundle read back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from benchtool.analysis import (
    Measurement,
    SteadyState,
    Table,
    measurements_from_json,
    measurements_to_json,
    tables_to_json,
)
from benchtool.analysis.bode import Bode, analyze_response
from benchtool.analysis.step import analyze_step
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.experiment.limits import Limit, Verdict, worst
from benchtool.experiment.plan import Plan
from benchtool.experiment.repetition import Repeated
from benchtool.experiment.steady_state import assess_steady_state
from benchtool.profile import Motor
from benchtool.recording import Bundle


@dataclass(frozen=True)
class Assessment:
    """What a case measured, how each limit was met, and what a publication has for it.

    `quality` is what the recording's certificate measured; limits hold for it as well.
    """

    case: str
    bundle: Path
    measurements: tuple[Measurement, ...]
    quality: tuple[Measurement, ...]
    limits: Mapping[str, Limit]
    published: Mapping[str, float]
    capture: Block
    transducer: Block | None
    steady: SteadyState | None
    tables: tuple[Table, ...] = ()
    bode: Bode | None = None

    @property
    def verdicts(self) -> Mapping[str, Verdict]:
        """Verdict of each limit; a limit on something that was not measured fails."""
        values = {each.name: each.value for each in (*self.quality, *self.measurements)}
        return {name: limit.judge(values.get(name)) for name, limit in self.limits.items()}

    @property
    def verdict(self) -> Verdict:
        return worst(self.verdicts.values())

    def to_json(self) -> dict[str, Any]:
        """The case as the JSON document of a run lists it."""
        document = {"bundle": str(self.bundle), "measurements": measurements_to_json(self.measurements)}
        return document | ({"tables": tables_to_json(self.tables)} if self.tables else {})


@dataclass(frozen=True)
class RunResult:
    """What every case of a plan came to and, by the name of each case, its repetitions together."""

    assessments: tuple[Assessment, ...]
    repeated: Mapping[str, tuple[Repeated, ...]] = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict:
        return worst(each.verdict for each in self.assessments)

    def to_json(self) -> dict[str, Any]:
        """The document that `--json` prints."""
        document: dict[str, Any] = {
            "verdict": str(self.verdict),
            "cases": {each.case: each.to_json() for each in self.assessments},
        }
        if self.repeated:
            document["repeated"] = {
                case: {each.name: each.to_json() for each in together}
                for case, together in self.repeated.items()
            }
        return document


def assess(
    plan: Plan,
    case: str,
    motor: Motor,
    bundle: Path,
    capture: Block,
    transducer: Block | None,
    quality: tuple[Measurement, ...] = (),
) -> Assessment:
    """Analyse what one case recorded.

    Raises:
        AnalysisError: the data cannot answer what the plan asks.
    """
    measurements: list[Measurement] = []
    tables: list[Table] = []
    steady = None
    if plan.analyses.steady:
        window = _from(capture, plan.analyses.steady_from_s)
        steady, further = assess_steady_state(window, motor, transducer)
        measurements.extend((*steady.measurements, *further.measurements))
        tables.extend((*steady.tables, *further.tables))
    if plan.analyses.step:
        step = analyze_step(capture, plan.analyses.step_signal, plan.analyses.step_reference)
        measurements.extend(step.measurements)
    bode = _response(plan, capture) if plan.analyses.frequency_response else None
    if bode is not None:
        measurements.extend(bode.measurements)
        tables.extend(bode.tables)
    return Assessment(
        case,
        bundle,
        tuple(measurements),
        quality,
        {**plan.limits, **plan.case_limits.get(case, {})},
        plan.published.get(case, {}),
        capture,
        transducer,
        steady,
        tuple(tables),
        bode,
    )


def _response(plan: Plan, capture: Block) -> Bode:
    """Frequency response while the stimulus plays; of a repeated one after its first period, a transient."""
    begin, end, period = 0, len(capture.data), None
    if plan.stimulus is not None:
        begin = round(plan.record.pretrigger_s * capture.sample_rate_Hz)
        ticks = plan.stimulus.ticks(capture.tick_s)
        end = min(end, begin + ticks * plan.stimulus.repetitions // capture.stride)
        if plan.stimulus.repetitions > 1 and ticks % capture.stride == 0:
            period = ticks // capture.stride
            begin += period
    channels = plan.analyses.response_input, plan.analyses.response_output
    return analyze_response(capture, *channels, begin_row=begin, end_row=end, period_rows=period)


def assess_bundle(bundle: Bundle) -> Assessment:
    """Analyse a bundle again, by the plan and the motor that it carries.

    Raises:
        RecordingError: a file of it is not what was recorded, or cannot be read.
        AnalysisError: it is not of a plan, or its data cannot answer what the plan asks.
    """
    bundle.require_intact()
    details = bundle.manifest.details
    try:
        plan, motor = Plan.model_validate(details["plan"]), Motor.model_validate(details["motor"])
        case = str(details["case"])
    except (KeyError, ValidationError):
        raise AnalysisError(
            f"{bundle.directory} carries no plan that this version understands: analyse a bundle that "
            f"'benchtool run' wrote"
        ) from None
    if "capture" not in bundle.streams:
        failure = details.get("failure", "it was cut short")
        raise AnalysisError(f"{bundle.directory} holds no capture ({failure}): run the plan again")
    transducer = bundle.block("transducer") if "transducer" in bundle.streams else None
    certificate = bundle.certificate or {}
    quality = measurements_from_json(certificate.get("measurements", {}))
    return assess(plan, case, motor, bundle.directory, bundle.block("capture"), transducer, quality)


def _from(block: Block, start_s: float) -> Block:
    """What a block holds from `start_s` on."""
    if start_s == 0.0:
        return block
    block.require_uniform()
    row = round(start_s * block.sample_rate_Hz)
    if row >= len(block.data):
        raise AnalysisError(
            f"the capture lasts {len(block.data) / block.sample_rate_Hz:g} s, its steady state was to begin "
            f"at {start_s:g} s: record longer or begin earlier"
        )
    return replace(block, first_tick=block.first_tick + row * block.stride, data=block.data[row:])
