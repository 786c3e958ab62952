"""From a question on a table to its answer, with the interpretation of the file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from benchtool.analysis import Measurement, Table, measurements_to_json, tables_to_json
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.tables.asked_analyses import with_analyses
from benchtool.tables.cells import BLANKS
from benchtool.tables.columns import TableColumns, TableQuestion, read_columns
from benchtool.tables.kept import KeptTable, measured, sensors_of
from benchtool.tables.record import Record, time_base_of
from benchtool.tables.remarks import (
    Remark,
    RemarkKind,
    numbers_in_head,
    of_clock,
    of_signals,
    of_stretch,
    of_tables,
    other_frequency,
    other_head,
    other_interval,
    other_speed,
    overdue,
    remarks,
)
from benchtool.tables.sensed_columns import SIGNALS, bench_of_columns
from benchtool.tables.unit_remarks import electrical, other_units, units_assumed, units_contradicted


@dataclass(frozen=True)
class TableAnswer:
    """Measurements of a table; `source` describes what was read and how its time stamps were interpreted.

    `record` has the rows that were used, `kept` what else the measurements rest on, `quantities`
    the names of its columns without their units in the file, `remarks` describe oddities.
    """

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    source: Mapping[str, Any]
    record: Record
    kept: KeptTable
    quantities: Mapping[str, str]
    remarks: tuple[Remark, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Return the case as the JSON document of a run lists one, with its source."""
        return {
            "source": dict(self.source),
            "remarks": [each.to_json() for each in self.remarks],
            "measurements": measurements_to_json(self.measurements),
            "tables": tables_to_json(self.tables),
        }


def analyze_table(question: TableQuestion) -> TableAnswer:
    """Return the mean and ripple of every column; the spectrum of a phase current, and of three the
    symmetrical components; orders where there is an angle.

    Ripple and orders by angle need no even time steps. A spectrum does, and is undefined with the reason
    where the time stamps are uneven; where rows are missing it is of the longest stretch without one. A
    current whose mean is above half of its largest sinusoid, in which no sinusoid has a tenth of the power,
    or whose name is that of a d- or q-current, is not taken as that of a phase: fundamental and distortion
    are undefined, its ripple is given. The numbers of a dead column are undefined, those of the others are
    not.

    Raises:
        RecordingError: the file cannot be read as a table.
        AnalysisError: a column is missing, no rows are left, or a sensor is stated in another unit.
    """
    columns = read_columns(question)
    base = time_base_of(columns.data, columns.joined)
    whole = Record(columns.data, base, columns.channels, question, columns.lost)
    record = with_analyses(whole.unbroken, columns.analyses)
    bench = bench_of_columns(columns, record)
    measurements, tables = measured(record, sensors_of(record, bench))
    odd = (
        *(Remark(RemarkKind.NAMED_BY_A_NUMBER, *each) for each in columns.called_by_numbers(question)),
        *numbers_in_head(columns.table.layout),
        *other_head(columns.table.layout),
        *other_interval(columns.table.layout, record),
        *units_assumed(columns.chosen),
        *units_contradicted(columns.chosen),
        *other_units(record, columns.analyses, columns.chosen),
        *electrical(columns.chosen, question.pole_pairs),
        *of_clock(columns.clock, columns.chosen.get("time")),
        *of_tables(columns.joined),
        *remarks(record),
        *of_stretch(record, measurements),
        *other_frequency(record, measurements),
        *other_speed(record),
        *of_signals(measurements),
        *overdue(bench, question.day),
    )
    kept = KeptTable.of(record, columns.joined, bench)
    return TableAnswer(measurements, tables, _source(columns, record), record, kept, columns.quantities, odd)


def table_block(question: TableQuestion) -> Block:
    """Return the columns of a table as a block, called as a drive calls them: i_a, torque, theta_m, omega_m.

    Whatever measures captures and streams measures it too; rows that are missing by the time stamps are gaps.

    Raises:
        RecordingError: the file cannot be read as a table.
        AnalysisError: a column is missing, no rows are left, or the time stamps are not even.
    """
    columns = read_columns(question)
    base = time_base_of(columns.data, columns.joined)
    block = Record(columns.data, base, columns.channels, question).block
    if block is None:
        raise AnalysisError(
            f"the rows of {question.file} are not evenly spaced ({base.refusal}), and a block is: measure "
            f"them with 'benchtool analyze --csv', which needs no even steps for ripple and orders"
        )
    named = tuple(
        replace(channel, name=SIGNALS.get(what, what)) for what, channel in columns.channels.items()
    )
    return replace(block, channels=named)


def _source(columns: TableColumns, record: Record) -> dict[str, Any]:
    base, table = record.base, columns.table
    has_stamps = record.question.rate_Hz is None
    gaps = base.gaps if record.cut is None else record.cut.gaps
    understood = {
        "uniform": record.uniform is not None,
        "why_not": "" if record.uniform is not None else record.uneven,
        "begin_s": base.begin_s,
        "rate_Hz": math.nan if base.refusal else base.rate_Hz,
        "jitter_s": base.jitter_s if has_stamps else None,
        "resolution_s": base.resolution_s if has_stamps else None,
        "gaps": len(gaps) if base.gaps_known else None,
        "rows_missing": sum(gap.missing_rows for gap in gaps) if base.gaps_known else None,
        "rows_of_span": len(record.data) if record.cut is None else record.cut.rows,
    }
    delimiter = table.layout.delimiter
    return {
        "file": str(table.path),
        "recorded_on": str(record.question.day),
        "recorded_on_from": "stated" if record.question.recorded_on else "the file's last change",
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
                "gain": each.gain,
                "offset": each.offset,
            }
            for what, each in columns.chosen.items()
        },
        "rows_read": columns.rows.read,
        "rows_dropped": dict(columns.rows.dropped),
        "rows_used": len(record.data),
        "time": {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in understood.items()
        },
    }
