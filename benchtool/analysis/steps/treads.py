"""Telling a staircase from one step, by the treads on its way.

A tread on which much of the way is spent shows in the reference alone. Of many short ones the reference does
not tell a staircase from a ramp that a converter or a slow setpoint loop makes coarse: that tells the answer,
which comes to rest on the treads of a staircase and goes steadily along a ramp.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

HELD = 0.02
"""Of the height: how near its greatest value a reference counts as held there."""

_WAY = HELD, 1.0 - 0.5 * HELD  # of the height: between these a reference is in transition
_LANDING = 0.03  # of the height: a band in which it spends little time
_DWELL = 0.2  # of the way: more than a ramp (0.03) spends in such a band; an exponential only at its end
_FASTER = 3.0  # times the usual speed in the band: above it, where the way goes on from a rest
_FEWEST_ON_THE_WAY = 6  # samples; fewer show no landing
_RISE = 0.013  # of the height: the least that treads are apart, above that of 70 of them
_LEVEL = 0.25 * _RISE  # a tread is level to within that
_SHORTEST = 12  # rows of a tread; shorter ones are the setpoints of a ramp
_OF_THE_WAY = 0.7  # of the height: what lies between treads, at least
_PARTS, _TOGETHER = 8, 3  # parts of a tread, and how many of them an answer moves in
_AT_ONCE = 0.6  # of its movement, of which a ramp makes 3 / 8 there: a lag over 2.2 time constants
_MOVES = 0.5  # of the height: the least that the answer comes up meanwhile
_COARSE = 2  # values of an answer for each tread: of fewer it is as coarse, and shows nothing on them


def long_tread(way: Floats) -> float | None:
    """Return the level at which much of the way up of a reference, shape (n,), is spent and from which it
    goes on faster; None where there is none, as where a way slows down towards its end. Its height is 1."""
    way = way[slice(*_transition(way))]
    if len(way) < _FEWEST_ON_THE_WAY:
        return None
    ordered = np.sort(way)
    within = np.searchsorted(ordered, ordered + _LANDING, side="right") - np.arange(len(ordered))
    above = len(ordered) - np.arange(len(ordered)) - within
    left = _WAY[1] - ordered - _LANDING
    rests = (within > _DWELL * len(way)) & (left * within > _FASTER * _LANDING * above) & (left >= _LANDING)
    if not np.any(rests):
        return None
    first = int(np.argmax(within * rests))
    return float(np.median(ordered[first : first + int(within[first])]))


def answered_tread(way: Floats, answer: Floats) -> float | None:
    """Return the level of the first of the treads that together are the way up of a reference, shape (n,), if
    its answer, likewise of the height 1, comes to rest on them: most of its movement is in a part of each,
    where its delay puts that. None of a ramp, and where the answer takes longer than the treads."""
    begin, end = _transition(way)
    first = _first_rows(way[begin:end])
    if not len(first):
        return None
    levels = np.append(way[begin:end][first], 1.0)
    rises = np.diff(levels)
    is_coarse = len(np.unique(answer[begin:end])) <= _COARSE * len(levels)
    if is_coarse or np.sum(rises[rises >= _RISE]) < _OF_THE_WAY:
        return None
    edges = begin + np.append(first, end - begin)
    parts = edges[:-1, np.newaxis] + np.diff(edges)[:, np.newaxis] * np.arange(_PARTS) / _PARTS
    places = np.append(parts.ravel(), edges[-1])
    summed = np.interp(places, np.arange(len(answer) + 1.0), np.concatenate([[0.0], np.cumsum(answer)]))
    means = np.diff(summed) / np.diff(places)
    moved = np.sum(np.diff(means)[_PARTS - 1 :][: (len(first) - 1) * _PARTS].reshape(-1, _PARTS), axis=0)
    whole = float(np.sum(moved))
    if whole < _MOVES * (levels[-2] - levels[0]):
        return None
    around = np.concatenate([moved, moved[: _TOGETHER - 1]])
    at_once = float(np.max(np.convolve(around, np.ones(_TOGETHER), mode="valid")))
    return float(levels[0]) if at_once > _AT_ONCE * whole else None


def _transition(way: Floats) -> tuple[int, int]:
    """Return the first row in which a reference has left its first level, and the one in which it is up."""
    at_first = np.flatnonzero(way[: int(np.argmax(way)) + 1] <= _WAY[0])
    return int(at_first[-1]) + 1 if len(at_first) else 0, int(np.argmax(way >= _WAY[1]))


def _first_rows(way: Floats) -> NDArray[np.int64]:
    """Return the first row of each tread on a way, shape (n,), of which it has two at least; else none."""
    none = np.empty(0, dtype=np.int64)
    if len(way) < 2 * _SHORTEST:
        return none
    is_level = np.ptp(np.lib.stride_tricks.sliding_window_view(way, _SHORTEST), axis=1) <= _LEVEL
    first = np.flatnonzero(np.diff(is_level, prepend=False) & is_level)
    return first if len(first) > 1 else none
