"""Numbers of a table that another tool recorded: what its columns and its time stamps allow, and no more."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Basis, Measurement, Table, measurements_to_json, tables_to_json
from benchtool.analysis.angle import angle_coverage
from benchtool.analysis.current import CurrentSpectrum, current_spectrum
from benchtool.analysis.order_spectrum import fitted_orders
from benchtool.analysis.orders import Orders, describe_orders, order_analysis
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.ripple import ripple, ripple_numbers
from benchtool.analysis.timebase import TimeBase, time_base
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from benchtool.recording.text_layout import BLANKS
from benchtool.recording.text_table import Rows, Selection, TextTable

QUANTITIES: Mapping[str, str] = {"current": "A", "torque": "Nm", "angle": "rad", "speed": "rad/s"}
"""What a column may be, and the SI unit that its values become."""

_MEASURED = ("torque", "current", "speed")
_LARGEST_MEAN = 0.5  # of the largest sinusoid: beyond it the current is not that of a phase
_LEAST_SHARE = 0.1  # of the power of the ripple in the largest sinusoid
_ROTATING_FRAME = re.compile(r"i[\s_]*[dq]\b|\b[dq][\s_-]*(axis|current)", re.IGNORECASE)
_AC_NUMBERS = (
    ("fundamental_frequency", "Hz", "frequency of the largest sinusoid"),
    ("current_fundamental", "A", "peak amplitude of the largest sinusoid"),
    ("current_thd", "%", "harmonics in percent of the fundamental"),
)


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
    taken as one in rotating coordinates: fundamental and distortion are undefined, its ripple is given.

    Raises:
        RecordingError: the file cannot be read as a table.
        AnalysisError: a column is missing or dead, or no rows are left.
    """
    table = TextTable.open(question.file)
    chosen = {"time": table.select(question.time, "s")}
    chosen |= {what: table.select(name, QUANTITIES[what]) for what, name in question.columns.items()}
    rows = table.rows(list(chosen.values()))
    if not len(rows.data):
        reasons = ", ".join(f"{count} with {why}" for why, count in rows.dropped.items())
        raise AnalysisError(
            f"{question.file} has no row with a number in each column asked for, of {rows.read} rows"
            f"{f' {reasons}' if reasons else ''}: check columns and decimal sign"
        )
    time_s = rows.data[:, 0]
    inside = (time_s >= question.from_s) & (time_s <= question.to_s)
    if not inside.any():
        raise AnalysisError(
            f"no row of {question.file} is from {question.from_s:g} s to {question.to_s:g} s, it has "
            f"{time_s.min():g} s to {time_s.max():g} s: choose a span within"
        )
    data = rows.data if inside.all() else rows.data[inside]
    record = _Record(data, time_base(data[:, 0]), _channels(chosen), question)
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
        gaps = None if self.base.refusal else len(self.base.gaps)
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
            if what == "current":
                yield from self._current()
            else:
                yield from self._ripple(what)
            if what != "speed" and "angle" in self.channels:
                yield from self._orders(what)

    def _ripple(self, what: str) -> Iterator[Measurement]:
        rated = self.question.torque_rated_Nm if what == "torque" else None
        channel = self.channels[what]
        if self.uniform is not None:
            track = self._angle_track() if what == "torque" else None
            yield from ripple_numbers(self.uniform, channel.name, what, rated=rated, track=track)
            return
        found = ripple(self.column(what), channel.unit, channel.name)
        rows = f"over {len(self.data)} rows, each counting the same whatever the time between them"
        values = (
            (f"{what}_mean", found.mean, f"mean of {channel.name} {rows}"),
            (f"{what}_ripple_pp", found.peak_to_peak, f"maximum minus minimum of {channel.name} {rows}"),
            (f"{what}_ripple_rms", found.rms, f"rms of {channel.name} about its mean {rows}"),
        )
        for name, value, definition in values:
            yield Measurement(name, value, channel.unit, definition, self.basis)
        if rated is not None:
            definition = f"100 x {what}_ripple_pp / rated torque of {rated:g} Nm {rows}"
            percent = 100.0 * found.peak_to_peak / rated
            yield Measurement(f"{what}_ripple_percent_of_rated", percent, "%", definition, self.basis)

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
        track = self._angle_track() or track_tone(self.column("current"), name)
        if reason := self._not_ac(name, track):
            raise AnalysisError(reason)
        return current_spectrum(self.uniform, name, track)

    def _angle_track(self) -> PhaseTrack | None:
        """Electrical periods from angle and pole pairs, where both are there and the speed is steady."""
        if "angle" not in self.channels or self.question.pole_pairs is None:
            return None
        try:
            return track_angle(self.column("angle"), self.question.pole_pairs)
        except AnalysisError:  # another speed within the record, or too short: a number without uncertainty
            return None

    def _not_ac(self, name: str, track: PhaseTrack) -> str:
        """Why this is no current of a phase, or nothing."""
        if _ROTATING_FRAME.search(name):
            return f"'{name}' is by its name a current in rotating coordinates, which has no fundamental"
        samples = self.column("current")
        mean = float(np.mean(samples))
        # a sinusoid at the track's frequency, by correlation under a Hann window
        window = np.hanning(len(samples))
        carrier = np.exp(-1j * track.phase(np.arange(len(samples), dtype=np.float64)))
        amplitude = 2.0 * abs(np.sum(window * carrier * (samples - mean))) / float(np.sum(window))
        if abs(mean) > _LARGEST_MEAN * amplitude:
            return (
                f"its mean is {abs(mean):.3g} A and its fundamental {amplitude:.3g} A peak, that of a phase "
                f"current has a mean near zero: it is taken as a current in rotating coordinates"
            )
        share = 0.5 * (amplitude / float(np.std(samples))) ** 2
        if share < _LEAST_SHARE:
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
        "gaps": len(base.gaps),
        "rows_missing": base.missing_rows,
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
