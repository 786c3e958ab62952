"""Assessment of recorded blocks: measurements and verdicts, for a new run or a bundle read back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from benchtool.analysis import (
    Findings,
    Instruments,
    Measurement,
    Perturbed,
    SteadyState,
    Table,
    measurements_from_json,
    measurements_to_json,
    sensor_remarks,
    steady_state_of,
    tables_to_json,
)
from benchtool.block import Block
from benchtool.document import explain
from benchtool.errors import AnalysisError
from benchtool.plan import (
    CaseReadings,
    Coordinates,
    JudgedLimit,
    Limit,
    Missed,
    Plan,
    Verdict,
    case_named,
    default_limits,
    measure_reached,
    present_name,
    recorded_plan,
    targets,
    worst,
)
from benchtool.profile import Motor
from benchtool.recording import Bundle
from benchtool.results.agreement import Disagreement, disagreements
from benchtool.results.analyses import measure_all, of_plan, without_channels
from benchtool.results.calibration import Calibration, Overdue, stated_overdue
from benchtool.results.common_band import with_common_band
from benchtool.results.judged_repetitions import limits_alone
from benchtool.results.regimes import Regime
from benchtool.results.remeasurement import (
    perturbed_readings,
    remeasured,
)
from benchtool.results.repetitions import Repeated, judged_together


@dataclass(frozen=True)
class Recorded:
    """Which rows of a recording without a plan were measured.

    Attributes:
        stream: its name in the bundle.
        block: all of its rows.
        sha256: of its file, which is that of the whole stream whatever was measured of it; None of a
            recording that was cut short.
        regimes: those that were found; empty where a window was chosen.
        rows: the regime or the window; of these, the longest stretch without a missing row was measured.
    """

    stream: str
    block: Block
    sha256: str | None
    regimes: tuple[Regime, ...] = ()
    rows: Block | None = None

    def source(self, measured: Block) -> dict[str, Any]:
        """Of which rows the numbers are, such that another program can take the same ones."""
        rows = measured if self.rows is None else self.rows
        first = self.block.first_tick
        ticks = measured.ticks()
        return {
            "stream": self.stream,
            "sha256": self.sha256,
            "rate_Hz": self.block.sample_rate_Hz,
            "stride": self.block.stride,
            "first_tick": int(ticks[0]),
            "last_tick": int(ticks[-1]),
            "from_s": (int(ticks[0]) - first) * self.block.tick_s,
            "to_s": (int(ticks[-1]) - first + self.block.stride) * self.block.tick_s,
            "rows": len(measured.data),
            "rows_of_window": len(rows.data),
            "missing_rows": sum(gap.missing_rows for gap in rows.gaps),
            "gaps": len(rows.gaps),
            "regimes": [each.to_json() for each in self.regimes],
        }

    def remarks(self, measured: Block) -> Iterator[str]:
        """Yield which rows were measured, and what was left out."""
        source = self.source(measured)
        if len(self.regimes) > 1 or not self.regimes or source["gaps"]:
            yield (
                f"measured is {source['from_s']:.6g} s to {source['to_s']:.6g} s of stream {self.stream}, "
                f"{source['rows']} rows at {source['rate_Hz']:.6g} Hz"
            )
        if source["gaps"]:
            yield (
                f"{source['missing_rows']} rows are missing in {source['gaps']} gaps there: the longest "
                f"stretch without one was taken, {source['rows']} of {source['rows_of_window']} rows"
            )


@dataclass(frozen=True)
class Assessment:
    """Measurements of a case, verdicts on its limits, and published figures.

    `quality` is what the recording's certificate measured; limits hold for it as well. `limits` are the
    plan's for each case and, where it sets none, those of the operating point. `without` names analyses that
    lack channels, with these. `parameter_check` is the result of `ParameterCheck.to_json`. `refusal` is the
    reason why only the operating point was measured, if that was not reached. `overdue` are the instruments
    whose calibration was due before the run. `findings` are those of each analysis, by its name, and
    `coordinates` those of the case in its plan. `recorded` says which rows of a recording without a plan
    these are.
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
    recorded: Recorded | None = None

    @property
    def stream(self) -> str:
        """The stream of the bundle that was measured."""
        return "capture" if self.recorded is None else self.recorded.stream

    @property
    def of_sensors(self) -> tuple[str, ...]:
        """Remarks on the sensors, each once, general ones first."""
        return sensor_remarks(self.measurements)

    @property
    def found(self) -> Mapping[str, Measurement]:
        """Every measurement by name, those of the certificate among them."""
        return {each.name: each for each in (*self.quality, *self.measurements)}

    @cached_property
    def judged(self) -> Mapping[str, JudgedLimit]:
        """Each limit held against its measurement, by name; one on something that was not measured fails."""
        found = self.found
        return {name: JudgedLimit.of(name, limit, found.get(name)) for name, limit in self.limits.items()}

    @property
    def verdicts(self) -> Mapping[str, Verdict]:
        """Verdict of each limit."""
        return {name: each.verdict for name, each in self.judged.items()}

    @property
    def missed(self) -> tuple[Missed, ...]:
        """The limits that were not met and count, or were met within their margin only."""
        return tuple(told for each in self.judged.values() if (told := each.missed))

    @property
    def waived(self) -> tuple[Missed, ...]:
        """The limits that were not met, and are waived."""
        return tuple(told for each in self.judged.values() if (told := each.waived))

    @property
    def disagreements(self) -> tuple[Disagreement, ...]:
        """Numbers by the drive's estimate that the transducer contradicts."""
        return disagreements(self.measurements, self.limits)

    @property
    def verdict(self) -> Verdict:
        return self._whole(self.verdicts)

    def _whole(self, verdicts: Mapping[str, Verdict]) -> Verdict:
        """Return the worst verdict, limits that are waived aside."""
        return worst(self.limits[name].counted(each) for name, each in verdicts.items())

    @property
    def verdict_by_transducer(self) -> Verdict | None:
        """The verdict with the transducer's number wherever it contradicts the estimate; None without one."""
        if self.transducer is None:
            return None
        shaft = {each.name: each.verdict for each in self.disagreements if each.verdict is not None}
        return self._whole({**self.verdicts, **shaft})

    def to_json(self) -> dict[str, Any]:
        """Return the case as the JSON document of a run lists it."""
        document: dict[str, Any] = {
            "bundle": str(self.bundle),
            "coordinates": self.coordinates.to_json(),
            "verdict": str(self.verdict),
            "verdict_by_transducer": self.verdict_by_transducer,
            "missed": [str(each) for each in self.missed],
            "waived": {each.name: str(each) for each in self.waived},
            "limits": {name: each.to_json() for name, each in self.judged.items()},
            "disagreements": {each.name: each.to_json() for each in self.disagreements},
            "refusal": self.refusal,
            "not_measured": {title: list(channels) for title, channels in self.without.items()},
            "different_parameters": dict(self.parameter_check.get("contradicted", {})),
            "unstated_parameters": dict(self.parameter_check.get("unstated", {})),
            "measurements": measurements_to_json(self.measurements),
        }
        if self.recorded is not None:
            document["source"] = self.recorded.source(self.capture)
        document |= stated_overdue(self.overdue)
        return document | ({"tables": tables_to_json(self.tables)} if self.tables else {})


