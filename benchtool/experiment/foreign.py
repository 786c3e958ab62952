"""Numbers of a table that another tool recorded: what its columns and its time stamps allow, and no more."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Basis, Measurement, Table, measurements_to_json, tables_to_json
from benchtool.analysis.angle import angle_coverage, revolution_rows, unwrapped_angle
from benchtool.analysis.current import CurrentSpectrum, current_spectrum
from benchtool.analysis.order_spectrum import fitted_orders
from benchtool.analysis.orders import Orders, describe_orders, order_analysis
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.ripple import record_basis, ripple_of_rows
from benchtool.analysis.timebase import TimeBase, held_rows, time_base
from benchtool.analysis.validity import require_signal
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from benchtool.recording.text_layout import BLANKS
from benchtool.recording.text_table import Rows, Selection, TextTable

QUANTITIES: Mapping[str, str] = {"current": "A", "torque": "Nm", "angle": "rad", "speed": "rad/s"}
"""What a column may be, and the SI unit that its values become."""

_MEASURED = ("torque", "current", "speed")
_LARGEST_MEAN = 0.5  # of the largest sinusoid: beyond it the current is not that of a phase
_LEAST_SHARE = 0.1  # of the power of the ripple in the largest sinusoid
_ROTATING_FRAME = re.compile(r"(?<![a-z])i[\s_]*[dq]\b|\b[dq][\s_-]*(axis|current)", re.IGNORECASE)
_AC_NUMBERS = (
    ("fundamental_frequency", "Hz", "frequency of the largest sinusoid"),
    ("current_fundamental", "A", "peak amplitude of the largest sinusoid"),
    ("current_thd", "%", "harmonics in percent of the fundamental"),
)


_Result = TypeVar("_Result", Measurement, Table)


@dataclass(frozen=True)
class TableQuestion:
    """Which columns of a file are what.

    `time`, and `columns` by names of `QUANTITIES`, are as `TextTable.select` takes them; `from_s` and `to_s`
    are on the file's own time axis.
    """

    file: Path
    time: str
    columns: Mapping[str, str]
    pole_pairs: int | None = None
    slots: int | None = None
    torque_rated_Nm: float | None = None
    from_s: float = -math.inf
    to_s: float = math.inf


@dataclass(frozen=True)
class TableAnswer:
    """What a table measured; `source` says what was read of it and how its time stamps were understood."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    source: Mapping[str, Any]

    def to_json(self) -> dict[str, Any]:
        """The case as the JSON document of a run lists one, with its source."""
        return {
            "source": dict(self.source),
            "measurements": measurements_to_json(self.measurements),
            "tables": tables_to_json(self.tables),
        }


def analyze_table(question: TableQuestion) -> TableAnswer:
    """Mean and ripple of every column; the spectrum of a phase current; orders where there is an angle.

    Ripple and orders by angle need no even time steps. What does, a spectrum, is undefined with the reason
    where the time stamps are uneven or rows are missing. A current whose mean is above half of its largest
    sinusoid, in which no sinusoid has a tenth of the power, or whose name is that of a d- or q-current, is
    taken as one in rotating coordinates: fundamental and distortion are undefined, its ripple is given. The
    numbers of a dead column are undefined, those of the others are not.

    Raises:
        RecordingError: the file cannot be read as a table.
        AnalysisError: a column is missing, or no rows are left.
    """
    table = TextTable.open(question.file)
    chosen = {"time": table.select(question.time, "s")}
    chosen |= {what: table.select(name, QUANTITIES[what]) for what, name in question.columns.items()}
    for number, twice in Counter(each.number for each in chosen.values()).items():
        if twice > 1:
            which = " and ".join(what for what, each in chosen.items() if each.number == number)
            raise AnalysisError(
                f"column {number} of {question.file} is asked for as {which}: name a column for each"
            )
    rows = table.rows(list(chosen.values()))
    if not len(rows.data):
        reasons = ", ".join(f"{count} with {why}" for why, count in rows.dropped.items())
        cell = table.unreadable_cell(list(chosen.values()))
        first = f", the first {cell}" if cell else ""
        raise AnalysisError(
            f"{question.file} has no row with a number in each column asked for, of {rows.read} rows"
            f"{f' {reasons}' if reasons else ''}{first}: check the columns; times "
            f"in seconds, and numbers without thousands separators, are expected"
        )
    time_s = rows.data[:, 0]
    inside = (time_s >= question.from_s) & (time_s <= question.to_s)
    if not inside.any():
        raise AnalysisError(
            f"no row of {question.file} is from {question.from_s:g} s to {question.to_s:g} s, it has "
            f"{time_s.min():g} s to {time_s.max():g} s: choose a span within"
        )
    data = rows.data if inside.all() else rows.data[inside]
    record = _Record(data, time_base(data[:, 0], data[:, 1:]), _channels(chosen), question)
    results = list(record.results())
    tables = tuple(each for each in results if isinstance(each, Table))
    measurements = tuple(each for each in results if isinstance(each, Measurement))
    return TableAnswer(measurements, tables, _source(table, chosen, rows, record))


