"""A measured table as a run bundle, and as a report: data, numbers and the interpretation of the file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from benchtool.analysis import (
    measurements_from_json,
    measurements_to_json,
    raw,
    sensor_remarks,
    tables_from_json,
    tables_to_json,
)
from benchtool.block import Block, Channel
from benchtool.recording import Bundle, BundleWriter, Conditions, Manifest, hash_of, software_versions
from benchtool.report import content
from benchtool.report.assembly.front import ROLES, fingerprint
from benchtool.report.content import Item, Picture, Report, Section, Signatures, Text
from benchtool.report.figures.overview import draw_channels
from benchtool.report.provenance import files_section, run_facts
from benchtool.report.results import budgets_section, measurements_section, tables_section
from benchtool.results import TABLE
from benchtool.tables import TableAnswer


def keep(
    answer: TableAnswer,
    folder: Path,
    when: str,
    command_line: Sequence[str],
    *,
    note: str = "",
    conditions: Conditions | None = None,
) -> Bundle:
    """Write the rows that were used, in SI units, with measurements and tables, as a bundle of its own.

    The time is a column of the stream `table`; where it is not even the rows are numbered a median step
    apart, and `uniform` of the source is false. The manifest's details hold the source, with the SHA-256 of
    the file.

    Raises:
        RecordingError: the folder has content or cannot be written, or the file cannot be read again.
    """
    record = answer.record
    file = record.question.file
    hashed = hash_of(file)
    manifest = Manifest(
        what=f"table {file.name}",
        when=when,
        versions=software_versions(),
        command_line=tuple(command_line),
        note=note,
        conditions=conditions or Conditions(),
        details={
            "source": dict(answer.source) | {"hash": hashed.model_dump()},
            "remarks": [each.to_json() for each in answer.remarks],
            "table": answer.kept.to_json(),
        },
    )
    with BundleWriter(folder, manifest) as bundle:
        bundle.append(TABLE, _block(answer))
        return bundle.finish(
            measurements_to_json(answer.measurements), verdict="none", tables=tables_to_json(answer.tables)
        )


def table_report(bundle: Bundle) -> Report:
    """Return the report of a table that `keep` has written, with the measurements of that time.

    Raises:
        RecordingError, AnalysisError: the bundle cannot be read, or was not written by `keep`.
    """
    manifest = bundle.manifest
    measurements = measurements_from_json(bundle.measurements)
    undefined: dict[str, list[str]] = {}
    for each in measurements:
        if each.reason:
            undefined.setdefault(each.reason, []).append(each.name)
    front: list[Item] = [
        content.Verdict("none", f"{content.SYMBOLS['none']} No limits", "A table of another tool, measured.")
    ]
    front += [Text(f"{each['text']}.", "warning") for each in manifest.details.get("remarks", ())]
    front += [
        Text(f"Undefined: {', '.join(names)}: {reason}.", "note") for reason, names in undefined.items()
    ]
    front += [Text(f"{text[0].upper()}{text[1:]}.", "note") for text in sensor_remarks(measurements).values()]
    source = manifest.details["source"]
    front += [Section("The table", (_facts(source), run_facts(manifest))), Signatures(ROLES)]
    items: list[Item] = [
        *_figures(bundle, source),
        measurements_section("Measurements", measurements, {}, {}),
    ]
    if (tables := tables_section(tables_from_json(bundle.tables))) is not None:
        items.append(tables)
    budgets = budgets_section(measurements)
    command = f"benchtool {' '.join(manifest.command_line)}"
    files = files_section([("", bundle, {})], [command], by="the command")
    return Report(
        manifest.what,
        f"Measured table · {manifest.when}",
        manifest.when,
        tuple(items),
        front=tuple(front),
        appendix=(files,) if budgets is None else (budgets, files),
        fingerprint=fingerprint([bundle]),
    )


def _figures(bundle: Bundle, source: Mapping[str, Any]) -> Iterator[Item]:
    """Yield every column against time, where its steps are even."""
    block = bundle.block(TABLE)
    columns = block.channels[1:]
    if not source["time"]["uniform"] or not columns or not len(block.data):
        return
    measured = replace(block, channels=columns, data=block.data[:, 1:])
    figure = draw_channels(measured, f"{bundle.manifest.what}: every column that was measured")
    caption = (
        f"Every column that was measured, {len(block.data)} rows at {raw(block.sample_rate_Hz)} Hz. "
        f"Long traces are drawn by the least and the greatest value of each stretch, so that no peak is lost."
    )
    yield Section("Figures", (Picture(figure, caption, content.describe_figure(figure)),))


def _block(answer: TableAnswer) -> Block:
    """Return the rows as a block, whose first channel is their time; the others are in SI, and called so."""
    record = answer.record
    named = ((answer.quantities[what], each.unit) for what, each in record.channels.items())
    channels = (Channel("time_s", "s"), *(Channel(name, unit) for name, unit in named))
    gaps = () if record.base.refusal else record.base.gaps
    step_s = record.base.step_s if record.base.step_s > 0.0 else 1.0
    return Block(channels, 0, 1, step_s, record.data, gaps)


def _facts(source: Mapping[str, Any]) -> content.Facts:
    """Return what was read, and how."""
    time = source["time"]
    dropped = "".join(f", {count} left out ({why})" for why, count in source["rows_dropped"].items())
    pairs = {
        "file": str(source["file"]),
        "rows": f"{source['rows_read']} read{dropped}, {source['rows_used']} used",
        "time": f"even, {raw(time['rate_Hz'])} Hz" if time["uniform"] else f"not even, {time['why_not']}",
    }
    for what, column in source["columns"].items():
        assumed = " (assumed)" if column["unit_from"] == "assumed" else ""
        name = f" '{column['name']}'" if column["name"] else ""
        pairs[what] = f"column {column['number']}{name} in {column['unit']}{assumed}{_scaled(column)}"
    return content.Facts(tuple(pairs.items()))


def _scaled(column: Mapping[str, Any]) -> str:
    return (
        ""
        if (column["gain"], column["offset"]) == (1.0, 0.0)
        else (f", {column['gain']:g} x cell {column['offset']:+g}")
    )
