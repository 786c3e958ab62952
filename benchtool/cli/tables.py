"""Tables of other tools, as `benchtool analyze --csv` takes and tells them."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchtool.analysis import (
    correction_notes,
    pulse_note,
    raw,
    repeatability_notes,
    sensor_remarks,
    undefined,
    without_uncertainty,
)
from benchtool.cli import options
from benchtool.cli.fitting import named
from benchtool.cli.output import Output
from benchtool.recording import Conditions, enlist
from benchtool.run import bundle_folder
from benchtool.tables import TableAnswer


def keep_table(
    output: Output,
    answer: TableAnswer,
    out: Path | None,
    *,
    with_report: bool,
    note: str,
    conditions: Conditions,
) -> dict[str, str]:
    """Write the bundle with what the operator states, and the report in it; return their paths."""
    from benchtool.report.assembly import keep  # draws in matplotlib, which numbers do not need

    when = options.wall_time()
    with bundle_folder(out, when, f"table-{answer.record.question.file.stem}") as folder:
        bundle = keep(
            answer,
            folder,
            when.isoformat(timespec="seconds"),
            sys.argv[1:],
            note=note,
            conditions=conditions,
        )
        output.line(f"bundle: {folder}")
        if not with_report:
            return {"bundle": str(folder)}
        from benchtool.cli.report import write_report
        from benchtool.report.assembly import table_report

        page, _ = write_report(table_report(bundle), folder / "report.html", pdf=False, output=output)
        enlist(folder, [page])
        return {"bundle": str(folder), "report": str(page)}


def show_table(output: Output, answer: TableAnswer) -> None:
    """Print measurements, reasons for undefined ones, and what was read."""

    rows = [(each.name, each.text, each.unit) for each in answer.measurements]
    output.table(str(answer.source["file"]), ("measurement", ">value ± U (95 %)", "unit"), rows)
    for reason, names in undefined(answer.measurements).items():
        output.sentence(f"undefined: {', '.join(names)}: {reason}")
    for reason, names in without_uncertainty(answer.measurements).items():
        output.sentence(f"without ±: {named(names)}: {reason}", "dim")
    for text in sensor_remarks(answer.measurements).values():
        output.sentence(text, "dim")
    for text in (*correction_notes(answer.measurements), *repeatability_notes(answer.measurements)):
        output.sentence(text, "dim")
    if note := pulse_note(answer.measurements):
        output.sentence(note, "dim")
    for remark in answer.remarks:
        output.sentence(f"warning: {remark.text}", "yellow")
    output.sentence(_read(answer.source))
    output.sentence(_timed(answer.source["time"]))


def _read(source: Mapping[str, Any]) -> str:
    dropped = "".join(f", {count} left out ({why})" for why, count in source["rows_dropped"].items())
    columns = "; ".join(_column_read(what, each) for what, each in source["columns"].items())
    return f"read: {source['rows_read']} rows{dropped}, {source['rows_used']} used; {columns}"


def _column_read(what: str, column: Mapping[str, Any]) -> str:
    name = f" '{column['name']}'" if column["name"] else ""
    assumed = " (assumed)" if column["unit_from"] == "assumed" else ""
    scaled = "" if column["gain"] == 1.0 else f" x {column['gain']:g}"
    scaled += f" {column['offset']:+g} {column['unit']}" if column["offset"] else ""
    return f"{what} from column {column['number']}{name}{scaled} in {column['unit']}{assumed}"


def _timed(time: Mapping[str, Any]) -> str:
    if time["uniform"]:
        untold = "" if time["gaps"] is not None else "; whether rows are missing is unknown"
        if time["jitter_s"] is None:
            return f"time: even, at the stated {raw(time['rate_Hz'])} Hz{untold}"
        return f"time: even, {raw(time['rate_Hz'])} Hz, jitter {time['jitter_s']:.2g} s rms{untold}"
    return f"time: not even, {time['why_not']}"
