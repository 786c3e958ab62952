"""Where a curve turns or passes that a converter reads on few levels, which noise may read there and back."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_WIDER = 1.0  # rows, as both ends are uncertain by: less tells nothing of what a level is wider by
_TOGETHER = 0.5  # of the rows from the first to the last on a level
_SMOOTH, _CORNER = 2.0, 4.0  # ratio of the squared widths of two levels below a top, of depths one and two
_NARROW = 3.0  # times narrower than the level before
_BY_NOISE, _BY_LITTLE = 1.0 / 6.0, 1.0 / 12.0  # of the width of that, by noise that rows show, or do not


def rows_of_level(values: Floats, top: int) -> tuple[int, int]:
    """Return the first and the last row in which values, shape (n,), are on the level of a converter that
    they are on in the row `top`.

    Noise that is less than a step shows where a curve passes from one level to the next alone: it reads a few
    rows there and back. Between these rows no value is more than a level lower, and half of them and more are
    on it; otherwise it is left for good.
    """
    on_it = _read_there_and_back(values, top)
    if len(on_it) >= _TOGETHER * (on_it[-1] - on_it[0] + 1):
        return int(on_it[0]), int(on_it[-1])
    first, end = _around(values, float(values[top]), top)
    return first, end - 1


def _read_there_and_back(values: Floats, top: int) -> NDArray[np.int64]:
    """Return the rows about the row `top` on its level between which values, shape (n,), are no more than one
    level lower."""
    lower = float(np.max(values[values < values[top]], initial=-math.inf))
    first, end = _around(values, lower, top)
    return first + np.flatnonzero(values[first:end] == values[top])


def _around(values: Floats, least: float, row: int) -> tuple[int, int]:
    """Return the first of the rows about one in which values, shape (n,), are not below the least, and the
    row after the last."""
    low = np.flatnonzero(values < least)
    at = int(np.searchsorted(low, row))
    return int(low[at - 1]) + 1 if at else 0, int(low[at]) if at < len(low) else len(values)


def _is_noisy(values: Floats, first: int, last: int) -> bool:
    """Return whether noise reads another level for one row and back in values, shape (n,), beside
    the rows from the first to the last, where a peak alone may do it."""
    alone = (values[:-2] == values[2:]) & (values[1:-1] != values[2:])
    return int(np.count_nonzero(alone) - np.count_nonzero(alone[max(0, first - 2) : last + 1])) > 0


def _is_smooth(values: Floats, least: float, top: int) -> bool:
    """Return whether values, shape (n,), widen below the row `top` as below a smooth peak from the level of
    the least value on to that below it, and not as below a corner."""
    lowest, highest = _around(values, least, top)
    if lowest == 0 or highest == len(values):
        return False
    first, end = _around(values, max(float(values[lowest - 1]), float(values[highest])), top)
    if first == 0 or end == len(values):
        return False
    return bool((end - first) ** 2 < math.sqrt(_SMOOTH * _CORNER) * (highest - lowest) ** 2)


def is_on_level(values: Floats, top: int) -> bool:
    """Return whether levels of a converter tell where the peak of values, shape (n,), is, and not its row
    `top`: there are several on its level, or so many on the next, as below a smooth peak or where noise
    shows, that it may have read any of these so."""
    if len(_read_there_and_back(values, top)) > 1:
        return True
    lower = float(np.max(values[values < values[top]], initial=-math.inf))
    lowest, highest = _around(values, lower, top)
    is_of_noise = _is_smooth(values, lower, top) or _is_noisy(values, top, top)
    return lowest > 0 and highest < len(values) and highest - lowest > _NARROW and is_of_noise


def read_back(values: Floats, last: int) -> tuple[int, int]:
    """Return in how many rows before the row `last`, the last on its level for good, values, shape (n,), were
    on the level after it, there and back by noise, and over how many rows that went on; none where it is not
    left."""
    here, after = values[last], values[last + 1]
    if here == after:
        return 0, 0
    others = np.flatnonzero((values[:last] != here) & (values[:last] != after))
    first = int(others[-1]) + 1 if len(others) else 0
    on_it = first + np.flatnonzero(values[first : last + 1] == here)
    middle = int(on_it[len(on_it) // 2])
    back = middle + np.flatnonzero(values[middle:last] == after)
    return (len(back), last + 1 - int(back[0])) if len(back) else (0, 0)


@dataclass(frozen=True)
class _End:
    """Where a curve passes the edge of a level, and in how many rows it is read on either side of it."""

    place: float
    zone: int

    @classmethod
    def of(cls, lower: NDArray[np.bool_], first: int, step: int) -> _End:
        """Return that of a level which begins in the row `first`, and from which on, in the direction of
        `step`, rows are read `lower` there and back: as many after that row as are, and half a row before it.
        """
        count = int(np.count_nonzero(lower))
        zone = int(np.max(np.flatnonzero(lower), initial=-1)) + 1
        return cls(first + step * (count - 0.5), zone)

    @property
    def standard(self) -> float:
        """Standard uncertainty of the place."""
        return math.hypot(1.0, self.zone) / math.sqrt(12.0)


def _ends(values: Floats, least: float, top: int) -> tuple[_End, _End]:
    """Return where a curve about the row `top` passes the edge of a level on its way up and down."""
    lower = values < least
    level = float(values[top]) if least == values[top] else least
    first, last = rows_of_level(np.minimum(values, level), top)
    middle = (first + last) // 2
    return _End.of(lower[first : middle + 1], first, 1), _End.of(lower[last:middle:-1], last, -1)


def middle_of_level(values: Floats, top: int) -> tuple[float, float]:
    """Return where the peak of values, shape (n,), is that are on one level of a converter about the row
    `top`, and the standard uncertainty of that place.

    A level begins and ends anywhere between two rows. The middle of the two highest levels together is
    further from the peak: by the square of their width under a smooth peak, and by their width at a corner.
    The middle of both is taken. Where only the highest level is known it is anywhere within that.
    """
    first, last = rows_of_level(values, top)
    on_it = _read_there_and_back(values, top)
    if last - first < on_it[-1] - on_it[0]:  # in runs apart, by noise or as several peaks are
        runs = 1 + int(np.count_nonzero(np.diff(on_it) > 1))
        return float(np.mean(on_it)), math.hypot(1.0, float(np.std(on_it))) / math.sqrt(runs)
    begin, end = _ends(values, float(values[top]), top)
    middle, width = 0.5 * (begin.place + end.place), end.place - begin.place
    within = (last - first + 1.0) / math.sqrt(12.0)
    if not 0 < first <= last < len(values) - 1:
        return middle, within
    below = max(values[first - 1], values[last + 1])
    lowest, highest = _around(values, below, top)
    if lowest == 0 or highest == len(values):
        return middle, within
    earlier, later = _ends(values, float(below), top)
    wider = later.place - earlier.place
    shift = 0.5 * (earlier.place + later.place) - middle
    if wider < width + _WIDER:
        return middle, within
    smooth, corner = width**2 / (wider**2 - width**2), width / (wider - width)
    ahead = 0.5 * (smooth + corner)
    near, far = (
        0.5 * math.hypot(*(each.standard for each in ends)) for ends in ((begin, end), (earlier, later))
    )
    # a smooth peak goes a hundredth of a step beyond an edge once in a hundred records: a narrower level is
    # mostly one of noise, which reads it in any of the rows that are as little below it
    share = _BY_LITTLE if _is_smooth(values, float(below), top) else 0.0
    share = _BY_NOISE if _is_noisy(values, first, last) else share
    of_noise = share * max(0.0, wider - _NARROW * width)
    of_ends = math.hypot((1.0 + ahead) * max(near, of_noise), ahead * far)
    of_shape = 0.5 * (corner - smooth) * shift
    return middle - ahead * shift, min(math.hypot(within, of_noise), math.hypot(of_ends, of_shape))
