"""The errors of sensors in the rows of tables of lines, as in the measurement of such a line.

A row of harmonics, orders or lines is a measurement for each of its uncertainties; what a sensor does to it
is found in the same way. Other tables say that their rows are as they were read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from typing import Final

from benchtool.analysis.measurement import LineColumn, Measurement, Table
from benchtool.analysis.sensitivity import Sensitivities
from benchtool.analysis.uncertainty import Uncertainty

Apply = Callable[[Measurement], Measurement]
"""Returns a measurement with its sensors."""

AS_READ: Final = (
    "rows are as they were read: neither corrected for the sensors nor with an uncertainty of them"
)
"""Of a table whose rows no measurement is like."""

_UNKNOWN = "the noise around the line is not known"
_MOST_LISTED = 5

Row = dict[str, float]


def with_sensors(table: Table, apply: Apply) -> Table:
    """Return a table with its sensors in values and uncertainties; what was added is a column of its own."""
    if not table.lines:
        return replace(table, uncertainty_reason=table.uncertainty_reason or AS_READ)
    if not table.rows:
        return table
    names = [name for name, _ in table.columns]
    units = dict(table.columns)
    rows = [dict(zip(names, row, strict=True)) for row in table.rows]
    added, remarks, reasons = [0.0] * len(rows), dict[str, None](), dict[str, dict[int, None]]()
    for column in table.lines:
        for place, row in enumerate(rows):
            read = _read(row, column, units[column.value], table)
            found = apply(read)
            remarks |= dict.fromkeys(found.basis.sensors)
            if found.correction is not None:
                added[place] = found.correction.added
            row[column.value] = found.value
            standard = math.nan if found.uncertainty is None else found.uncertainty.standard
            known = math.isfinite(standard)
            row[column.uncertainty] = standard if known else math.nan
            if not known and math.isfinite(found.value):
                reasons.setdefault(found.uncertainty_reason, {})[place] = None
    _with_shares(rows, table)
    extra: tuple[tuple[str, str], ...] = ()
    if any(added):
        extra = (("correction", units["amplitude"]),)
        for row, each in zip(rows, added, strict=True):
            row["correction"] = each
    text = "; ".join(_of_rows(reason, places, rows) for reason, places in reasons.items())
    return replace(
        table,
        columns=table.columns + extra,
        rows=tuple(tuple(row.values()) for row in rows),
        basis=replace(table.basis, sensors=tuple(remarks)),
        uncertainty_reason=text,
    )


def _read(row: Row, column: LineColumn, unit: str, table: Table) -> Measurement:
    """Return the number of a row as a measurement."""
    value, standard = row[column.value], row[column.uncertainty]
    first_Hz, order = table.basis.frequency_Hz, row.get("order", 1.0)
    of_order_Hz = None if first_Hz is None else order * first_Hz
    basis = replace(table.basis, frequency_Hz=row[column.frequency] if column.frequency else of_order_Hz)
    known, sensed = math.isfinite(standard), Sensitivities.unmoved(column.channel)
    if column.is_amplitude:
        sensed = Sensitivities.of_line(column.channel, value)
    return Measurement(
        column.value,
        value,
        unit,
        "",
        basis,
        Uncertainty(standard, table.definition) if known else None,
        uncertainty_reason="" if known else table.uncertainty_reason or _UNKNOWN,
        sensitivities=sensed,
    )


def _with_shares(rows: list[Row], table: Table) -> None:
    """Compute the columns in percent once more, of amplitudes that are corrected."""
    if "amplitude" not in rows[0]:
        return
    place = [name for name, _ in table.columns].index("amplitude")
    bases = {"percent_of_fundamental": rows[0]["amplitude"]}
    bases["percent_of_largest"] = max(row["amplitude"] for row in rows)
    for row, read in zip(rows, table.rows, strict=True):
        for name in row:
            if name in bases and bases[name] > 0.0:
                row[name] = 100.0 * row["amplitude"] / bases[name]
            elif name == "percent_of_mean" and read[place] > 0.0:
                row[name] *= row["amplitude"] / read[place]


def _of_rows(reason: str, places: Collection[int], rows: list[Row]) -> str:
    """Return a reason with the rows that it is of."""
    if len(places) == len(rows):
        return reason
    listed = ", ".join(f"{rows[place].get('order', place + 1):.0f}" for place in [*places][:_MOST_LISTED])
    more = f" and {len(places) - _MOST_LISTED} more" if len(places) > _MOST_LISTED else ""
    what = "order" if "order" in rows[0] else "row"
    return f"{what if len(places) == 1 else f'{what}s'} {listed}{more}: {reason}"
