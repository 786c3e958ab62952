"""From recorded blocks to measurements and verdicts: the same for a fresh run and for a bundle read back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
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
from benchtool.analysis.declaration import Findings
from benchtool.analysis.instruments import Altered, Instruments, said_of_sensors
from benchtool.analysis.steady_state import steady_state_of
from benchtool.block import Block
from benchtool.document import explain
from benchtool.errors import AnalysisError
from benchtool.plan.cases import Coordinates, case_named
from benchtool.plan.limits import Limit, Missed, Verdict, missed, worst
from benchtool.plan.model import Plan
from benchtool.plan.operating_point import Seen, asked, default_limits, measure_reached
from benchtool.profile import Motor
from benchtool.recording import Bundle
from benchtool.results.agreement import Disagreement, disagreements
from benchtool.results.analyses import measure_all, of_plan, without_channels
from benchtool.results.calibration import Calibration, Overdue, stated_overdue
from benchtool.results.measuring_again import altered_readings, measured_again, rests_on
from benchtool.results.repetitions import Repeated, limits_alone


@dataclass(frozen=True)
class Assessment:
    """What a case measured, how each limit was met, and what a publication has for it.

    `quality` is what the recording's certificate measured; limits hold for it as well. `limits` are the
    plan's for each case and, where it sets none, those of the operating point. `without` names what could not
    be measured for want of channels, with these. `parameter_check` is what `ParameterCheck.to_json` tells of
    the drive. `refusal` is why nothing but the operating point was measured, where the machine ran elsewhere.
    `overdue` are the instruments whose calibration was due before the run.
    `findings` are what each analysis found, by its name, and `coordinates` say where the case stands in its
    plan.
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
    findings: Mapping[str, Findings] = field(default_factory=dict)
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    parameter_check: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    refusal: str = ""
    overdue: tuple[Overdue, ...] = ()
    coordinates: Coordinates = field(default_factory=partial(Coordinates, ""))

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
            "coordinates": self.coordinates.to_json(),
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
        together = (each.verdict_by_transducer for found in self.repeated.values() for each in found)
        return worst((*known, *together)) if known else None

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
    own = limits_alone(plan, this)
    limits = {**own, **{name: each for name, each in default_limits(wanted).items() if name not in own}}
    try:
        answers, refusal = _answer(plan, motor, capture, transducer), ""
    except AnalysisError as refused:
        if not any(missed(each.name, limits[each.name], each) for each in reached if each.name in limits):
            raise
        # the machine ran elsewhere: that is the result, and no wonder that nothing else can be told
        answers, refusal = _Answers(), str(refused)
    blocks = [capture] if transducer is None else [capture, transducer]
    instruments = Instruments(
        calibration.bench,
        blocks,
        rests_on=partial(rests_on, plan, transducer is not None),
        pole_pairs=motor.pole_pairs,
    )

    def again(altered: Altered) -> Iterator[Measurement]:
        """What hangs on the waveform of an altered channel."""
        other = altered.of(capture)
        shaft = None if transducer is None else altered.of(transducer)
        yield from measure_reached(wanted, plan, point, motor, other, shaft, altered_readings(seen, altered))
        if not refusal:
            with suppress(AnalysisError):  # what is not found again has an unknown uncertainty
                yield from measured_again(plan, motor, other, shaft, altered.channel)

    return Assessment(
        case,
        bundle,
        instruments.applied((*answers.measurements, *reached), again),
        quality,
        limits,
        {**plan.published.get(this.group, {}), **plan.published.get(case, {})},
        capture,
        transducer,
        steady_state_of(answers.findings) if plan.analyses.steady and not refusal else None,
        answers.tables,
        answers.findings,
        answers.without,
        seen.parameter_check,
        refusal,
        calibration.overdue(name for block in blocks for name in block.names),
        this.coordinates,
    )


@dataclass(frozen=True)
class _Answers:
    """What the analyses that a plan asks for find, by name, and what lacked channels."""

    findings: Mapping[str, Findings] = field(default_factory=dict)
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        return tuple(each for found in self.findings.values() for each in found.measurements)

    @property
    def tables(self) -> tuple[Table, ...]:
        return tuple(each for found in self.findings.values() for each in found.tables)


def _answer(plan: Plan, motor: Motor, capture: Block, transducer: Block | None) -> _Answers:
    """Every analysis that a plan asks for."""
    todo = of_plan(plan, motor, capture, transducer)
    return _Answers(measure_all(todo), without_channels(todo))


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
    quality = measurements_from_json(certificate.get("measurements", {}))
    capture, seen = bundle.block("capture"), Seen.of(details)
    calibration = Calibration.of(bundle.manifest)
    return assess(plan, case, motor, bundle.directory, capture, transducer, quality, seen, calibration)
