"""Tables in long form: a row for each value, with a column that says of which signal it is."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

_MOST_SIGNALS, _FEWEST_CYCLES = 64, 4
_OF_A_SECOND = (1e3, 1e6, 1e9)
_FLAGS = tuple(map(frozenset, (("true", "false"), ("on", "off"), ("yes", "no"), ("high", "low"))))


def signal_column(rows: Sequence[Sequence[str]], numeric: Sequence[bool]) -> int:
    """Return the number, from 1, of a column whose cells go through the same few over and over again, from
    row to row; 0 where none does.

    What counts so may be a counter: numbers name signals only if another column, the time, has one value in
    each cycle, and another in the next, and they are no milliseconds of a time in whole seconds.
    """
    for place, cells in enumerate(zip(*rows, strict=False)):
        count = _cycle(cells)
        if not count or (numeric[place] and not _is_held(rows, place, count)):
            continue
        if not _is_of_a_second(cells, count):
            return place + 1
    return 0


def _cycle(cells: Sequence[str]) -> int:
    """Return how many different cells follow each other in each cycle, 0 if they do not."""
    count = len(set(cells))
    if frozenset(map(str.lower, set(cells))) in _FLAGS:  # a signal of its own, such as a clock
        return 0
    if not 2 <= count <= _MOST_SIGNALS or len(cells) < _FEWEST_CYCLES * count or not all(cells):
        return 0
    # a sample has lines of several places of the file, between which a cycle is cut
    same = sum(cell == later for cell, later in zip(cells, cells[count:], strict=False))
    others = sum(cell != following for cell, following in itertools.pairwise(cells))
    cut = 2 * count * 4
    return count if same >= len(cells) - count - cut and others >= len(cells) - 1 - cut else 0


def _is_of_a_second(cells: Sequence[str], count: int) -> bool:
    """Return whether cells are numbers at equal distances that make up a second: in ms, us or ns."""
    try:
        values = sorted({float(cell) for cell in cells})
    except ValueError:
        return False
    steps = {round(after - before, 9) for before, after in itertools.pairwise(values)}
    return len(steps) == 1 and round(count * steps.pop(), 6) in _OF_A_SECOND


def _is_held(rows: Sequence[Sequence[str]], place: int, count: int) -> bool:
    """Return whether a column before the one that counts keeps its cell through each cycle."""
    first = rows[: len(rows) // count * count]
    begins = range(0, len(first) - count, count)
    for other in range(len(rows[0])):
        if other == place:
            continue
        held = sum(len({row[other] for row in first[at : at + count]}) == 1 for at in begins)
        changed = sum(first[at][other] != first[at + count][other] for at in begins)
        if min(held, changed) > 0.9 * len(begins):
            return True
    return False
