"""Rows that repeat all values of the row before, because whatever read them had none that were new."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import resolution

Floats = NDArray[np.float64]

_BY_CHANCE = 0.05  # probability that one row is equal, from which it is taken for stale
_CLEARLY = 4.0  # standard deviations of the number that is equal by chance
_LARGEST_SHARE, _LONGEST = 0.25, 16  # of the rows; rows in a row


def repeating_rows(values: Floats) -> NDArray[np.bool_]:
    """Return which rows of values, shape (n, columns), repeat the one before though they should have moved,
    shape (n,).

    All columns are equal to those of the row before, while they move on either side of it. Of a column that
    moves by m of its least steps from row to row neighbours are equal by chance in one row of about m: rows
    are repeated where that is improbable for all columns together, and there are more of them than by chance.
    At rest, or where a converter is coarse, none is.
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
    chance = np.ones(len(moves))
    for column, move in zip(values.T, moves.T, strict=True):
        step, usual = resolution(column), 0.5 * (move[inside[0]] + move[inside[1]])
        chance *= np.minimum(1.0, np.divide(step, usual, out=np.ones(len(moves)), where=usual > step))
    unlikely = chance < _BY_CHANCE
    expected = float(np.sum(chance[unlikely]))
    found = unlikely & same
    if np.count_nonzero(found) > expected + _CLEARLY * np.sqrt(expected):
        stale[1:] = found
    return stale


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
    return ""
