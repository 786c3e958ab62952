"""From recorded blocks to measurements and verdicts: the same for a fresh run and for a bundle read back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import ValidationError

from benchtool.analysis import (
    Measurement,
    SteadyState,
    Table,
    measurements_from_json,
    measurements_to_json,
    tables_to_json,
)
from benchtool.analysis.catalogue import STEADY, Window, analyses_of, response_names, step_names
from benchtool.analysis.dynamics.bode import Bode, analyze_response
from benchtool.analysis.dynamics.step import analyze_step
from benchtool.analysis.instruments import Altered, Instruments, said_of_sensors
from benchtool.analysis.sensitivity import declared
from benchtool.block import Block
from benchtool.drive import Mode
from benchtool.errors import AnalysisError
from benchtool.plan.cases import case_named
from benchtool.plan.limits import Limit, Missed, Verdict, missed, worst
from benchtool.plan.model import Plan
from benchtool.plan.operating_point import Seen, asked, default_limits, measure_reached
from benchtool.profile import Motor
from benchtool.recording import Bundle
from benchtool.results.agreement import Disagreement, disagreements
from benchtool.results.calibration import Calibration, Overdue, stated_overdue
from benchtool.results.repetitions import Repeated, limits_together
from benchtool.results.steady_state import assess_steady_state


@dataclass(frozen=True)
class Assessment:
    """What a case measured, how each limit was met, and what a publication has for it.

    `quality` is what the recording's certificate measured; limits hold for it as well. `limits` are the
    plan's for each case and, where it sets none, those of the operating point. `without` names what could not
    be measured for want of channels, with these. `parameter_check` is what `ParameterCheck.to_json` tells of
    the drive. `refusal` is why nothing but the operating point was measured, where the machine ran elsewhere.
    `overdue` are the instruments whose calibration was due before the run.
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
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    parameter_check: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    refusal: str = ""
    overdue: tuple[Overdue, ...] = ()

    @property
    def of_sensors(self) -> tuple[str, ...]:
        """What is to be said of the sensors, each once, the general before the particular."""
        return said_of_sensors(self.measurements)

    @property
    def found(self) -> Mapping[str, Measurement]:
        """Every measurement by name, those of the certificate among them."""
        return {each.name: each for each in (*self.quality, *self.measurements)}

    @property
    def verdicts(self) -> Mapping[str, Verdict]:
        """Verdict of each limit; a limit on something that was not measured fails."""
        found = self.found
        return {name: _verdict(limit, found.get(name)) for name, limit in self.limits.items()}

    @property
    def conformances(self) -> Mapping[str, float]:
        """Probability that each limit is met, of those whose measurement has an uncertainty."""
        found = ((name, limit, self.found.get(name)) for name, limit in self.limits.items())
        known = (
            (name, limit.conformance(each.value, each.uncertainty))
            for name, limit, each in found
            if each is not None
        )
        return {name: probability for name, probability in known if probability is not None}

    @property
    def missed(self) -> tuple[Missed, ...]:
        """The limits that were not met, or within their margin only."""
        found = self.found
        judged = (missed(name, limit, found.get(name)) for name, limit in self.limits.items())
        return tuple(each for each in judged if each is not None)

    @property
    def disagreements(self) -> tuple[Disagreement, ...]:
        """Numbers of the drive's estimate that the transducer contradicts."""
        return disagreements(self.measurements, self.limits)

    @property
    def verdict(self) -> Verdict:
        return worst(self.verdicts.values())

    @property
    def verdict_by_transducer(self) -> Verdict | None:
        """The verdict with the transducer's number wherever it contradicts the estimate; None without one."""
        if self.transducer is None:
            return None
        shaft = {each.name: each.verdict for each in self.disagreements if each.verdict is not None}
        return worst({**self.verdicts, **shaft}.values())

    def to_json(self) -> dict[str, Any]:
        """The case as the JSON document of a run lists it."""
        document: dict[str, Any] = {
            "bundle": str(self.bundle),
            "verdict": str(self.verdict),
            "verdict_by_transducer": self.verdict_by_transducer,
            "missed": [str(each) for each in self.missed],
            "limits": {name: limit.to_json(self.found.get(name)) for name, limit in self.limits.items()},
            "disagreements": {each.name: each.to_json() for each in self.disagreements},
            "refusal": self.refusal,
            "not_measured": {title: list(channels) for title, channels in self.without.items()},
            "different_parameters": dict(self.parameter_check.get("contradicted", {})),
            "unstated_parameters": dict(self.parameter_check.get("unstated", {})),
            "measurements": measurements_to_json(self.measurements),
        }
        document |= stated_overdue(self.overdue)
        return document | ({"tables": tables_to_json(self.tables)} if self.tables else {})


