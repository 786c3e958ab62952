"""Text on a narrow terminal: lines end between words, or else within a name after an underscore or the like;
a number stays with its sign and its unit."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator

from rich.cells import cell_len

_INDENT = "    "
_NAMED = 3
_WORDS = re.compile("(?<=[, ])")
_IN_NAMES = re.compile(r"(?<=[_/=:])|(?<=[a-z][.-])(?=[a-z])")
_SHORT = 12  # cells of a name that stays whole
_SIGN = re.compile(r"[≥≤<>±×=P−+-] ")
_NUMBER = re.compile(r"[(−+-]*\d[\d.]*(?:[eE][−+-]?\d+)?\)? ")
_LONGEST_UNIT = 6


def named(names: tuple[str, ...]) -> str:
    """Return the first few, and how many more."""
    more = len(names) - _NAMED
    return ", ".join(names) if more <= 1 else f"{', '.join(names[:_NAMED])} and {more} more"


def broken(text: str, width: int) -> str:
    """Return text in lines of at most `width` cells, broken after commas or blanks and, where what is between
    them is wider, within names; a longer part stays whole."""
    return "\n".join(_broken(line, width) for line in text.split("\n"))


def _broken(text: str, width: int) -> str:
    lines = [""]
    for part in _parts(text, width):
        if lines[-1] and cell_len(lines[-1]) + cell_len(part.rstrip()) > width:
            lines.append("")
        lines[-1] += part
    return "\n".join(line.rstrip() for line in lines)


def longest_part(text: str, *, within_names: bool) -> int:
    """Return the width below which text cannot be broken, within names too or between words alone."""
    parts = (part for line in text.split("\n") for part in _parts(line, 0 if within_names else None))
    return max((cell_len(part.rstrip()) for part in parts), default=0)


def _parts(text: str, width: int | None) -> Iterator[str]:
    """Yield the parts of text that a line may end with: words and, of those that are wider than `width`, what
    their names are made of."""
    for piece in _words(text):
        wide = cell_len(piece.rstrip())
        if width is None or wide <= max(width, _SHORT) or " " in piece.rstrip():
            yield piece
        else:
            yield from _IN_NAMES.split(piece)


def _words(text: str) -> Iterator[str]:
    """Yield words with the blank or comma at their end; a sign and the word behind it are one, and so are a
    number and its unit."""
    kept = ""
    for word in _WORDS.split(text):
        if kept and not _SIGN.fullmatch(_last(kept)) and len(word.rstrip(" ,.;:)")) > _LONGEST_UNIT:
            yield kept
            kept = ""
        kept += word
        if not (_SIGN.fullmatch(word) or _NUMBER.fullmatch(word)):
            yield kept
            kept = ""
    if kept:
        yield kept


def _last(words: str) -> str:
    """Return the last of some words, with the blank behind it."""
    return f"{words.split()[-1]} "


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
