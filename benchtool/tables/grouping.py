"""Whether a sign between digits is that of decimals or stands between thousands."""

from __future__ import annotations

import re
from collections.abc import Iterable
from enum import IntEnum

_FEWEST_SEPARATED, _FEWEST_WHOLE = 64, 2
"""Of decimals without trailing zeros one in ten has fewer than three digits: of 64, all but one in a thousand
columns."""


class Use(IntEnum):
    """What the cells of a column tell about a sign, the stronger the greater."""

    NOTHING = 0
    EITHER = 1
    THOUSANDS = 2
    DECIMALS = 3


def use_of(sign: str, cells: Iterable[str]) -> Use:
    """Return how the numbers among the cells of a column use a sign.

    Of decimals it is where not all of the cells that have it have one to three digits before and three
    behind, the first not zero (0,5; 1,25; 1500,125). Of thousands it is where all have, whole numbers below
    1000 stand among them (998; 1,095), and both are so many that it is not by chance, or one has two of them
    (1,095,000). Else it may be either.
    """
    escaped = re.escape(sign)
    thousands = re.compile(rf"[+-]?[1-9][0-9]{{0,2}}(?:{escaped}[0-9]{{3}})+")
    decimals = re.compile(rf"[+-]?[0-9]*{escaped}[0-9]*(?:[eE][+-]?[0-9]+)?")
    separated, several, large = 0, False, False
    small: set[str] = set()
    for cell in cells:
        if sign not in cell:
            if re.fullmatch(r"[+-]?[1-9][0-9]*", cell):
                large |= len(cell.lstrip("+-")) > 3
                small.add(cell)
        elif thousands.fullmatch(cell):
            separated += 1
            several |= cell.count(sign) > 1
        elif decimals.fullmatch(cell):
            return Use.DECIMALS
    if not separated:
        return Use.NOTHING
    if large:
        return Use.DECIMALS  # 1500 beside 1,095 has no sign between its thousands
    many = several or (separated >= _FEWEST_SEPARATED and len(small) >= _FEWEST_WHOLE)
    return Use.THOUSANDS if many else Use.EITHER
