"""The last row of a text that ends within a number, as of a logger that was killed."""

from __future__ import annotations

from benchtool.tables.head import split
from benchtool.tables.layout import Layout

_ROWS, _FEWEST_ROWS = 64, 8
_FILLING = b"\0\x1a \t"


def without_cut_number(text: bytes, layout: Layout) -> bytes:
    """Return a text without its last cell where that was cut off within its digits: its row is then one of a
    wrong number of cells.

    The last line has no end, and its last cell fewer characters than every cell above it in the column.
    """
    body = text.rstrip(_FILLING)
    if not body or body.endswith(b"\n"):
        return text
    lines = [line for line in body[-(1 << 16) :].split(b"\n")[1:] if line.strip()]
    last = [split(line.decode(errors="replace"), layout.delimiter) for line in lines[-1 - _ROWS :]]
    *above, cells = last or [[]]
    lengths = [len(each[-1]) for each in above if len(each) == len(layout.columns)]
    is_whole = len(cells) != len(layout.columns) or not cells[-1]
    if is_whole or len(lengths) < _FEWEST_ROWS or len(cells[-1]) >= min(lengths):
        return text
    kept = body[: body.rindex(cells[-1].encode())].rstrip(_FILLING).removesuffix(layout.delimiter.encode())
    return kept if len(layout.columns) > 1 else body[: body.rindex(b"\n") + 1]