def _verdict(limit: Limit, measured: Measurement | None) -> Verdict:
    return limit.judge(*((None, None) if measured is None else (measured.value, measured.uncertainty)))


@dataclass(frozen=True)
class RunResult:
    """What every case of a plan came to and, by the name of each case, its repetitions together."""

    assessments: tuple[Assessment, ...]
    repeated: Mapping[str, tuple[Repeated, ...]] = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict:
        return worst((*(each.verdict for each in self.assessments), self._verdict_together))

    @property
    def missed(self) -> tuple[tuple[str, Missed], ...]:
        """The limits over repetitions that were not met, each with its case."""
        found = ((case, each.missed) for case, together in self.repeated.items() for each in together)
        return tuple((case, each) for case, each in found if each is not None)

    @property
    def overdue(self) -> tuple[Overdue, ...]:
        """The instruments whose calibration was due before their case was run."""
        return tuple(dict.fromkeys(each for case in self.assessments for each in case.overdue))

    @property
    def _verdict_together(self) -> Verdict:
        return worst(each.verdict for together in self.repeated.values() for each in together)

    @property
    def verdict_by_transducer(self) -> Verdict | None:
        """As that of the cases; None where none has a transducer."""
        found = [each.verdict_by_transducer for each in self.assessments]
        known = [verdict for verdict in found if verdict is not None]
        return worst((*known, self._verdict_together)) if known else None

    def to_json(self) -> dict[str, Any]:
        """The document that `--json` prints."""
        document: dict[str, Any] = {
            "verdict": str(self.verdict),
            "verdict_by_transducer": self.verdict_by_transducer,
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
    seen: Seen | None = None,
    calibration: Calibration | None = None,
) -> Assessment:
    """Analyse what one case recorded.

    Args:
        case: its name.
        quality: what the recording's certificate measured.
        seen: what was read from drive and bench beside the capture.
        calibration: what is known of the sensors.

    Raises:
        AnalysisError: the data cannot answer what the plan asks, though the operating point was reached.
    """
    this, seen, calibration = case_named(plan, case), seen or Seen(), calibration or Calibration()
    point = this.operating_point
    wanted = asked(point, motor, seen.u_dc_V)
    reached = measure_reached(wanted, plan, point, motor, capture, transducer, seen)
    together = limits_together(plan, this.group)
    own = {**plan.limits, **plan.case_limits.get(this.group, {})}
    own = {name: limit for name, limit in own.items() if name not in together}
    own |= plan.case_limits.get(case, {})
    limits = {**own, **{name: each for name, each in default_limits(wanted).items() if name not in own}}
    try:
        answers, refusal = _answer(plan, motor, capture, transducer), ""
    except AnalysisError as refused:
        if not any(missed(each.name, limits[each.name], each) for each in reached if each.name in limits):
            raise
        # the machine ran elsewhere: that is the result, and no wonder that nothing else can be told
        answers, refusal = _Answers(), str(refused)
    blocks = [capture] if transducer is None else [capture, transducer]
    rests_on = partial(_rests_on, plan, transducer is not None)
    instruments = Instruments(calibration.bench, blocks, rests_on=rests_on, pole_pairs=motor.pole_pairs)

    def again(altered: Altered) -> Iterator[Measurement]:
        """What hangs on the waveform of an altered channel."""
        other = altered.of(capture)
        shaft = None if transducer is None else altered.of(transducer)
        yield from measure_reached(wanted, plan, point, motor, other, shaft, _altered(seen, altered))
        if not refusal:
            with suppress(AnalysisError):  # what is not found again has an unknown uncertainty
                yield from _answer_again(plan, motor, other, shaft, altered.channel)

    return Assessment(
        case,
        bundle,
        instruments.applied((*answers.measurements, *reached), again),
        quality,
        limits,
        {**plan.published.get(this.group, {}), **plan.published.get(case, {})},
        capture,
        transducer,
        answers.steady,
        answers.tables,
        answers.bode,
        answers.without,
        seen.parameter_check,
        refusal,
        calibration.overdue(name for block in blocks for name in block.names),
    )


