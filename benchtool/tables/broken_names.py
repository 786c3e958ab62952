"""Names of columns over several lines, in quotes, as a spreadsheet exports cells with line ends in them."""

from __future__ import annotations

import re

_LOOKED_AT = 64 * 1024  # bytes: a head
_BROKEN = re.compile(rb'(?:(?<=[,;\t|\n])|^)"[^"\n]*(?:\n[^"\n]*){1,4}"(?=[ \t]*(?:[,;\t|\n]|$))')
_LETTER = re.compile(rb"[A-Za-z\x80-\xff]")


def with_whole_names(text: bytes) -> tuple[bytes, int]:
    """Return the text with each name of the head in one line, and how many lines it has less.

    The text is in UTF-8 with lines ended by newlines. A name begins and ends with a quotation mark beside a
    delimiter or a line end, and has a letter in it.
    """
    head, rest = text[:_LOOKED_AT], text[_LOOKED_AT:]
    if b'"' not in head:
        return text, 0
    whole = _BROKEN.sub(_in_one_line, head)
    return whole + rest, head.count(b"\n") - whole.count(b"\n")


def _in_one_line(match: re.Match[bytes]) -> bytes:
    cell = match[0]
    return b" ".join(cell.split(b"\n")) if _LETTER.search(cell) else cell
