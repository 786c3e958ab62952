"""Tables and sentences on a narrow terminal: names are broken after an underscore, numbers never."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence

from rich.cells import cell_len

SEPARATOR = 3  # cells between columns
_LEAST_NAME = 12
_LEAST_TEXT = 24  # of a column of words
_INDENT = "    "
_NAMED = 3


def named(names: tuple[str, ...]) -> str:
    """Return the first few, and how many more."""
    more = len(names) - _NAMED
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:_NAMED])} and {more} more"


def widest_name(columns: Sequence[str], rows: Sequence[Sequence[str]], width: int) -> int | None:
    """Return the greatest width of the names in the first column of a table that is too wide for a terminal
    of `width` cells; None if they can stay as they are.

    Columns of words give way first, as far as they have room; those of numbers, whose heading begins with
    `>`, do not.
    """
    headings = [column.removeprefix(">") for column in columns]
    texts = list(zip(headings, *rows, strict=True))
    natural = [max(cell_len(line) for text in column for line in text.split("\n")) for column in texts]
    excess = sum(natural) + SEPARATOR * (len(columns) - 1) - width
    words = [
        wide for wide, column in zip(natural[1:], columns[1:], strict=True) if not column.startswith(">")
    ]
    excess -= sum(max(0, wide - _LEAST_TEXT) for wide in words)
    return max(_LEAST_NAME, natural[0] - excess) if excess > 0 else None


def broken(name: str, width: int) -> str:
    """Return a name in lines of at most `width` cells, broken after commas or blanks and, where what is
    between them is wider, after underscores; a longer part of it stays whole."""
    lines = [""]
    for part in _parts(name, width):
        if lines[-1] and cell_len(lines[-1]) + cell_len(part.rstrip()) > width:
            lines.append("")
        lines[-1] += part
    return "\n".join(line.rstrip() for line in lines)


def _parts(name: str, width: int) -> Iterator[str]:
    """Yield the parts of a name that a line may end with."""
    for piece in re.split("(?<=[, ])", name):
        if cell_len(piece.rstrip()) <= width:
            yield piece
        else:
            yield from re.split("(?<=_)", piece)


def hanging(lead: str, text: str, width: int) -> str:
    """Return a sentence after its lead, on one line if it fits, else in lines between words, indented below
    the lead."""
    if cell_len(lead) + cell_len(text) <= width:
        return f"{lead}{text}"
    if not lead.strip():
        return textwrap.fill(
            text, width, initial_indent=lead, subsequent_indent=lead or "  ", break_on_hyphens=False
        )
    below = textwrap.fill(
        text, width, initial_indent=_INDENT, subsequent_indent=_INDENT, break_on_hyphens=False
    )
    return f"{lead.rstrip()}\n{below}"
