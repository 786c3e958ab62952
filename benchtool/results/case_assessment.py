"""From the recorded blocks of a case to measurements and verdicts, for a new run or a bundle read back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from pydantic import ValidationError

from benchtool.analysis import (
    Findings,
    Instruments,
    Measurement,
    Perturbed,
    Table,
    catalogue,
    measurements_from_json,
    steady_state_of,
)
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.misfits import explain
from benchtool.plan import (
    CaseReadings,
    JudgedLimit,
    OperatingPoint,
    Plan,
    Verdict,
    case_named,
    default_limits,
    measure_reached,
    present_name,
    recorded_plan,
    targets,
)
from benchtool.profile import Motor
from benchtool.recording import Bundle
from benchtool.results.analyses import measure_all, of_plan, with_numbers, without_channels
from benchtool.results.assessment import Assessment
from benchtool.results.calibration import Calibration
from benchtool.results.common_band import with_common_band
from benchtool.results.judged_repetitions import LimitsTogether, limits_alone
from benchtool.results.remeasurement import remeasured


def assess(
    plan: Plan,
    case: str,
    motor: Motor,
    bundle: Path,
    capture: Block,
    transducer: Block | None,
    quality: tuple[Measurement, ...] = (),
    seen: CaseReadings | None = None,
    calibration: Calibration | None = None,
) -> Assessment:
    """Analyse what one case recorded.

    Args:
        case: its name.
        quality: what the recording's certificate measured.
        seen: readings of drive and bench besides the capture.
        calibration: of the sensors.

    Raises:
        AnalysisError: the data cannot answer what the plan asks, though the operating point was reached.
    """
    this, seen, calibration = case_named(plan, case), seen or CaseReadings(), calibration or Calibration()
    point = this.operating_point
    wanted = targets(point, motor, seen.u_dc_V, seen.driven_Nm)
    reached = measure_reached(wanted, plan, point, motor, capture, transducer, seen)
    own = limits_alone(plan, this)
    limits = {**own, **{name: each for name, each in default_limits(wanted).items() if name not in own}}
    published = {**plan.published.get(this.group, {}), **plan.published.get(case, {})}
    try:
        asked = frozenset((*limits, *published, *plan.tabulate))
        answers, refusal = _answer(plan, point, motor, capture, transducer, asked), ""
    except AnalysisError as refused:
        held = (JudgedLimit.of(each.name, limits[each.name], each) for each in reached if each.name in limits)
        if all(each.verdict is Verdict.PASS for each in held):
            raise
        # the operating point was not reached: that is the result, and nothing else is measured
        answers, refusal = _Answers(), str(refused)
    blocks = [capture, *([] if transducer is None else [transducer]), *seen.blocks]
    instruments = Instruments(calibration.bench, blocks)

    def again(altered: Perturbed) -> Iterator[Measurement]:
        """Yield the measurements that depend on the waveform, with a perturbed channel."""
        other = altered.of(capture)
        shaft = None if transducer is None else altered.of(transducer)
        if not refusal:
            with suppress(AnalysisError):  # a measurement that is not found again has an unknown uncertainty
                todo = of_plan(plan, point, motor, other, shaft)
                yield from remeasured(todo, altered.channel, answers.findings)

    measurements = instruments.applied((*answers.measurements, *reached), again)
    if not refusal:
        measurements = with_common_band(
            measurements,
            capture,
            transducer,
            lambda narrow: of_plan(plan, point, motor, narrow, transducer),
            instruments,
        )
    made = with_numbers(answers.findings)
    return Assessment(
        case,
        bundle,
        measurements,
        quality,
        limits,
        published,
        capture,
        transducer,
        steady_state_of(made) if plan.analyses.steady and not refusal else None,
        instruments.applied_to(answers.tables),
        made,
        answers.without,
        seen.parameter_check,
        refusal,
        calibration.overdue(name for block in blocks for name in block.names),
        this.coordinates,
        together=LimitsTogether.of(plan, this.group),
        refused=answers.refused,
    )


@dataclass(frozen=True)
class _Answers:
    """Findings of the analyses of a plan, by name, and analyses that lack channels.

    Of an analysis that was not made the numbers that are `asked` for by name are listed, without a value; it
    is told once by its title, `refused`.
    """

    findings: Mapping[str, Findings] = field(default_factory=dict)
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    asked: frozenset[str] = frozenset()

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        return tuple(
            each
            for found in self.findings.values()
            for each in found.measurements
            if not found.refusal or each.name in self.asked
        )

    @property
    def refused(self) -> dict[str, str]:
        """The analyses that were not made, by title, and why."""
        titles = {each.name: each.title for each in catalogue().analyses}
        return {titles[name]: found.refusal for name, found in self.findings.items() if found.refusal}

    @property
    def tables(self) -> tuple[Table, ...]:
        return tuple(each for found in self.findings.values() for each in found.tables)


def _answer(
    plan: Plan,
    point: OperatingPoint,
    motor: Motor,
    capture: Block,
    transducer: Block | None,
    asked: frozenset[str],
) -> _Answers:
    """Make every analysis of a plan; numbers that are `asked` for have a reason where they have no value."""
    todo = of_plan(plan, point, motor, capture, transducer)
    return _Answers(measure_all(todo), without_channels(todo), asked)


def assess_bundle(bundle: Bundle) -> Assessment:
    """Analyse a bundle again, by the plan and the motor that it carries.

    Raises:
        RecordingError: a file was changed since it was recorded, or cannot be read.
        AnalysisError: it is not of a plan, or its data cannot answer what the plan asks.
    """
    bundle.require_intact()
    details = bundle.manifest.details
    try:
        plan, motor = recorded_plan(details["plan"]), Motor.model_validate(details["motor"])
        case = str(details["case"])
    except (KeyError, ValidationError) as failed:
        why = f" ({explain(Plan, failed)})" if isinstance(failed, ValidationError) else ""
        raise AnalysisError(
            f"{bundle.directory} carries no plan that this version understands{why}: analyse a bundle that "
            f"'benchtool run' wrote"
        ) from None
    if "capture" not in bundle.streams:
        failure = details.get("failure", "it was cut short")
        raise AnalysisError(f"{bundle.directory} holds no capture ({failure}): run the plan again")
    transducer = bundle.block("transducer") if "transducer" in bundle.streams else None
    certificate = bundle.certificate or {}
    certified = certificate.get("measurements", {})
    quality = measurements_from_json({present_name(name): value for name, value in certified.items()})
    capture, seen = bundle.block("capture"), CaseReadings.of(details)
    calibration = Calibration.of(bundle.manifest)
    return assess(plan, case, motor, bundle.directory, capture, transducer, quality, seen, calibration)
