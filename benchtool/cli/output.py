"""Output of a command: with `--json` the JSON on standard output and text on standard error, else text on
standard output."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from contextlib import nullcontext, suppress
from typing import TYPE_CHECKING, Any, Literal

from rich.console import Console
from rich.table import Table
from rich.text import Text

from benchtool.cli.exit_codes import printable
from benchtool.cli.fitting import broken, hanging
from benchtool.cli.table_layout import RIGHT, SEPARATOR, tables

if TYPE_CHECKING:
    from benchtool.recording import Bundle
    from benchtool.results import Overdue, RecordedRun

_WIDTH_OF_A_PIPE = 140
_NARROWEST = 20  # a table of fewer cells is none
VERDICT_COLOURS = {
    "pass": "green",
    "marginal": "yellow",
    "undecided": "magenta",
    "fail": "red",
    "none": "dim",
}


class Output:
    """The two output streams of one command. Text is printed literally: no markup, control characters
    escaped.

    Args:
        as_json: keep standard output for one JSON document.
    """

    def __init__(self, *, as_json: bool) -> None:
        self._as_json = as_json
        self._people = _console(stderr=as_json)
        self.progress = _console(stderr=True)

    @property
    def width(self) -> int:
        """Cells in a line of the results."""
        return self._people.width

    def note(self, text: str) -> None:
        """Print a line of progress; a closed terminal does not end a run."""
        with suppress(OSError):
            self.progress.print(Text(printable(text), style="dim"))

    def warning(self, text: str) -> None:
        """Print a warning on standard error, on one line however long."""
        with suppress(OSError):
            self.progress.print(Text(printable(f"warning: {text}"), style="yellow"), soft_wrap=True)

    def line(self, text: str, style: str = "") -> None:
        """Print a line of the result; never wrapped, so that it can be copied."""
        self._show(Text(printable(text), style=style), soft_wrap=True)

    def sentence(self, text: str, style: str = "", *, lead: str = "") -> None:
        """Print a sentence of the result after its lead: on a terminal broken between words, else on one
        line."""
        said = f"{lead}{text}"
        if self._people.is_terminal:
            said = hanging(lead, text, self._people.width)
        for line in said.splitlines():
            self.line(line, style)

    def verdict(self, verdict: str, by_transducer: str | None = None, remark: str = "") -> None:
        """Print the verdict in its colour, with that by the transducer, if it differs, and a remark."""
        beside = f" by the drive's own estimate, {by_transducer} by the transducer on the shaft"
        differs = by_transducer is not None and by_transducer != verdict
        text = f"verdict: {verdict}{beside if differs else ''}{f' ({remark})' if remark else ''}"
        self.sentence(text, VERDICT_COLOURS[verdict])

    def table(self, title: str, columns: tuple[str, ...], rows: Sequence[tuple[str | Text, ...]]) -> None:
        """Print a table of the result; columns whose heading, of one line or more, begins with `>` are of
        numbers, right-aligned and never broken. Columns without room stand in a table below."""
        headings = ["\n".join(printable(line) for line in column.split("\n")) for column in columns]
        cells = [[printable(str(cell)) for cell in row] for row in rows]
        styles = [[cell.style if isinstance(cell, Text) else "" for cell in row] for row in rows]
        for number, shown in enumerate(tables(headings, cells, self._people.width)):
            table = Table(
                title=printable(f"{title} (continued)" if number else title),
                title_justify="left",
                title_style="bold",
                show_edge=False,
                pad_edge=False,
            )
            for place, wide in zip(shown.places, shown.widths, strict=True):
                heading = headings[place]
                side: Literal["left", "right"] = "right" if heading.startswith(RIGHT) else "left"
                table.add_column(
                    broken(heading.removeprefix(RIGHT), wide), justify=side, overflow="fold", width=wide
                )
            for row, of_row in zip(cells, styles, strict=True):
                table.add_row(
                    *(
                        Text(broken(row[place], wide), style=of_row[place])
                        for place, wide in zip(shown.places, shown.widths, strict=True)
                    )
                )
            total = sum(shown.widths) + SEPARATOR * (len(shown.widths) - 1)
            table.width = total if total > self._people.width else None
            self._show(table)

    def _show(self, what: Text | Table, *, soft_wrap: bool = False) -> None:
        """Print text; with `--json`, a closed terminal is ignored."""
        with suppress(OSError) if self._as_json else nullcontext():
            self._people.print(what, soft_wrap=soft_wrap, crop=False)

    def document(self, content: Mapping[str, Any]) -> None:
        """Print the JSON document, if requested."""
        if self._as_json:
            json.dump(content, sys.stdout, indent=2, allow_nan=False)
            sys.stdout.write("\n")


def warn_unsealed(output: Output, bundles: Sequence[Bundle]) -> None:
    """Print which bundles an earlier version recorded, without hashes."""
    without = [bundle for bundle in bundles if not bundle.integrity.sealed]
    if without:
        more = f" and {len(without) - 1} more" if len(without) > 1 else ""
        output.note(
            f"{without[0].directory}{more}: recorded without hashes, so that damage to the files is not seen"
        )


def warn_incomplete(output: Output, runs: Iterable[RecordedRun]) -> None:
    """Print on standard error which runs did not come to their end, what of them is there, and what to do."""
    for text in dict.fromkeys(run.incomplete for run in runs if run.incomplete):
        output.warning(text)


def warn_overdue(output: Output, overdue: Iterable[Overdue]) -> None:
    """Print on standard error which instruments were used after their calibration was due, each once."""
    for text in dict.fromkeys(str(each) for each in overdue):
        output.warning(text)


def _console(*, stderr: bool) -> Console:
    """Return a console as wide as the environment states in COLUMNS, else as its terminal; a file or a pipe
    takes what a table needs. No text is markup."""
    console = Console(stderr=stderr, highlight=False, markup=False, emoji=False)
    stated = os.environ.get("COLUMNS", "")  # which rich reads as it is
    is_stated = stated.isdigit() and int(stated) >= _NARROWEST
    if not (console.is_terminal or is_stated):
        console.width = _WIDTH_OF_A_PIPE
    return console
