"""Rows that repeat all values of the row before, because whatever read them had none that were new."""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from benchtool.analysis import resolution

Floats = NDArray[np.float64]

_BY_CHANCE = 0.05  # probability that one row is equal, from which it is taken for stale
_LOOKED_AT, _NEIGHBOURS = 1 << 16, 8  # rows whose levels are taken; levels to either side of one
_CLEARLY = 4.0  # standard deviations of the number that is equal by chance
_LARGEST_SHARE, _LONGEST = 0.25, 16  # of the rows; rows in a row
_LEAST_SHARE = (
    5e-3  # of the rows, of one column: a slip that makes its lines no smaller than they are uncertain
)
_EVEN_SHARE, _FEWEST_EVEN = 0.9, 8  # of distances between repeats, by chance two in five; so many distances


def repeating_rows(values: Floats) -> NDArray[np.bool_]:
    """Return which rows of values, shape (n, columns), repeat the one before though they should have moved,
    shape (n,).

    All columns are equal to those of the row before, while they move on either side of it. Of a column that
    moves by m of the steps that it has there from row to row neighbours are equal by chance in one row of
    about m: rows are repeated where that is improbable for all columns together, and there are more of them
    than by chance. Of a signal that rests between its moves, as a current while no voltage drives it, more
    are equal by chance: as many as moved by one step, either way alone, and where fewer moved by two that
    much more.
    At rest, or where a converter is coarse, none is; the greatest and the least value, to which a column may
    be clipped, repeat by no chance.
    """
    moves = np.abs(np.diff(values, axis=0))
    stale = np.zeros(len(values), dtype=np.bool_)
    same = ~np.any(moves, axis=1)
    if not np.any(same) or np.all(same):
        return stale
    # of a run of equal rows, those before and after it
    number = np.arange(len(moves))
    before = np.maximum.accumulate(np.where(same, -1, number))
    after = np.minimum.accumulate(np.where(same, len(moves), number)[::-1])[::-1]
    before[~same] -= 1
    after[~same] += 1
    before, after = np.where(before < 0, after, before), np.where(after >= len(moves), before, after)
    inside = np.clip(before, 0, len(moves) - 1), np.clip(after, 0, len(moves) - 1)
    chance, moving = np.ones(len(moves)), 0
    farthest = np.zeros(len(moves), dtype=np.int64)  # in steps, three for more
    for column, move in zip(values.T, moves.T, strict=True):
        step, usual = _steps_near(column)[1:], 0.5 * (move[inside[0]] + move[inside[1]])
        inner = (column[1:] > np.min(column)) & (column[1:] < np.max(column))
        moved = inner & (usual > step)
        chance *= np.divide(step, usual, out=np.ones(len(moves)), where=moved)
        in_steps = np.sum([move / most > step for most in (0.5, 1.5, 2.5)], axis=0)
        farthest = np.maximum(farthest, in_steps)
        moving += bool(np.any(move))
    unlikely = chance < _BY_CHANCE
    one = int(np.count_nonzero(unlikely & ~same & (farthest <= 1)))
    two = int(np.count_nonzero(unlikely & (farthest == 2)))
    at_rest = one / (2.0 * moving) * max(1.0, one / max(1, two))
    expected = max(float(np.sum(chance[unlikely])), at_rest)
    found = unlikely & same
    # what is expected is counted as well
    if np.count_nonzero(found) > expected + _CLEARLY * np.sqrt(expected * (1.0 + 0.5 / moving)):
        stale[1:] = found
    return stale


def _steps_near(column: Floats) -> Floats:
    """Return the step between levels of a column, shape (n,), about each of its values, shape (n,): the least
    between a few neighbouring ones, as numbers of three digits have coarser steps where they are larger."""
    levels = np.unique(column[:: max(1, len(column) // _LOOKED_AT)])
    gaps = np.pad(np.diff(levels), _NEIGHBOURS, constant_values=np.inf)
    least = np.min(sliding_window_view(gaps, 2 * _NEIGHBOURS), axis=1)  # about each level
    place = np.clip(np.searchsorted(levels, column), 0, len(levels) - 1)
    return np.asarray(np.maximum(least[place], resolution(column)))


def stale_rows(repeating: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which of the rows that repeat the one before, shape (n,), are stale: of longer runs it is not
    told that what was read did not stand still."""
    edges = np.flatnonzero(np.diff(repeating, prepend=False, append=False))
    stale = repeating.copy()
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin > _LONGEST:
            stale[begin:end] = False
    return stale


def too_stale(stale: NDArray[np.bool_]) -> str:
    """Return why the other rows do not tell what was between them; empty if they do."""
    share = float(np.mean(stale))
    if share > _LARGEST_SHARE:
        return (
            f"{100 * share:.2g} % of the rows repeat all values of the row before, at most "
            f"{100 * _LARGEST_SHARE:g} % may be left out: export each row once, with its time"
        )
    if _are_even(stale):
        return (
            f"a row in every {1.0 / share:.3g} repeats all values of the row before: they were sampled less "
            "often than listed, and are late by other parts of a row: export each once, with its time"
        )
    return ""


def often_stale(column: Floats, stale: NDArray[np.bool_]) -> str:
    """Return that a column, shape (n,), repeats its own value where no whole row is `stale`; empty if it does
    hardly more often than by chance."""
    share = float(np.mean(stale_rows(repeating_rows(column[:, np.newaxis])) & ~stale))
    if share < _LEAST_SHARE:
        return ""
    return (
        f"{100 * share:.2g} % of its values repeat the one before, though it moves on either side: it was "
        "sampled less often than the rows are listed, or read late: export each value once, with its time"
    )


def _are_even(stale: NDArray[np.bool_]) -> bool:
    """Return whether stale rows are about evenly apart, as those of a lower rate are, and chance leaves none
    to be."""
    apart = np.diff(np.flatnonzero(stale))
    if len(apart) < _FEWEST_EVEN:
        return False
    return float(np.mean(np.abs(apart - np.median(apart)) <= 1.0)) > _EVEN_SHARE