@dataclass(frozen=True)
class _Record:
    """Rows in SI units, the time first; `channels` are the other columns, by what they are."""

    data: NDArray[np.float64]
    base: TimeBase
    channels: Mapping[str, Channel]
    question: TableQuestion

    @property
    def block(self) -> Block | None:
        """The rows as a block, perhaps with gaps, if their time stamps are even."""
        if self.base.refusal:
            return None
        channels = tuple(self.channels.values())
        return Block(channels, 0, 1, self.base.step_s, self.data[:, 1:], self.base.gaps)

    @property
    def uniform(self) -> Block | None:
        """The block, if no rows are missing."""
        return None if self.base.gaps else self.block

    @property
    def basis(self) -> Basis:
        """What the rows are, whatever is made of them."""
        duration_s = float(np.ptp(self.data[:, 0]))
        rate_Hz = None if self.base.refusal else self.base.rate_Hz
        gaps = None if self.base.refusal or not self.base.gaps_known else len(self.base.gaps)
        return Basis(len(self.data), rate_Hz, duration_s, gaps=gaps)

    @property
    def uneven(self) -> str:
        """Why nothing that needs even steps can be said."""
        return self.base.refusal or (
            f"{self.base.missing_rows} rows are missing in {len(self.base.gaps)} gaps, the first before row "
            f"{self.base.gaps[0].row + 1}"
        )

    def column(self, what: str) -> NDArray[np.float64]:
        return self.data[:, 1 + list(self.channels).index(what)]

    def results(self) -> Iterator[Measurement | Table]:
        for what in _MEASURED:
            if what not in self.channels:
                continue
            if reason := self._dead(what):
                yield from self._undefined(what, reason)
                continue
            if what == "current":
                yield from self._current()
            else:
                yield from self._ripple(what)
            if what != "speed" and "angle" in self.channels:
                yield from self._orders(what)

    def _dead(self, what: str) -> str:
        """Why a column says nothing at all, or nothing."""
        try:
            require_signal(self.column(what), self.channels[what].name)
        except AnalysisError as refused:
            return str(refused)
        return ""

    def _undefined(self, what: str, reason: str) -> Iterator[Measurement]:
        name, unit = self.channels[what].name, self.channels[what].unit
        numbers = [
            (f"{what}_mean", unit, "mean"),
            (f"{what}_ripple_pp", unit, "maximum minus minimum"),
            (f"{what}_ripple_rms", unit, "rms about the mean"),
        ]
        if what == "current":
            numbers = [*_AC_NUMBERS, *numbers]
        for number, of, definition in numbers:
            yield Measurement.undefined(number, of, f"{definition} of {name}", reason, self.basis)

    def _ripple(self, what: str) -> Iterator[Measurement]:
        channel, basis, rows = self.channels[what], self.basis, ""
        if self.uniform is not None:
            basis = replace(record_basis(self.uniform), gaps=basis.gaps)
        else:
            rows = f", over {len(self.data)} rows, each counting the same whatever the time between them"
        begins, repeated = self._repetition()
        rated = self.question.torque_rated_Nm if what == "torque" else None
        for each in ripple_of_rows(
            np.ascontiguousarray(self.column(what)),
            channel.unit,
            what,
            basis,
            rated=rated,
            begins=begins,
            repeated=repeated,
            what=channel.name,
        ):
            number = replace(each, definition=_before_reason(each.definition, rows))
            yield self._limited(number, held_rows(self.column(what)))

    def _repetition(self) -> tuple[NDArray[np.int64] | None, str]:
        """The rows at which what repeats begins, and what that is: electrical periods, else revolutions."""
        track = self._scatter_track() if self.uniform is not None else None
        if track is not None:
            return track.period_rows(), "electrical periods"
        if "angle" not in self.channels:
            return None, ""
        angle = self.channels["angle"].name
        try:
            coverage = angle_coverage(self.column("angle"), angle)
        except AnalysisError:
            return None, ""
        return revolution_rows(coverage.angle_rad), f"revolutions of {angle}"

    def _limited(self, number: Measurement, held: int) -> Measurement:
        """The number with a basis that claims no more than the rows hold."""
        if held == 1 or number.basis.bandwidth_Hz is None:
            return number
        bandwidth_Hz = 0.5 * self.base.rate_Hz / held
        definition = _before_reason(number.definition, f", each value held for {held} rows")
        return replace(number, definition=definition, basis=replace(number.basis, bandwidth_Hz=bandwidth_Hz))

    def _current(self) -> Iterator[Measurement | Table]:
        name = self.channels["current"].name
        try:
            spectrum = self._current_spectrum(name)
        except AnalysisError as refused:
            for number, unit, definition in _AC_NUMBERS:
                yield Measurement.undefined(number, unit, f"{definition} of {name}", str(refused), self.basis)
            yield from self._ripple("current")
            return
        yield from spectrum.measurements
        yield from spectrum.tables

    def _current_spectrum(self, name: str) -> CurrentSpectrum:
        """Raises AnalysisError with the reason why there is none."""
        if self.uniform is None:
            raise AnalysisError(self.uneven)
        if (held := held_rows(self.column("current"))) > 1:
            raise AnalysisError(
                f"each value is held for {held} rows, the current was sampled at about "
                f"{self.base.rate_Hz / held:.4g} Hz and not at {self.base.rate_Hz:.4g} Hz: export each once"
            )
        if _ROTATING_FRAME.search(name):
            raise AnalysisError(
                f"'{name}' is by its name a current in rotating coordinates, which has no fundamental"
            )
        track = self._angle_track()
        if track is not None and (reason := self._contradiction(track)):
            raise AnalysisError(reason)
        if track is None:
            track = track_tone(self.column("current"), name)
        if reason := self._not_ac(track):
            raise AnalysisError(reason)
        found = current_spectrum(self.uniform, name, track, rate_relative=self.base.rate_relative)
        if self.base.gaps_known:
            return found
        return replace(
            found,
            measurements=tuple(_without_gaps(each) for each in found.measurements),
            tables=tuple(_without_gaps(each) for each in found.tables),
        )

    def _angle_track(self) -> PhaseTrack | None:
        """Electrical periods from angle and pole pairs, where both are there.

        Raises:
            AnalysisError: the angle is in another unit, the speed is not steady, or the record too short or
                too slow.
        """
        if "angle" not in self.channels or self.question.pole_pairs is None:
            return None
        angle = unwrapped_angle(self.column("angle"), self.channels["angle"].name)
        track = track_angle(angle, self.question.pole_pairs)
        if track.periods > 0.5 * track.samples:
            raise AnalysisError(
                f"'{self.channels['angle'].name}' has {track.periods:.4g} electrical periods in "
                f"{track.samples} rows, at least two rows for each are needed: check the angle's unit, and "
                f"the pole pairs"
            )
        return track

    def _scatter_track(self) -> PhaseTrack | None:
        """Electrical periods for uncertainties: of the angle, else of an ac current, else none."""
        try:
            track = self._angle_track()
        except AnalysisError:
            track = None
        if track is not None and not self._contradiction(track):
            return track
        return self._tone

    @cached_property
    def _tone(self) -> PhaseTrack | None:
        """The current's own sinusoid, if it is that of a phase."""
        if "current" not in self.channels:
            return None
        try:
            track = track_tone(self.column("current"), self.channels["current"].name)
        except AnalysisError:
            return None
        return None if self._not_ac(track) else track

    def _contradiction(self, track: PhaseTrack) -> str:
        """What speaks against a track by the angle: a current whose sinusoid is elsewhere; or nothing."""
        if "current" not in self.channels or self._share(track) >= _LEAST_SHARE or self._tone is None:
            return ""
        per_period_Hz = self.base.rate_Hz / (track.samples - 1)
        return (
            f"the largest sinusoid of '{self.channels['current'].name}' is at "
            f"{self._tone.periods * per_period_Hz:.4g} Hz, the angle with {self.question.pole_pairs} pole "
            f"pairs says {track.periods * per_period_Hz:.4g} Hz: check the angle's unit and the pole pairs"
        )

    def _amplitude(self, track: PhaseTrack) -> float:
        """Of the current's sinusoid at the track's frequency, by correlation under a Hann window."""
        samples = self.column("current")
        window = np.hanning(len(samples))
        carrier = np.exp(-1j * track.phase(np.arange(len(samples), dtype=np.float64)))
        about = samples - np.mean(samples)
        return float(2.0 * abs(np.sum(window * carrier * about)) / np.sum(window))

    def _share(self, track: PhaseTrack) -> float:
        """How much of the power of the current's ripple is in that sinusoid."""
        deviation = float(np.std(self.column("current")))
        return 0.5 * (self._amplitude(track) / deviation) ** 2 if deviation > 0.0 else 0.0

    def _not_ac(self, track: PhaseTrack) -> str:
        """Why this is no current of a phase, or nothing."""
        mean, amplitude = float(np.mean(self.column("current"))), self._amplitude(track)
        if abs(mean) > _LARGEST_MEAN * amplitude:
            return (
                f"its mean is {abs(mean):.3g} A and its fundamental {amplitude:.3g} A peak, that of a phase "
                f"current has a mean near zero: it is taken as a current in rotating coordinates"
            )
        if (share := self._share(track)) < _LEAST_SHARE:
            return f"no sinusoid stands out, the largest has {100 * share:.2g} % of the ripple's power"
        return ""

    def _orders(self, what: str) -> Iterator[Measurement | Table]:
        channel, angle = self.channels[what], self.channels["angle"]
        machine = (self.question.pole_pairs, self.question.slots)
        try:
            orders = self._found_orders(what, channel, angle, machine)
        except AnalysisError as refused:
            definition = f"order with the largest peak amplitude of {channel.name} on {angle.name}"
            yield Measurement.undefined(f"{what}_order_largest", "", definition, str(refused), self.basis)
            return
        yield from orders.measurements
        yield from orders.tables

    def _found_orders(
        self, what: str, channel: Channel, angle: Channel, machine: tuple[int | None, int | None]
    ) -> Orders:
        pole_pairs, slots = machine
        if self.block is not None:
            return order_analysis(
                self.block, channel.name, what, angle=angle.name, pole_pairs=pole_pairs, slots=slots
            )
        coverage = angle_coverage(self.column("angle"), angle.name)
        values = self.column(what)
        spectrum = fitted_orders(coverage, values, channel.name, channel.unit, angle.name, self.basis)
        return describe_orders(spectrum, what, pole_pairs, slots)


