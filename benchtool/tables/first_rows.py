"""First lines of numbers of a table: rows, or numbers in its head, by what the rows below have in common."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from benchtool.tables.cells import numbers_of
from benchtool.tables.stamps import is_stamp, seconds_of

ROWS = 200
"""Most rows by which the first ones are judged."""

_MOST_LINES = 3
_FEWEST_STEPS = 8  # in one direction: of values at random one in twenty thousand
_FEWEST_ALIKE, _FEWEST_VALUES = 16, 8
_EVEN = 0.5  # of the median step, which rounding of a few digits does not reach
_MOST_STEPS = 20.0  # a step of a time that is not in equal steps is no longer than so many of the longest
_NO_READING = 9.9e37  # SCPI-99: infinity and no reading, or a number whose differences overflow
_WHOLE = (-1, False)
_FORM = re.compile(r"[+-]?[0-9 ']*(?:(?P<sign>[.,])(?P<decimals>[0-9]*))?(?P<exponent>[eE].*)?")


def lines_of_head(
    rows: Sequence[Sequence[str]], numeric: Sequence[bool], decimal: str, delimiter: str
) -> int:
    """Return how many of the first lines of numbers are no rows, but numbers in the head.

    A row continues what increases or decreases by equal steps in the rows below, a time or a count. The first
    line is no row where it does not and is not before the next one either, or each of its numbers is written
    in another way than all below it in its column (`1,2,3` above 0.0001,1.93,2.02); without a time only the
    latter tells. Further lines are none only if written in another way.

    Args:
        rows: the cells of the first lines of numbers.
        numeric: which of the columns have numbers.
        decimal: the decimal sign.
        delimiter: what separates the cells.
    """
    kept = [place for place, is_numeric in enumerate(numeric) if is_numeric]
    columns = [[row[place] for row in rows[:ROWS]] for place in kept]
    for count in range(min(_MOST_LINES, len(rows) - 2), 0, -1):
        below = [column[count - 1 :] for column in columns]
        if _is_apart(below, decimal, delimiter, may_go_back=count == 1):
            return count
    return 0


def _is_apart(columns: Sequence[Sequence[str]], decimal: str, delimiter: str, *, may_go_back: bool) -> bool:
    """Return whether the first cells of some columns are no row above the others."""
    values = [_values(cells, decimal, delimiter) for cells in columns]
    steps = [found for each in values if (found := _first_step(each)) is not None]
    times = [first for first, is_even in steps if is_even] or [first for first, _ in steps]
    if any(0.0 < first <= 1.0 for first in times):
        return False
    goes_back = bool(times) and all(first <= 0.0 for first in times)
    return (goes_back and may_go_back) or _is_written_otherwise(columns, values)


def _values(cells: Sequence[str], decimal: str, delimiter: str) -> NDArray[np.float64]:
    """Return the numbers of cells, nan where there is none; a number among times of day is none, and 9.9e37
    and more."""
    texts = pa.chunked_array([pa.array(cells, pa.string())])
    is_stamped = 2 * sum(map(is_stamp, cells)) > len(cells)
    numbers = seconds_of(texts) if is_stamped else numbers_of(texts, decimal, delimiter)
    values = np.asarray(numbers.to_numpy(zero_copy_only=False), dtype=np.float64)
    return np.where(np.abs(values) < _NO_READING, values, np.nan)


def _first_step(values: NDArray[np.float64]) -> tuple[float, bool] | None:
    """Return the first step of values that go on in one direction, positive in that direction and over the
    most that a row may be from the next, and whether the others are equal; None where they do not go on.

    Steps that are not equal may be those of a signal, whose turn is no jump: one back counts as forward if it
    is no longer than the others are.
    """
    below = values[1:][np.isfinite(values[1:])]
    steps = np.diff(below)
    if len(steps) < _FEWEST_STEPS:
        return None
    steps = steps * np.sign(below[-1] - below[0])
    if np.any(steps < 0.0) or np.median(steps) == 0.0:
        return None
    median, longest = float(np.median(steps)), float(np.max(steps))
    is_even = bool(np.all(np.abs(steps - median) <= _EVEN * median))
    first = float((below[0] - values[0]) * np.sign(below[-1] - below[0]))
    if not np.isfinite(first):
        return 0.0, is_even
    if is_even:
        is_next = abs(first - median) <= _EVEN * median
        return (1.0 if is_next else min(first / median, 0.0) if first <= 0.0 else 2.0), is_even
    return (1.0 if abs(first) <= longest else first / (_MOST_STEPS * longest)), is_even


def _is_written_otherwise(columns: Sequence[Sequence[str]], values: Sequence[NDArray[np.float64]]) -> bool:
    """Return whether each first cell is written as none below it: whole above others, in another form than
    all of a column of one, or as a number above times of day.

    Zeros are written in any way. Those that count the columns (`0,1,2`) need only be whole above others.
    """
    first = [cells[0] for cells in columns]
    begin = int(first[0]) if first[0] in ("0", "1") else -1
    is_counted = len(first) > 1 and first == [str(begin + place) for place in range(len(first))]
    for cells, numbers in zip(columns, values, strict=True):
        if not cells[0]:
            continue
        if numbers[0] == 0.0 and not is_counted:
            return False
        own, forms = _form(cells[0]), {_form(cell) for cell in cells[1:] if cell}
        is_enough = len(cells) > _FEWEST_ALIKE and len(set(cells)) > _FEWEST_VALUES
        is_whole = own == _WHOLE and (is_counted or is_enough)
        if own in forms or not (is_whole or (is_enough and len(forms) == 1)):
            return False
    return any(first)


def _form(cell: str) -> tuple[int, bool]:
    """Return how many decimals a number has, -1 without a decimal sign, -2 where it is none, and whether
    it has an exponent."""
    match = _FORM.fullmatch(cell)
    if match is None:
        return -2, False
    return (-1 if match["sign"] is None else len(match["decimals"])), match["exponent"] is not None
