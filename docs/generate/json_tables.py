"""The JSON document of a text table of another tool, `analyze --csv`."""

from __future__ import annotations

from typing import Any, Literal

from docs.generate.json_results import Document, Measurement, ResultTable


class TableSource(Document):
    """What was read of a text table."""

    file: str
    """The file."""
    encoding: str
    """Its encoding."""
    delimiter: str
    """What separates cells."""
    decimal: str
    """Decimal sign."""
    head_lines: int
    """Lines above the data."""
    columns: dict[str, dict[str, Any]]
    """Columns that were used: number, name, unit, where the unit is from, gain and offset."""
    recorded_on: str
    """The day of the table, by which calibrations are due."""
    recorded_on_from: str
    """Where that day is from."""
    rows_read: int
    """Rows of the file."""
    rows_dropped: dict[str, int]
    """Rows that were left out, by reason."""
    rows_used: int
    """Rows that were measured."""
    time: dict[str, Any]
    """How the time stamps were understood: whether they are even, rate, jitter, resolution, gaps."""


class TableCase(Document):
    """A text table of another tool."""

    source: TableSource
    """What was read."""
    remarks: list[dict[str, Any]]
    """What is odd about the data."""
    measurements: dict[str, Measurement]
    """Measurements by name."""
    tables: dict[str, ResultTable]
    """Results that are tables, by name."""


class AnalyzedTable(Document):
    """`analyze --csv`."""

    verdict: Literal["none"]
    """A table has no limits."""
    cases: dict[str, TableCase]
    """One case, `csv`."""
    bundle: str | None = None
    """Folder of the bundle, with `--out` or `--report`."""
    report: str | None = None
    """The report, with `--report`."""