def _without_gaps(number: _Result) -> _Result:
    """With a basis that does not say how many gaps there are: the stamps do not tell."""
    return replace(number, basis=replace(number.basis, gaps=None))


def _before_reason(definition: str, words: str) -> str:
    """The definition with more words, before the reason why the number is undefined, where there is one."""
    text, mark, reason = definition.partition("; undefined here: ")
    return f"{text}{words}{mark}{reason}"


def _channels(chosen: Mapping[str, Selection]) -> dict[str, Channel]:
    """A channel for each column but the time, by its name in the file, or its number where that is none."""
    names = [each.name for each in chosen.values()]
    return {
        what: Channel(
            each.name if each.name and names.count(each.name) == 1 else f"column {each.number} as {what}",
            each.si_unit,
        )
        for what, each in chosen.items()
        if what != "time"
    }


def _source(table: TextTable, chosen: Mapping[str, Selection], rows: Rows, record: _Record) -> dict[str, Any]:
    base, delimiter = record.base, table.layout.delimiter
    understood = {
        "uniform": record.uniform is not None,
        "why_not": "" if record.uniform is not None else record.uneven,
        "begin_s": base.begin_s,
        "rate_Hz": math.nan if base.refusal else base.rate_Hz,
        "jitter_s": base.jitter_s,
        "resolution_s": base.resolution_s,
        "gaps": len(base.gaps) if base.gaps_known else None,
        "rows_missing": base.missing_rows if base.gaps_known else None,
    }
    return {
        "file": str(table.path),
        "encoding": table.encoding,
        "delimiter": "blanks" if delimiter == BLANKS else delimiter,
        "decimal": table.layout.decimal,
        "head_lines": table.layout.head_lines,
        "columns": {
            what: {
                "number": each.number,
                "name": each.name,
                "unit": each.unit,
                "unit_from": each.unit_from,
            }
            for what, each in chosen.items()
        },
        "rows_read": rows.read,
        "rows_dropped": dict(rows.dropped),
        "rows_used": len(record.data),
        "time": {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in understood.items()
        },
    }
