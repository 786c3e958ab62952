"""Bundles of tables of other tools: the numbers as they were measured when the bundle was written."""

from __future__ import annotations

from typing import Final

from benchtool.analysis import Measurement, Table, measurements_from_json, tables_from_json
from benchtool.block import Block
from benchtool.plan import Coordinates
from benchtool.recording import Bundle
from benchtool.results.assessment import Assessment
from benchtool.results.recorded import Recorded
from benchtool.tables import KeptTable

TABLE: Final = "table"
"""The stream with the rows that were used."""


def is_table(bundle: Bundle) -> bool:
    """Return whether a bundle holds a measured table, to its end."""
    return bundle.complete and isinstance(bundle.manifest.details.get("source"), dict)


def stored_remarks(bundle: Bundle) -> tuple[str, ...]:
    """Return the remarks on a measured table, such as of a calibration that was overdue; none of others."""
    if not is_table(bundle):
        return ()
    remarks = bundle.manifest.details.get("remarks")
    told = remarks if isinstance(remarks, list) else []
    return tuple(str(each["text"]) for each in told if isinstance(each, dict) and "text" in each)


def assess_table(bundle: Bundle) -> Assessment:
    """Return what was measured of a table, which has no limits.

    Raises:
        RecordingError: a file of the bundle is not what was written.
        AnalysisError: its measurements cannot be read.
    """
    bundle.require_intact()
    rows = bundle.block(TABLE)
    return _assessment(
        bundle, rows, measurements_from_json(bundle.measurements), tables_from_json(bundle.tables)
    )


def is_measurable(bundle: Bundle) -> bool:
    """Return whether a bundle holds all that the numbers of its table rest on; earlier ones do not."""
    return is_table(bundle) and "table" in bundle.manifest.details


def assess_table_again(bundle: Bundle) -> Assessment:
    """Return what the rows of a bundle come to, measured as the table was.

    Raises:
        RecordingError: a file of the bundle is not what was written.
        AnalysisError: what the table was measured by cannot be read.
    """
    bundle.require_intact()
    rows = bundle.block(TABLE)
    kept = KeptTable.of_document(bundle.manifest.details["table"])
    return _assessment(bundle, rows, *kept.measured_again(rows))


def _assessment(
    bundle: Bundle, rows: Block, measurements: tuple[Measurement, ...], tables: tuple[Table, ...]
) -> Assessment:
    info, name = bundle.manifest.files.get(f"data/{TABLE}.parquet"), bundle.directory.name
    return Assessment(
        name,
        bundle.directory,
        measurements,
        (),
        {},
        {},
        rows,
        None,
        None,
        tables,
        coordinates=Coordinates(name),
        recorded=Recorded(TABLE, rows, None if info is None else info.sha256),
    )
