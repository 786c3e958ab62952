"""A measured table as a run bundle, and as a report: data, numbers and what was understood of the file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from benchtool.analysis import measurements_from_json, measurements_to_json, tables_from_json, tables_to_json
from benchtool.analysis.instruments import said_of_sensors
from benchtool.block import Block, Channel
from benchtool.recording import Bundle, BundleWriter, Manifest, software_versions
from benchtool.recording.seal import hash_of
from benchtool.report import content
from benchtool.report.content import Item, Report, Section, Text
from benchtool.report.origin import files_section, run_facts
from benchtool.report.results import measurements_section, tables_section
from benchtool.tables.answer import TableAnswer
from benchtool.tables.record import Record

STREAM = "table"


def keep(answer: TableAnswer, folder: Path, when: str, command_line: Sequence[str]) -> Bundle:
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
        details={
            "source": dict(answer.source) | {"hash": hashed.model_dump()},
            "remarks": [each.to_json() for each in answer.remarks],
        },
    )
    with BundleWriter(folder, manifest) as bundle:
        bundle.append(STREAM, _block(record))
        return bundle.finish(
            measurements_to_json(answer.measurements), verdict="none", tables=tables_to_json(answer.tables)
        )


def is_table(bundle: Bundle) -> bool:
    """Whether `keep` wrote a bundle, to its end."""
    return bundle.complete and isinstance(bundle.manifest.details.get("source"), dict)


def table_report(bundle: Bundle) -> Report:
    """The report of a table that `keep` has written, with what was measured when it was.

    Raises:
        RecordingError, AnalysisError: a file of the bundle cannot be read, or was not written by `keep`.
    """
    manifest = bundle.manifest
    measurements = measurements_from_json(bundle.measurements)
    undefined: dict[str, list[str]] = {}
    for each in measurements:
        if each.reason:
            undefined.setdefault(each.reason, []).append(each.name)
    items: list[Item] = [
        content.Verdict("none", f"{content.SYMBOLS['none']} No limits", "A table of another tool, measured.")
    ]
    items += [Text(f"{each['text']}.", "warning") for each in manifest.details.get("remarks", ())]
    items += [
        Text(f"Undefined: {', '.join(names)}: {reason}.", "note") for reason, names in undefined.items()
    ]
    items += [Text(f"{text[0].upper()}{text[1:]}.", "note") for text in said_of_sensors(measurements)]
    items += [
        Section("The table", (_facts(manifest.details["source"]), run_facts(manifest))),
        measurements_section("Measurements", measurements, {}, {}),
    ]
    if (tables := tables_section(tables_from_json(bundle.tables))) is not None:
        items.append(tables)
    command = f"benchtool {' '.join(manifest.command_line)}"
    items.append(files_section([("", bundle, {})], [command], by="the command"))
    return Report(manifest.what, f"Measured table · {manifest.when}", manifest.when, tuple(items))


def _block(record: Record) -> Block:
    """The rows as a block, whose first channel is their time."""
    channels = (Channel("time_s", "s"), *record.channels.values())
    gaps = () if record.base.refusal else record.base.gaps
    step_s = record.base.step_s if record.base.step_s > 0.0 else 1.0
    return Block(channels, 0, 1, step_s, record.data, gaps)


def _facts(source: Mapping[str, Any]) -> content.Facts:
    """What was read, and how."""
    time = source["time"]
    dropped = "".join(f", {count} left out ({why})" for why, count in source["rows_dropped"].items())
    pairs = {
        "file": str(source["file"]),
        "rows": f"{source['rows_read']} read{dropped}, {source['rows_used']} used",
        "time": f"even, {time['rate_Hz']:.7g} Hz" if time["uniform"] else f"not even, {time['why_not']}",
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