def _rests_on(plan: Plan, transducer: bool, name: str) -> tuple[str, ...]:
    """The channels of a measurement whose sensitivities are not declared."""
    if name == "load_torque_reached":
        if plan.operating_point.mode_of_operation is Mode.TORQUE:
            return "torque", "omega_m"
        return ("torque_transducer",) if transducer else ("torque",)
    if name in step_names():
        return plan.analyses.step_signal, plan.analyses.step_reference
    if name in response_names():
        return plan.analyses.response_input, plan.analyses.response_output
    found = next(analyses_of(name), None)
    if found is None:
        return ()
    return (*found.channels, "torque_transducer") if found.transducer else found.channels


def _altered(seen: Seen, altered: Altered) -> Seen:
    """What was read, with the error of its channel."""
    if altered.channel not in seen.readings:
        return seen
    values = altered.reading(np.array(seen.readings[altered.channel]))
    return replace(seen, readings={**seen.readings, altered.channel: tuple(values.tolist())})


def _answer_again(
    plan: Plan, motor: Motor, capture: Block, transducer: Block | None, channel: str
) -> Iterator[Measurement]:
    """The analyses of a plan that rest on a channel and declare no sensitivity to it."""
    if plan.analyses.steady:
        window = Window.of(_from(capture, plan.analyses.steady_from_s), motor, transducer)
        channels, stride = frozenset(capture.names), capture.stride
        for analysis in STEADY:
            names = [name for name in analysis.names if declared(name) is None]
            possible = analysis.possible(channels, transducer=transducer is not None, stride=stride)
            if possible and names and channel in _rests_on(plan, transducer is not None, names[0]):
                yield from analysis.measure(window).measurements
    if plan.analyses.step and channel in _rests_on(plan, False, step_names()[0]):
        signal, reference = plan.analyses.step_signal, plan.analyses.step_reference
        yield from analyze_step(capture, signal, reference).measurements
    if plan.analyses.frequency_response and channel in _rests_on(plan, False, response_names()[0]):
        yield from _response(plan, capture).measurements


@dataclass(frozen=True)
class _Answers:
    """What the analyses that a plan asks for give; the fields are those of `Assessment`."""

    measurements: tuple[Measurement, ...] = ()
    tables: tuple[Table, ...] = ()
    steady: SteadyState | None = None
    bode: Bode | None = None
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def _answer(plan: Plan, motor: Motor, capture: Block, transducer: Block | None) -> _Answers:
    """Every analysis that a plan asks for."""
    measurements: list[Measurement] = []
    tables: list[Table] = []
    steady = None
    without: dict[str, tuple[str, ...]] = {}
    if plan.analyses.steady:
        window = _from(capture, plan.analyses.steady_from_s)
        steady, further = assess_steady_state(window, motor, transducer)
        measurements.extend((*steady.measurements, *further.measurements))
        tables.extend((*steady.tables, *further.tables))
        channels = frozenset(window.names)
        could = [each for each in STEADY if transducer is not None or not each.transducer]
        without = {each.title: lacking for each in could if (lacking := each.missing(channels))}
    if plan.analyses.step:
        step = analyze_step(capture, plan.analyses.step_signal, plan.analyses.step_reference)
        measurements.extend(step.measurements)
    bode = _response(plan, capture) if plan.analyses.frequency_response else None
    if bode is not None:
        measurements.extend(bode.measurements)
        tables.extend(bode.tables)
    return _Answers(tuple(measurements), tuple(tables), steady, bode, without)


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
    capture, seen = bundle.block("capture"), Seen.of(details)
    calibration = Calibration.of(bundle.manifest)
    return assess(plan, case, motor, bundle.directory, capture, transducer, quality, seen, calibration)


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
