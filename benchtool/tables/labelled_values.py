"""Lines as the serial plotter of the Arduino IDE reads them: `label:value` of each signal, one line a row."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence

_SNIFFED_BYTES, _FEWEST_LINES = 64 * 1024, 2
_PAIR = re.compile(
    r"[\s,]*([^\W\d][^:,;|\t]*):[ \t]*([+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[+-]?[a-z]{2,4})"
    r"(?=[\s,]|$)",
    re.IGNORECASE,
)
_IN_PLACE = "?"  # of a value that a line does not have: a cell that is no number


def as_columns(text: bytes) -> tuple[bytes, int]:
    """Return lines of labelled values as a table with the labels as its head, and how many lines that has
    more than the text; any other text as it is.

    Labels and values are separated by blanks, tabs or commas; more than half of the lines that are not blank
    have the same labels, none twice, which are the columns. A line below the first of these without one of
    them has a cell without a number there, one of other text no others; lines above are left out. The text
    is in UTF-8 with lines ended by newlines.
    """
    sniffed = text[:_SNIFFED_BYTES]
    if b":" not in sniffed:
        return text, 0
    sample = [line.decode(errors="replace") for line in sniffed.split(b"\n") if line.strip()]
    counts = Counter(tuple(label for label, _ in _pairs(line)) for line in sample)
    labels, count = counts.most_common(1)[0]
    if not labels or len(set(labels)) < len(labels) or count < _FEWEST_LINES or 2 * count <= len(sample):
        return text, 0
    lines = text.decode(errors="replace").split("\n")
    rows = [_row(line, labels) for line in lines]
    first = next(place for place, (_, is_whole) in enumerate(rows) if is_whole)
    written = [*[""] * first, ",".join(labels), *(row for row, _ in rows[first:])]
    return "\n".join(written).encode(), 1


def _pairs(line: str) -> list[tuple[str, str]]:
    """Return the labels and values of a line, none where it has anything else."""
    found, end = [], 0
    while match := _PAIR.match(line, end):
        found.append((match[1].strip(), match[2]))
        end = match.end()
    return [] if line[end:].strip(" \t,") else found


def _row(line: str, labels: Sequence[str]) -> tuple[str, bool]:
    """Return the cells of a line by their labels, and whether it has them all; a blank line as it is."""
    if not line.strip():
        return "", False
    values = dict(_pairs(line))
    return ",".join(values.get(label, _IN_PLACE) for label in labels), all(map(values.__contains__, labels))
