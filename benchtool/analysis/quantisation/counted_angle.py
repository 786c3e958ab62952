"""A speed that is computed of an angle by counts: how far each row of it is off by the rounding of both.

Between two counts of an encoder an angle is not read, and a speed that is how far it has come over some rows
is off by the difference of two such errors. They are no noise: a smooth motion says where within its count
each row is, all but for a constant. So the errors are computed, for constants that are evenly distributed,
and go through whatever analyses the speed: what they do to a line of it, and to what is beside it, is seen.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.quantisation.counted_motion import motion_behind
from benchtool.analysis.quantisation.repeated_steps import error_of_steps
from benchtool.analysis.quantisation.resolution import counting_step

Floats = NDArray[np.float64]

_PLACES, _TOGETHER = 32, 8  # within a count, at which others begin; of which so many are held in memory
_COUNTS_BEGIN = 0.5  # of one, from where a number is rounded up to it
_MOST_ROWS = 16  # over which a difference is taken
_ARE_WHOLE = 0.9  # of one, the mean direction of numbers that all are whole; share of those that are the same
_LOOKED_AT = 4093  # rows, hardly at the same place of all revolutions


@dataclass(frozen=True)
class CountedAngle:
    """An angle in counts of `count_rad`, of which a speed in steps of `step`, rad/s, is how far it has come
    over so many `rows`.

    `places` are those of the motion at the times the counts were read at, shape (times,), in counts, but for
    what it `shakes` by and what the `edges` of the counts are off even places, both rms; `at` are the times
    between which each speed is, the later first, shape (2, n). `angle_rad` is the motion itself at each row,
    shape (n,).
    """

    count_rad: float
    rows: int
    step: float
    places: Floats
    shakes: float
    edges: float
    at: NDArray[np.int64]
    angle_rad: Floats

    def added(self) -> Floats:
        """Return what rounding has added to the speed, rad/s, shape (n,), as the motion tells it."""
        return np.asarray(self._added(np.array([_COUNTS_BEGIN]))[0])

    def may_add(self) -> Iterator[Floats]:
        """Yield what it adds where counts begin at other places, evenly distributed, and edges are off by
        others: some of them at a time, shape (places, n)."""
        random = np.random.default_rng(0)
        edge = np.mod(np.floor(self.places), round(2.0 * math.pi / self.count_rad)).astype(np.int64)
        edge = np.unique(edge, return_inverse=True)[1]
        places = (np.arange(_PLACES) + 0.5) / _PLACES
        for some in np.split(places, _PLACES // _TOGETHER):
            added = self._added(some)
            if self.edges > 0.0:
                off = self.edges * random.standard_normal((len(some), int(edge.max()) + 1))[:, edge]
                added += self.step * (off[:, self.at[0]] - off[:, self.at[1]])
            yield added

    def _added(self, levels: Floats) -> Floats:
        off = error_of_steps(self.places, 1.0, self.shakes, levels[:, np.newaxis])
        if off is None:  # which noise hides
            return np.zeros((len(levels), self.at.shape[1]))
        return np.asarray(self.step * (off[:, self.at[0]] - off[:, self.at[1]]))


def counted_angle(angle_rad: Floats, speed: Floats, times: Floats, rate_Hz: float) -> CountedAngle | None:
    """Return the counts of an angle without jumps of which a speed, rad/s, is the difference over some rows;
    None where it is not.

    Both are of shape (n,), read at `times`, shape (n,), in rows, of which some may be missing. Such a speed
    is the whole number of counts that have come in some rows, these or others near by, but for the rounding
    of its format, which is less than a count: so it is told by those of the angle, and not by its own values.
    """
    count_rad = counting_step(np.mod(angle_rad, 2.0 * math.pi))
    if not count_rad > 0.0:
        return None
    counts = np.round((angle_rad - angle_rad[0]) / count_rad)
    few = np.linspace(0, len(angle_rad) - 1, min(len(angle_rad), _LOOKED_AT)).astype(np.int64)
    if not _are_whole((angle_rad - angle_rad[0])[few] / count_rad):
        return None
    for rows in range(1, _MOST_ROWS + 1):
        step = count_rad * rate_Hz / rows
        if not _are_whole(speed[few] / step):
            continue
        late = _late(np.round(speed[few] / step), counts, times, times[few], rows)
        if late is not None:
            return _followed(angle_rad, counts, times, count_rad, rows, step, late)
    return None


def _are_whole(numbers: Floats) -> bool:
    return float(np.real(np.mean(np.exp(2j * np.pi * numbers)))) > _ARE_WHOLE


def _late(numbers: Floats, counts: Floats, times: Floats, at: Floats, rows: int) -> int | None:
    """Return by how many rows numbers, shape (m,), `at` some of the times, are later than the counts, shape
    (n,), that come in so many rows; None where they are not these."""
    for late in sorted(range(-_MOST_ROWS, _MOST_ROWS + 1), key=abs):
        ends = np.stack([at - late, at - late - rows])
        place = np.minimum(np.searchsorted(times, ends), len(times) - 1)
        are_read = np.all(times[place] == ends, axis=0)
        come = counts[place[0]] - counts[place[1]]
        usual = np.median(come)  # which tells nothing of a shaft that turns evenly
        tells = are_read & ((numbers != usual) | (come != usual))
        if np.any(tells) and float(np.mean((numbers == come)[tells])) > _ARE_WHOLE:
            return late
    return None


def _followed(
    angle_rad: Floats, counts: Floats, times: Floats, count_rad: float, rows: int, step: float, late: int
) -> CountedAngle:
    """Return the motion behind the counts of an angle, both of shape (n,)."""
    motion = motion_behind(counts, times, count_rad)
    ends = np.stack([times - late, times - late - rows])
    read_at, at = np.unique(ends, return_inverse=True)
    places = motion.at(read_at, count_rad * np.interp(read_at, times, counts))
    followed_rad = angle_rad[0] + count_rad * motion.at(times, count_rad * counts)
    at = at.reshape(ends.shape)
    return CountedAngle(count_rad, rows, step, places, motion.shakes, motion.edges, at, followed_rad)