@dataclass(frozen=True)
class RunResult:
    """Results of every case of a plan and, by the name of each case, of its repetitions together."""

    assessments: tuple[Assessment, ...]
    repeated: Mapping[str, tuple[Repeated, ...]] = field(default_factory=dict)

    @property
    def verdict(self) -> Verdict:
        return worst((*(each.verdict for each in self.assessments), self._verdict_together))

    @property
    def missed(self) -> tuple[tuple[str, Missed], ...]:
        """The limits over repetitions that were not met, each with its case."""
        judged = judged_together(self.repeated)
        return tuple((case, told) for case, each in judged if (told := each.missed))

    @property
    def overdue(self) -> tuple[Overdue, ...]:
        """The instruments whose calibration was due before their case was run."""
        return tuple(dict.fromkeys(each for case in self.assessments for each in case.overdue))

    @property
    def _verdict_together(self) -> Verdict:
        return worst(each.counted for _, each in judged_together(self.repeated))

    @property
    def verdict_by_transducer(self) -> Verdict | None:
        """As that of the cases; None where none has a transducer."""
        found = [each.verdict_by_transducer for each in self.assessments]
        known = [verdict for verdict in found if verdict is not None]
        together = (each.verdict_by_transducer for _, each in judged_together(self.repeated))
        return worst((*known, *together)) if known else None

    def to_json(self) -> dict[str, Any]:
        """Return the document that `--json` prints."""
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
    try:
        answers, refusal = _answer(plan, motor, capture, transducer), ""
    except AnalysisError as refused:
        held = (JudgedLimit.of(each.name, limits[each.name], each) for each in reached if each.name in limits)
        if all(each.verdict is Verdict.PASS for each in held):
            raise
        # the operating point was not reached: that is the result, and nothing else is measured
        answers, refusal = _Answers(), str(refused)
    blocks = [capture] if transducer is None else [capture, transducer]
    instruments = Instruments(calibration.bench, blocks)

    def again(altered: Perturbed) -> Iterator[Measurement]:
        """Yield the measurements that depend on the waveform, with a perturbed channel."""
        other = altered.of(capture)
        shaft = None if transducer is None else altered.of(transducer)
        yield from measure_reached(
            wanted, plan, point, motor, other, shaft, perturbed_readings(seen, altered)
        )
        if not refusal:
            with suppress(AnalysisError):  # a measurement that is not found again has an unknown uncertainty
                todo = of_plan(plan, motor, other, shaft)
                yield from remeasured(todo, altered.channel, answers.findings)

    measurements = instruments.applied((*answers.measurements, *reached), again)
    if not refusal:
        measurements = with_common_band(
            measurements,
            capture,
            transducer,
            lambda narrow: of_plan(plan, motor, narrow, transducer),
            instruments,
        )
    return Assessment(
        case,
        bundle,
        measurements,
        quality,
        limits,
        {**plan.published.get(this.group, {}), **plan.published.get(case, {})},
        capture,
        transducer,
        steady_state_of(answers.findings) if plan.analyses.steady and not refusal else None,
        instruments.applied_to(answers.tables),
        answers.findings,
        answers.without,
        seen.parameter_check,
        refusal,
        calibration.overdue(name for block in blocks for name in block.names),
        this.coordinates,
    )


@dataclass(frozen=True)
class _Answers:
    """Findings of the analyses of a plan, by name, and analyses that lack channels."""

    findings: Mapping[str, Findings] = field(default_factory=dict)
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def measurements(self) -> tuple[Measurement, ...]:
        return tuple(each for found in self.findings.values() for each in found.measurements)

    @property
    def tables(self) -> tuple[Table, ...]:
        return tuple(each for found in self.findings.values() for each in found.tables)


def _answer(plan: Plan, motor: Motor, capture: Block, transducer: Block | None) -> _Answers:
    """Make every analysis of a plan."""
    todo = of_plan(plan, motor, capture, transducer)
    return _Answers(measure_all(todo), without_channels(todo))


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
