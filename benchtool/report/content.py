"""The content of a report, independent of its layout as HTML or PDF."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Mark: TypeAlias = Literal["", "pass", "marginal", "undecided", "fail", "none", "better", "worse"]

SYMBOLS: Final[dict[Mark, str]] = {
    "": "",
    "pass": "✓",
    "marginal": "▲",
    "undecided": "?",
    "fail": "✗",
    "none": "–",
    "better": "✓",
    "worse": "✗",
}


@dataclass(frozen=True)
class Cell:
    """One cell of a grid; `mark` says what it means beside its words.

    `notes` unfold beneath it on a screen, a definition first. On paper they stand at the end: the definition,
    and all of them where the row has a mark.
    """

    text: str
    mark: Mark = ""
    notes: tuple[str, ...] = ()

    @property
    def shown(self) -> str:
        """The text after the symbol of its mark, so that the meaning does not depend on colour."""
        return f"{SYMBOLS[self.mark]}\N{NO-BREAK SPACE}{self.text}" if self.mark else self.text


@dataclass(frozen=True)
class Column:
    """Heading of a column; numbers are set flush right, and what is not on `paper` stands on the page
    alone."""

    heading: str
    numeric: bool = False
    paper: bool = True


@dataclass(frozen=True)
class Grid:
    """A table whose first column names its rows; on a screen, rows beyond the first `shown` fold away, and on
    paper they are left out."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Cell, ...], ...]
    caption: str = ""
    shown: int | None = None

    @classmethod
    def of(
        cls,
        headings: Sequence[str],
        rows: Sequence[Sequence[str | Cell]],
        caption: str = "",
        shown: int | None = None,
    ) -> Grid:
        """Return the grid of plain texts and cells; headings that begin with `>` are those of numbers."""
        columns = tuple(Column(heading.removeprefix(">"), heading.startswith(">")) for heading in headings)
        cells = tuple(tuple(Cell(each) if isinstance(each, str) else each for each in row) for row in rows)
        return cls(columns, cells, caption, shown)


@dataclass(frozen=True)
class Facts:
    """A list of names and values."""

    pairs: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Text:
    """A paragraph; `code` is set as it would be typed, `warning` stands out."""

    text: str
    kind: Literal["plain", "note", "warning", "code"] = "plain"


@dataclass(frozen=True)
class Verdict:
    """A verdict, with a line on its basis."""

    mark: Mark
    text: str
    summary: str


@dataclass(frozen=True)
class Picture:
    """A figure; the caption says what is shown, `alternative` is the text alternative."""

    figure: Figure
    caption: str
    alternative: str


@dataclass(frozen=True)
class Signatures:
    """Lines to be signed, one for each role, each with a name and a date."""

    roles: tuple[str, ...]


@dataclass(frozen=True)
class Section:
    """A heading with what belongs to it; `listed` puts it into the table of contents, and on paper it begins
    a new page unless it is `short`.

    A `folded` one is closed on a screen until it is asked for; what is not on `paper` stands on the page
    alone."""

    title: str
    items: tuple[Item, ...]
    listed: bool = False
    folded: bool = False
    paper: bool = True
    short: bool = False

    @property
    def begins_page(self) -> bool:
        """Whether it begins a page on paper."""
        return self.listed and self.paper and not self.short


Item: TypeAlias = Grid | Facts | Text | Verdict | Picture | Signatures | Section


@dataclass(frozen=True)
class Report:
    """A whole report: the page that is signed, then figures and numbers, and what one looks up as an
    appendix.

    `when` is the ISO 8601 time of the run that it is about, `front` what stands on the first page, and
    `fingerprint` the SHA-256 of what was recorded, empty of a report that has none.
    """

    title: str
    subtitle: str
    when: str
    items: tuple[Item, ...]
    front: tuple[Item, ...] = ()
    appendix: tuple[Item, ...] = ()
    fingerprint: str = ""


def contents(items: Sequence[Item]) -> tuple[tuple[str, str], ...]:
    """Return the titles and anchors of the listed sections, in their order."""
    found: list[tuple[str, str]] = []
    for each in items:
        if isinstance(each, Section):
            if each.listed:
                found.append((each.title, anchor(each.title)))
            found += contents(each.items)
    return tuple(found)


def anchor(title: str) -> str:
    """Return a section's title as an HTML id; the same title always gives the same one."""
    plain = unicodedata.normalize("NFKD", title)
    return "s-" + re.sub(r"[^A-Za-z0-9.=]+", "-", plain).strip("-").lower()


def describe_figure(figure: Figure) -> str:
    """Return a description of a figure: its title, then the axes of each panel."""
    heading = " ".join(figure.get_suptitle().split())
    panels: dict[str, None] = {}
    x_label = next((each.get_xlabel() for each in reversed(figure.axes) if each.get_xlabel()), "")
    for axes in figure.axes:
        y_label, own = axes.get_ylabel(), axes.get_xlabel() or x_label
        if y_label:
            panels[_plain(f"{y_label} against {own}" if own else y_label)] = None
    return ". ".join(filter(None, (_plain(heading), "; ".join(panels)))) + "."


def _plain(text: str) -> str:
    """Return the text without the marks of mathematical type."""
    return re.sub(r"[$\\{}]", "", text)
