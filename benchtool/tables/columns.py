"""Assignment of the columns of a table, and the rows with a number in each of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import count_of
from benchtool.block import Channel
from benchtool.errors import AnalysisError, of_each
from benchtool.profile import Bench
from benchtool.tables.asked_columns import with_their_columns
from benchtool.tables.cells import Cell
from benchtool.tables.clocks import Clock, read_clock
from benchtool.tables.lost import Lost, lost_among
from benchtool.tables.names_between import Names, names_between
from benchtool.tables.selection import Selection, by_number, hides
from benchtool.tables.text import Rows, TextTable
from benchtool.tables.time_base import time_base
from benchtool.tables.unit_in_name import quantity_of

PHASES = ("current", "current_b", "current_c")
"""Kinds of the columns of three phase currents."""

QUANTITIES: Mapping[str, str] = {
    **dict.fromkeys(PHASES, "A"),
    "torque": "Nm",
    "angle": "rad",
    "speed": "rad/s",
}
"""Kinds of columns, with their SI units."""

_COMPUTED = ("tick", "time_s")  # columns that an exported stream has besides its channels


@dataclass(frozen=True)
class TableQuestion:
    """A question on a table: the assignment of its columns.

    `time`, and `columns` by names of `QUANTITIES`, are as `TextTable.select` takes them; `from_s` and `to_s`
    are on the file's own time axis. Without `time` the rows are `rate_Hz` apart, the first at 0 s.
    `omega_m_rad_s` is a constant mechanical speed, which stands in for an angle; torque in percent is that of
    `torque_rated_Nm`. `bench` states the sensors of columns by the names of these, or by what they are, and
    the clock that timed the rows; it may state those of `signals` of a drive, by their units, which are no
    columns. `recorded_on` is the day of that, without which it is that of the file's last change. `decimal`
    is the decimal sign, where the numbers leave it open. The current `is_of_phase` whatever its name says.
    `analyses` are asked for beside: their settings by name, channels as `TextTable.select` takes columns.
    """

    file: Path
    time: str | None
    columns: Mapping[str, str]
    pole_pairs: int | None = None
    slots: int | None = None
    torque_rated_Nm: float | None = None
    from_s: float = -math.inf
    to_s: float = math.inf
    rate_Hz: float | None = None
    omega_m_rad_s: float | None = None
    bench: Bench = field(default_factory=Bench)
    signals: Mapping[str, str] = field(default_factory=dict)
    recorded_on: date | None = None
    decimal: str = ""
    is_of_phase: bool = False
    analyses: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def asked(self) -> dict[str, str]:
        """The columns that are asked for, the time first if that is one."""
        return dict(self.columns) if self.time is None else {"time": self.time, **self.columns}

    @property
    def day(self) -> date:
        """The day on which the table was recorded, as far as is known.

        Raises:
            OSError: it is that of a file that is not there.
        """
        return self.recorded_on or date.fromtimestamp(self.file.stat().st_mtime)


@dataclass(frozen=True)
class TableColumns:
    """The columns that a question names.

    `chosen` has the time first, if that is a column; `data`, shape (n, 1 + columns) and in SI units, has the
    time and then the columns in that order, and of the rows that were read those in the span that the
    question asks for. `lost` says what is missing among them, `clock` what the times say of theirs, and
    `names_between` which lines of names are between rows that no column times. `analyses` are those that the
    question asks for, with kinds of `chosen` in place of columns.
    """

    table: TextTable
    chosen: Mapping[str, Selection]
    rows: Rows
    data: NDArray[np.float64]
    lost: Lost
    clock: Clock = field(default_factory=Clock)
    names_between: tuple[Names, ...] = ()
    analyses: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def joined(self) -> str:
        """Why rows that no column times are not those of one record; empty if nothing says so."""
        if not self.names_between:
            return ""
        first = self.names_between[0]
        lines = count_of(len(self.names_between), "line of names is", "lines of names are")
        return (
            f"{lines} between the rows, the first '{first.text}' at line {first.line} of the file: tables "
            f"below each other, or a head that is repeated"
        )

    @property
    def channels(self) -> dict[str, Channel]:
        """One for each column but the time, by its name in the file, or by its number if it has no name."""
        names = [each.name for each in self.chosen.values()]
        return {
            what: Channel(
                each.name if each.name and names.count(each.name) == 1 else f"column {each.number} as {what}",
                each.si_unit,
            )
            for what, each in self.chosen.items()
            if what != "time"
        }

    @property
    def quantities(self) -> dict[str, str]:
        """What values of the columns in SI are called: as in the file, without the units there."""
        names = {what: channel.name for what, channel in self.channels.items()}
        plain = {
            what: quantity_of(self.table.layout.columns[self.chosen[what].number - 1], self.chosen[what].unit)
            for what in names
        }
        taken = Counter((*plain.values(), *_COMPUTED))
        return {
            what: plain[what] if plain[what] and taken[plain[what]] == 1 else names[what] for what in names
        }

    def called_by_numbers(self, question: TableQuestion) -> Iterator[tuple[str, str]]:
        """Yield what was asked for by a number that is the name of one column and the number of another, and
        which of them it is."""
        for what, wanted in question.asked.items():
            number = by_number(wanted)
            other = None if number is None else hides(self.table.layout, number)
            if other is not None:
                read = self.chosen[what].number
                yield (
                    what,
                    f"{what} '{number}' was read as column {read}: it is the name of column {other} and the "
                    f"number of another, '#{number}' is the number",
                )


def read_columns(question: TableQuestion) -> TableColumns:
    """Return the columns asked for, in the rows that have a number in each and are in the span.

    Raises:
        RecordingError: the file cannot be read as a table.
        AnalysisError: a column is missing or asked for twice, or no rows are left.
    """
    table = TextTable.open(question.file, question.decimal, timed=question.rate_Hz is None)
    _require_one_signal(table)
    chosen, analyses = with_their_columns(table, question.analyses, _choose(table, question))
    rows = _rows(table, list(chosen.values()))
    data, clock, between = rows.data, Clock(), names_between(table, rows)
    if "time" in chosen:
        found = read_clock(chosen["time"], data[:, 0], is_one_table=not between)
        chosen["time"], data[:, 0], clock = found
        between = ()  # whether the rows go on is told by their time
    if question.rate_Hz is not None:
        if rows.left_out.broken:
            names = "".join(f", '{each.text}' at line {each.line} has names" for each in between[:1])
            raise AnalysisError(
                f"{question.file} has {count_of(rows.left_out.broken, 'row')} with a wrong "
                f"number of cells{names}, which a stated rate leaves without a time: name the column of the "
                f"time, or fix them"
            )
        data = np.column_stack([rows.place / question.rate_Hz, data])
    time_s = data[:, 0]
    inside = (time_s >= question.from_s) & (time_s <= question.to_s)
    if not inside.any():
        raise AnalysisError(
            f"no row of {question.file} is from {question.from_s:g} s to {question.to_s:g} s, it has "
            f"{time_s.min():g} s to {time_s.max():g} s: choose a span within"
        )
    places = rows.place[inside]
    between = tuple(each for each in between if places[0] < each.place <= places[-1])
    kinds = tuple(what for what in chosen if what != "time")
    lost_s = np.interp(rows.left_out.place, rows.place, time_s)
    in_span = (lost_s >= question.from_s) & (lost_s <= question.to_s)
    lost = lost_among(rows, inside, in_span, kinds, table.first_left_out(rows, list(chosen.values())))
    if lost.within and _are_of_another_raster(rows, in_span, kinds, time_s[inside]):
        lost = Lost(lost.left_out, first=lost.first)
    within = data if inside.all() else data[inside]
    return TableColumns(table, chosen, rows, within, lost, clock, between, analyses)


def _are_of_another_raster(
    rows: Rows, in_span: NDArray[np.bool_], kinds: Sequence[str], time_s: NDArray[np.float64]
) -> bool:
    """Return whether the rows that were left out are those of other signals, which are listed at other times:
    none of them has a value of a column asked for, and the others are at even distances without them."""
    cells = rows.left_out.cells[in_span, -len(kinds) :]
    if rows.left_out.broken or not np.all(cells == Cell.MISSING):
        return False
    base = time_base(time_s)
    return not base.refusal and not base.gaps and base.gaps_known


def _require_one_signal(table: TextTable) -> None:
    """Refuse rows that have one signal after the other.

    Raises:
        AnalysisError: a column says which signal each row has.
    """
    number = table.layout.signals
    if number:
        name = table.layout.columns[number - 1].name
        called = f" '{name}'" if name else ""
        raise AnalysisError(
            f"column {number}{called} of {table.path} says of each row which signal it has, over and over "
            f"again: a column for each signal is expected, export it in wide form"
        )


def _choose(table: TextTable, question: TableQuestion) -> dict[str, Selection]:
    """Return the time and the columns asked for, no two of them the same."""
    asked = _numbered(table, question.asked)
    units, rated = {"time": "s", **QUANTITIES}, {"torque": question.torque_rated_Nm}
    found = of_each(lambda what: table.select(asked[what], units[what], rated.get(what)), asked)
    chosen = dict(zip(asked, found, strict=True))
    for number, twice in Counter(each.number for each in chosen.values()).items():
        if twice > 1:
            which = " and ".join(what for what, each in chosen.items() if each.number == number)
            raise AnalysisError(
                f"column {number} of {table.path} is asked for as {which}: name a column for each"
            )
    return chosen


def _numbered(table: TextTable, asked: Mapping[str, str]) -> dict[str, str]:
    """Return the columns asked for, those that are meant by number as `#2`.

    Where a column is called by the number of another one, as the channels of an oscilloscope are, a number is
    its name if another column is asked for by a name, and a number if one of them is the name of none.

    Raises:
        AnalysisError: all are numbers and names as well.
    """
    numbers = {what: by_number(wanted) for what, wanted in asked.items()}
    hidden = [number for number in numbers.values() if number and hides(table.layout, number)]
    if not hidden or any(number is None for number in numbers.values()):
        return dict(asked)
    names = {column.bare_name for column in table.layout.columns}
    if all(str(number) in names for number in numbers.values()):
        other = hides(table.layout, hidden[0])
        raise AnalysisError(
            f"'{hidden[0]}' is the name of column {other} of {table.path} and the number of another: give "
            f"'#{hidden[0]}' for the number or '#{other}' for that column, for each that is asked for"
        )
    return {what: f"#{wanted.strip()}" for what, wanted in asked.items()}


def _rows(table: TextTable, selections: list[Selection]) -> Rows:
    """Return the rows with a number in each of the columns; one at least."""
    rows = table.rows(selections)
    if len(rows.data):
        return rows
    are_numbers = rows.left_out.cells == Cell.NUMBER
    if len(selections) > 1 and are_numbers.any(axis=0).all():
        raise AnalysisError(
            f"{table.path} has no row with a number in each column asked for, though each of them has "
            f"numbers in other rows than the others: measure them one by one"
        )
    reasons = ", ".join(f"{count} with {why}" for why, count in rows.dropped.items())
    cell = table.unreadable_cell(selections)
    first = f", the first {cell}" if cell else ""
    raise AnalysisError(
        f"{table.path} has no row with a number in each column asked for, of {count_of(rows.read, 'row')}"
        f"{f' {reasons}' if reasons else ''}{first}: check the columns; times "
        f"in seconds, or as 2026-01-31 23:59:59.5, and numbers are expected"
    )
