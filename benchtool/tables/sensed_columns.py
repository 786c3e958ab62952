"""The sensors of the columns of a table, by what `[bench]` of a file states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from benchtool.document import closest
from benchtool.errors import AnalysisError
from benchtool.profile import Bench
from benchtool.tables.columns import PHASES, QUANTITIES, TableColumns
from benchtool.tables.head import Column
from benchtool.tables.record import Record

SIGNALS: Mapping[str, str] = {
    **dict(zip(PHASES, ("i_a", "i_b", "i_c"), strict=True)),
    "speed": "omega_m",
    "angle": "theta_m",
}
"""Signal of a drive by the kind of a column, where the names differ."""


def bench_of_columns(columns: TableColumns, record: Record) -> Bench:
    """Return the sensors of the columns that are measured, by their names, and the clock that timed the rows.

    Raises:
        AnalysisError: `[bench.channels]` states what is no channel, one that has not such errors, or none of
            the columns that are measured.
    """
    bench = record.question.bench
    if wrong := list(_faults(columns, record)):
        raise AnalysisError("; ".join(f"[bench.channels.{name}]: {reason}" for name, reason in wrong))
    stated = {what: _stated(columns, record, what) for what in record.channels}
    sensors = {
        record.channels[what].name: bench.channels[names[0]] for what, names in stated.items() if names
    }
    if bench.channels and not sensors:
        raise AnalysisError(
            f"[bench.channels] states {', '.join(bench.channels)}, none of which is a column that is "
            f"measured: {_remedy(record)}"
        )
    return Bench(channels=sensors, clock=bench.clock)


def _faults(columns: TableColumns, record: Record) -> Iterator[tuple[str, str]]:
    """Yield the sensors of unknown channels, those that state errors which their column cannot have, and
    second ones of a column, each by the name that is stated."""
    question, stated = record.question, record.question.bench.channels
    measured = [channel.name for channel in record.channels.values()]
    columns_of_table = {name for each in columns.table.layout.columns for name in _names(each)}
    known = {*columns_of_table, *measured, *QUANTITIES, *SIGNALS.values(), *question.signals}
    for name in stated:
        if name not in known:
            meant = closest(name, [*measured, *record.channels])
            yield name, f"no column of {columns.table.path} and no channel of a drive: {meant}"
    of_columns: set[str] = set()
    for what, channel in record.channels.items():
        called = _stated(columns, record, what)
        of_columns |= set(called)
        for name in called[:1]:
            if reason := stated[name].misfit(channel.unit):
                yield name, f"its column '{channel.name}' {reason}"
        own = [name for name in called if name != SIGNALS.get(what)]
        if len(own) > 1:
            yield own[1], f"'{own[0]}' is stated too, which is the same column: leave one out"
    for name in set(question.signals).intersection(stated) - of_columns - columns_of_table:
        if reason := stated[name].misfit(question.signals[name]):
            yield name, f"'{name}' {reason}"


def _stated(columns: TableColumns, record: Record, what: str) -> list[str]:
    """Return the names by which a column's sensor is stated, the one that counts first: that of the column,
    with the unit behind it or without, what it is, and what a drive calls that."""
    column = columns.table.layout.columns[columns.chosen[what].number - 1]
    called = (record.channels[what].name, *_names(column), what, SIGNALS.get(what, what))
    return [name for name in dict.fromkeys(called) if name in record.question.bench.channels]


def _names(column: Column) -> tuple[str, ...]:
    """Return what a head calls a column, with the unit behind the name and without."""
    found = (column.name, column.bare_name, column.name_before_brackets, column.other_name, *column.aliases)
    return tuple(filter(None, found))


def _remedy(record: Record) -> str:
    listed = ", ".join(channel.name for channel in record.channels.values())
    return f"call one as its column ({listed}) or as what it is ({', '.join(record.channels)})"
