"""What a command prints: JSON alone on standard output, everything for people on standard error or, without
`--json`, on standard output."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from benchtool.experiment.assessment import Assessment, RunResult

_COLOUR = {"pass": "green", "marginal": "yellow", "fail": "red", "none": "dim"}


class Output:
    """The two streams of one command.

    Args:
        as_json: keep standard output for one JSON document.
    """

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._people = Console(stderr=as_json, highlight=False)
        self.progress = Console(stderr=True, highlight=False)

    def note(self, text: str) -> None:
        """A line of progress."""
        self.progress.print(Text(text, style="dim"))

    def line(self, text: str, style: str = "") -> None:
        """A line of the result, for people."""
        self._people.print(Text(text, style=style))

    def verdict(self, verdict: str) -> None:
        """The verdict, in its colour."""
        self._people.print(Text(f"verdict: {verdict}", style=_COLOUR[verdict]))

    def table(self, title: str, columns: tuple[str, ...], rows: Sequence[tuple[str | Text, ...]]) -> None:
        """A table of the result; columns whose heading begins with `>` are right-aligned."""
        table = Table(title=title, title_justify="left", title_style="bold", show_edge=False, pad_edge=False)
        for column in columns:
            table.add_column(column.lstrip(">"), justify="right" if column.startswith(">") else "left")
        for row in rows:
            table.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in row))
        self._people.print(table)

    def document(self, content: Mapping[str, Any]) -> None:
        """The JSON document, if one was asked for."""
        if self._as_json:
            json.dump(content, sys.stdout, indent=2, allow_nan=False)
            sys.stdout.write("\n")


def significant(value: float) -> str:
    """Four significant digits, or a dash for what has no value."""
    return f"{value:.4g}" if math.isfinite(value) else "–"


def show_run(output: Output, title: str, result: RunResult) -> None:
    """Print what every case of a run measured, and how it met its limits."""
    for each in result.assessments:
        heading = title if len(result.assessments) == 1 else f"{title}: {each.case}"
        show_assessment(output, heading, each)
    output.verdict(result.verdict)
    output.document(result.to_json())


def show_assessment(output: Output, title: str, result: Assessment) -> None:
    """Print what one case measured, and how it met its limits."""
    rows = []
    for each in result.steady.measurements:
        limit, verdict = result.limits.get(each.name), result.verdicts.get(each.name)
        bounds = "" if limit is None else f"{_bound('≥', limit.min)}{_bound('≤', limit.max)}"
        rows.append((each.name, significant(each.value), each.unit, bounds.strip(), str(verdict or "")))
    output.table(title, ("measurement", ">value", "unit", "limit", "verdict"), rows)
    output.line(f"bundle: {result.bundle}")


def _bound(sign: str, value: float | None) -> str:
    return "" if value is None else f"{sign} {value:g} "
