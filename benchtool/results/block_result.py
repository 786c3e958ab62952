"""What a block comes to: every analysis that its channels allow, whether a capture, a stream or a table.

    result = analyze(block, profile)
    print(result["torque_mean"].value)

What cannot be told of it is undefined, with the reason; what lacks channels is in `without`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import date
from typing import Any, Final

from pydantic import ValidationError

from benchtool.analysis import (
    Extremes,
    Findings,
    Harmonics,
    Instruments,
    Largest,
    Measurement,
    Noise,
    Perturbed,
    SteadyState,
    Table,
    Window,
    catalogue,
    measurements_to_json,
    raw,
    sensor_remarks,
    signal_remarks,
    steady_state_of,
    tables_to_json,
    undefined,
)
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.misfits import explain
from benchtool.plan import Analyses
from benchtool.profile import Motor, Profile
from benchtool.results.analyses import Planned, measure_each, planned, with_numbers, without_channels
from benchtool.results.calibration import Calibration, Overdue, stated_overdue
from benchtool.results.common_band import with_common_band
from benchtool.results.remeasurement import remeasured
from benchtool.results.rotation import ROTATING, Rotation
from benchtool.results.windows import without

EVERYTHING: Final = Analyses()
"""Every analysis of a steady state; none of those that have to be asked for."""


@dataclass(frozen=True)
class BlockResult:
    """What was measured of a block.

    Attributes:
        block: the rows that were measured.
        transducer: the true torque beside it, if there was one.
        measurements: in the order of the catalogue; undefined ones say why.
        findings: what each analysis found, by its name.
        without: titles of the analyses for which channels are missing, with these.
        overdue: the instruments whose calibration was due before the recording.
        tables: spectra, orders and other tables, in the order of the analyses.
    """

    block: Block
    transducer: Block | None
    measurements: tuple[Measurement, ...]
    findings: Mapping[str, Findings]
    without: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    overdue: tuple[Overdue, ...] = ()
    tables: tuple[Table, ...] = ()

    def __getitem__(self, name: str) -> Measurement:
        """Return the measurement of that name.

        Raises:
            AnalysisError: there is none; the message says which channels it would take.
        """
        for each in self.measurements:
            if each.name == name:
                return each
        analysis = catalogue().measuring(name)
        if analysis is not None and analysis.title in self.without:
            lacking = ", ".join(self.without[analysis.title])
            raise AnalysisError(f"'{name}' needs {lacking}, not recorded here: record it too")
        names = ", ".join(self.names) or "none"
        raise AnalysisError(f"no measurement '{name}' of this block, it has {names}: choose one of these")

    def __contains__(self, name: object) -> bool:
        return name in self.names

    def __iter__(self) -> Iterator[Measurement]:
        return iter(self.measurements)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the measurements."""
        return tuple(each.name for each in self.measurements)

    @property
    def made(self) -> Mapping[str, Findings]:
        """The findings of the analyses that found a number, or have none."""
        return with_numbers(self.findings)

    @property
    def steady(self) -> SteadyState:
        """What the analyses of `catalogue.CORE` found, as figures need it."""
        return steady_state_of(self.findings)

    @property
    def undefined(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the measurements without a value, by the reason."""
        return undefined(self.measurements)

    @property
    def of_sensors(self) -> tuple[str, ...]:
        """What is to be said of the sensors, each sentence once."""
        return tuple(sensor_remarks(self.measurements).values())

    @property
    def remarks(self) -> tuple[str, ...]:
        """Remarks on the recorded signals that do not prevent measurements, a sentence each."""
        return signal_remarks(self.measurements)

    def to_json(self) -> dict[str, Any]:
        """As the JSON of a run has a case, without what only a plan knows."""
        document: dict[str, Any] = {
            "not_measured": {title: list(channels) for title, channels in self.without.items()},
            "measurements": measurements_to_json(self.measurements),
        }
        document |= stated_overdue(self.overdue)
        document |= {"remarks": list(self.remarks)} if self.remarks else {}
        return document | ({"tables": tables_to_json(self.tables)} if self.tables else {})


def analyze(
    block: Block,
    profile: Profile,
    *,
    analyses: Analyses | Mapping[str, Any] = EVERYTHING,
    transducer: Block | None = None,
    from_s: float | None = None,
    to_s: float | None = None,
    on: date | None = None,
) -> BlockResult:
    """Measure a block by every analysis of the catalogue that its channels allow.

    A number that the block does not tell is undefined, with the reason: a row that is missing, a dead signal,
    a speed that is not steady. Of rows more than one control tick apart, extremes, distortion and noise are
    undefined, and every other number says that faster components fold into it.

    Args:
        block: a capture, a stream or a table; its time base gives the rate.
        profile: of the motor, for pole pairs and rating, and of the sensors.
        analyses: `[analyses]` of a plan: what is left out, and what is asked for, as
            `{"step": {"signal": "omega_m", "reference": "omega_m_reference"}}`.
        transducer: the true torque, channel torque_transducer, covering the block's time.
        from_s: leave out what is earlier than this after the first row.
        to_s: leave out what is later, likewise.
        on: the day of the recording, by which calibrations are judged; None leaves that out.

    Raises:
        AnalysisError: no row, none in the window, or `analyses` names what there is not.
        PlugInError: an analysis of another package fails.
    """
    asked = analyses if isinstance(analyses, Analyses) else analyses_of(analyses)
    window = block.crop(from_s, to_s)
    calibration = Calibration(profile.bench, on)
    return analyze_block(window, profile.motor, asked, transducer=transducer, calibration=calibration)


def analyses_of(table: Mapping[str, Any]) -> Analyses:
    """`[analyses]` as a mapping, checked against the catalogue.

    Raises:
        AnalysisError: a key or a value is wrong; the message names it.
    """
    try:
        return Analyses.model_validate(table)
    except ValidationError as failed:
        raise AnalysisError(f"[analyses] {explain(Analyses, failed)}") from None


def analyze_block(
    block: Block,
    motor: Motor,
    analyses: Analyses = EVERYTHING,
    *,
    transducer: Block | None = None,
    calibration: Calibration | None = None,
) -> BlockResult:
    """As `analyze`, of a whole block, with what is known of the sensors on the day of the recording."""
    calibration = calibration or Calibration()
    if not len(block.data):
        raise AnalysisError(
            f"a block of {', '.join(block.names) or 'no channel'} without rows: nothing was recorded, record "
            f"again"
        )

    def todo(block: Block, transducer: Block | None) -> tuple[Planned, ...]:
        window = Window.of(block, motor, transducer)
        rotation = Rotation.of(window, motor)
        steady = window if analyses.steady else None
        return tuple(_as_rotating(each, rotation) for each in planned(analyses, steady, window))

    here = todo(block, transducer)
    found = _marked(measure_each(here), block)
    blocks = [block] if transducer is None else [block, transducer]
    instruments = Instruments(calibration.bench, blocks)

    numbers = [each for findings in found.values() for each in findings.measurements]

    def again(altered: Perturbed) -> Iterable[Measurement]:
        shaft = None if transducer is None else altered.of(transducer)
        try:
            return tuple(remeasured(todo(altered.of(block), shaft), altered.channel, found))
        except AnalysisError:  # a measurement that is not found again has an unknown uncertainty
            return ()

    applied = instruments.applied(list(_as_resolved(numbers, block)), again)
    measurements = with_common_band(
        applied, block, transducer, lambda narrow: todo(narrow, transducer), instruments
    )
    names = (name for each in blocks for name in each.names)
    tables = (each for findings in found.values() for each in findings.tables)
    return BlockResult(
        block,
        transducer,
        measurements,
        found,
        without_channels(here),
        calibration.overdue(names),
        instruments.applied_to(tables),
    )


def _as_rotating(each: Planned, rotation: Rotation) -> Planned:
    """Return the refused where it needs a rotation that the rows do not show; what needs none does without
    periods."""
    if not (rotation.folded or rotation.untold) or not each.analysis.of_steady_state:
        return each
    if rotation.folded and not ROTATING.isdisjoint(each.analysis.needs(each.settings)):
        return replace(each, refusal=rotation.folded)
    if ROTATING.isdisjoint(each.analysis.needs(each.settings)):
        return replace(each, window=replace(each.window, block=without(each.window.block, ROTATING)))
    return each


def _marked(findings: Mapping[str, Findings], block: Block) -> dict[str, Findings]:
    """Return the findings with tables that say what folds into them."""
    if block.stride == 1:
        return dict(findings)
    text = _folded(block)
    return {
        name: replace(
            found,
            tables=tuple(replace(each, definition=f"{each.definition}; {text}") for each in found.tables),
        )
        for name, found in findings.items()
    }


def _folded(block: Block) -> str:
    band = raw(0.5 * block.sample_rate_Hz, 6)
    return f"rows {block.stride} control ticks apart: what lies above {band} Hz folds into it"


def _as_resolved(numbers: Sequence[Measurement], block: Block) -> Iterator[Measurement]:
    """Yield the numbers as far as rows `block.stride` control ticks apart tell them."""
    if block.stride == 1:
        yield from numbers
        return
    apart, band_Hz = f"{block.stride} control ticks apart", 0.5 * block.sample_rate_Hz
    remedy = "capture, or stream every tick"
    unseen = f"the rows are {apart}, extremes between them are not seen: {remedy}"
    band = raw(band_Hz, 6)
    folded = f"the rows are {apart}, harmonics and noise above {band} Hz fold onto those below: {remedy}"
    for each in numbers:
        match each.sensitivities.content:
            case Extremes():
                reason = each.reason or unseen
            case Harmonics() | Largest() | Noise():
                reason = each.reason or folded
            case _:
                reason = each.reason
        if reason:
            yield Measurement.undefined(each.name, each.unit, each.definition, reason, each.basis)
        else:
            yield replace(each, definition=f"{each.definition}; {_folded(block)}")
