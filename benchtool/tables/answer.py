"""From the question that is asked of a table to its answer, which says what was read and how."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from benchtool.analysis import Measurement, Table, measurements_to_json, tables_to_json
from benchtool.analysis.instruments import Instruments
from benchtool.errors import AnalysisError
from benchtool.profile import Bench
from benchtool.tables.analyses import results
from benchtool.tables.columns import TableColumns, TableQuestion, read_columns
from benchtool.tables.layout import BLANKS
from benchtool.tables.record import Record
from benchtool.tables.remarks import Remark, remarks
from benchtool.tables.time_base import time_base

_SENSED: Mapping[str, str] = {"current": "i_a", "speed": "omega_m"}
"""Channel of a drive by what a column is, where they are called otherwise."""


@dataclass(frozen=True)
class TableAnswer:
    """What a table measured; `source` says what was read of it and how its time stamps were understood.

    `record` has the rows that were used, `remarks` tell what is odd about them.
    """

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    source: Mapping[str, Any]
    record: Record
    remarks: tuple[Remark, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The case as the JSON document of a run lists one, with its source."""
        return {
            "source": dict(self.source),
            "remarks": [each.to_json() for each in self.remarks],
            "measurements": measurements_to_json(self.measurements),
            "tables": tables_to_json(self.tables),
        }


def analyze_table(question: TableQuestion) -> TableAnswer:
    """Mean and ripple of every column; the spectrum of a phase current; orders where there is an angle.

    Ripple and orders by angle need no even time steps. What does, a spectrum, is undefined with the reason
    where the time stamps are uneven or rows are missing. A current whose mean is above half of its largest
    sinusoid, in which no sinusoid has a tenth of the power, or whose name is that of a d- or q-current, is
    not taken as that of a phase: fundamental and distortion are undefined, its ripple is given. The
    numbers of a dead column are undefined, those of the others are not.

    Raises:
        RecordingError: the file cannot be read as a table.
        AnalysisError: a column is missing, no rows are left, or a sensor is stated in another unit.
    """
    columns = read_columns(question)
    base = time_base(columns.data[:, 0], columns.data[:, 1:])
    record = Record(columns.data, base, columns.channels, question)
    found = list(results(record))
    tables = tuple(each for each in found if isinstance(each, Table))
    measured = tuple(each for each in found if isinstance(each, Measurement))
    measurements = _instruments(record).applied(measured)
    return TableAnswer(measurements, tables, _source(columns, record), record, tuple(remarks(record)))


def _instruments(record: Record) -> Instruments:
    """The sensors of the columns. When they were read is not known, nor by which clock: neither is judged."""
    stated, sensors, entries = record.question.bench.channels, {}, {}
    for what, channel in record.channels.items():
        entries[_SENSED.get(what, what)] = channel.name
        name = next((each for each in (*_names(channel.name), what) if each in stated), None)
        if name is None:
            continue
        sensors[channel.name] = sensor = stated[name]
        if sensor.unit and sensor.unit != channel.unit:
            raise AnalysisError(
                f"[bench.channels.{name}] is in {sensor.unit} and its column in {channel.unit}: state offset "
                f"and resolution in that"
            )
    columns = ", ".join(channel.name for channel in record.channels.values())
    if stated and not sensors:
        raise AnalysisError(
            f"[bench.channels] states {', '.join(stated)}, none of which is a column that is measured: call "
            f"one as its column ({columns}) or as what it is ({', '.join(record.channels)})"
        )
    blocks = () if record.block is None else (record.block,)
    return Instruments(
        Bench(channels=sensors), blocks, entries=entries, pole_pairs=record.question.pole_pairs
    )


def _names(column: str) -> tuple[str, str]:
    """Of a column in its head, with the unit behind it and without."""
    return column, re.sub(r"\s*[\[(][^\])]*[\])]\s*$", "", column)


def _source(columns: TableColumns, record: Record) -> dict[str, Any]:
    base, table = record.base, columns.table
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
    delimiter = table.layout.delimiter
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
