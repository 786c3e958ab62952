"""The greatest value of a curve between its samples: on a polynomial, or where two straight courses meet."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_OUTSIDE = 0.1  # of the bend at a kink: what the curve bends by on both sides of it
_ROUNDING = 1e-9  # of a slope
_WIDER = 1.0  # rows, as both ends are uncertain by: less tells nothing of what a level is wider by
_SIGNIFICANT = 5.0  # standard deviations of a second difference that noise alone does not have
_OF_SECOND_DIFFERENCE = math.sqrt(6.0)  # standard deviation over that of a sample
_SMOOTH = 0.9  # square of the rate of a mode per row: a period in seven rows, and no kink
_OF_OTHERS, _SPARSE = 0.25, 1.0  # of a fifth difference: by other modes; more where the rows are few
_REACHED, _NEWTON = 0.6, 4  # rows from its greatest sample that a top may be; steps of Newton's method
_TOGETHER = 0.5  # of the rows from the first to the last on a level
_NARROW, _BY_NOISE = 3.0, 1.0 / 6.0  # times narrower than the level before; of the width of that
_VANDERMONDE = np.vander(np.arange(-2.0, 3.0), increasing=True)


@dataclass(frozen=True)
class Top:
    """How far a curve goes above its greatest sample, and how far from it, in samples; with the uncertainty
    of the one and a bound of the error of the other."""

    above: float
    above_error: float
    beside: float
    beside_within: float


def parabola(values: Floats, top: int) -> Top:
    """Return the vertex of the parabola through the greatest of values, shape (n,), and its neighbours; the
    greatest value itself beside an edge.

    Between samples a curve goes on as it bends only where it bends the same way at both neighbours. How much
    differently it does there is known: a third difference moves the height by at most a sixteenth of it, and
    the more uneven it is the less is known of the vertex at all.
    """
    if not 1 < top < len(values) - 2:
        return Top(0.0, 0.0, 0.0, 0.5)
    bends = np.diff(values[top - 2 : top + 3], 2)
    bend, slope = float(bends[1]), 0.5 * float(values[top + 1] - values[top - 1])
    if np.max(bends) >= 0.0:
        return Top(0.0, 0.0, 0.0, 0.5)
    uneven = float(np.max(np.abs(bends - bend)))
    place = min(max(-slope / bend, -0.5), 0.5)
    above = -(slope**2) / (2.0 * bend)
    doubt = above * min(1.0, uneven / abs(bend)) / math.sqrt(3.0)
    return Top(above, math.hypot(uneven / 16.0, doubt), place, min(0.5, uneven / (4.0 * abs(bend))))


def quartic(values: Floats, top: int) -> Top | None:
    """Return the top of the polynomial of fourth degree through the greatest of values, shape (n,), and two
    on either side; None where these are so few for what bends there that it may as well be a kink.

    Of a mode that decays or oscillates the fifth derivative follows from those before it: f5 = (f3 / f2) f4 -
    r f3, where r = (f3 / f2)^2 - f4 / f2 is the square of its rate, as f1 is 0 at its top. By f5 the
    polynomial is off, in proportion to x (1 - x^2) (4 - x^2) / 120 at a place x; what other modes add is in
    proportion to f2 r^(3/2).
    """
    if not 1 < top < len(values) - 2:
        return None
    before, bend, after = np.diff(values[top - 2 : top + 3], 2).tolist()
    if max(before, bend, after) >= 0.0:
        return None
    third, fourth = 0.5 * (after - before), after + before - 2.0 * bend
    square = abs((third / bend) ** 2 - fourth / bend)
    if square >= _SMOOTH:
        return None
    _, c1, c2, c3, c4 = np.linalg.solve(_VANDERMONDE, values[top - 2 : top + 3] - values[top]).tolist()
    place = 0.0
    for _ in range(_NEWTON):
        slope = c1 + place * (2.0 * c2 + place * (3.0 * c3 + place * 4.0 * c4))
        bent = 2.0 * c2 + place * (6.0 * c3 + place * 12.0 * c4)
        if bent >= 0.0:
            return None
        place = min(max(place - slope / bent, -_REACHED), _REACHED)
    if abs(place) == _REACHED:
        return None
    above = place * (c1 + place * (c2 + place * (c3 + place * c4)))
    fifth = math.hypot(third / bend * fourth - square * third, _OF_OTHERS * bend * square**1.5)
    fifth *= 1.0 + _SPARSE * square
    error = abs(place) * (1.0 - place**2) * (4.0 - place**2) / 120.0 * fifth
    beside = 4.0 / 120.0 * fifth / -bend
    # beside its place the top is higher, by its bend
    error = math.hypot(error, 0.5 * bend * beside**2)
    return Top(max(0.0, above), error, place, min(0.5, math.sqrt(3.0) * beside))


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
    share = 0.5 * (smooth + corner)
    near, far = (
        0.5 * math.hypot(*(each.standard for each in ends)) for ends in ((begin, end), (earlier, later))
    )
    # a smooth peak goes a hundredth of a step beyond an edge once in a hundred records: a narrower level is
    # mostly one of noise, which reads it in any of the rows that are as little below it
    of_noise = _BY_NOISE * max(0.0, wider - _NARROW * width) if _is_noisy(values, first, last) else 0.0
    of_ends = math.hypot((1.0 + share) * max(near, of_noise), share * far)
    of_shape = 0.5 * (corner - smooth) * shift
    return middle - share * shift, min(math.hypot(within, of_noise), math.hypot(of_ends, of_shape))


def kink(values: Floats, top: int, noise: float) -> Top | None:
    """Return where the courses before and after the greatest of values, shape (n,), meet; None where it is no
    kink, by `noise`, the standard deviation of a value, or by how it bends.

    A kink between two samples bends the curve in both, and hardly in those beyond, two on either side: of a
    smooth top in few samples one alone may be where it bends neither way. A curve of so few samples that it
    bends the other way beside its greatest may be anywhere between that and where the lines meet.
    """
    if not 0 < top < len(values) - 4:
        return None
    # four before the top, and four after it; before the first row, in which it was at rest, there are none
    near = np.pad(values[max(0, top - 4) : top + 5], (max(0, 4 - top), 0), mode="edge")
    rises = np.diff(near)
    bends = np.diff(rises)
    at = float(bends[3])
    if -at <= _SIGNIFICANT * _OF_SECOND_DIFFERENCE * noise:
        return None
    earlier, rise, fall, later = rises[2:6].tolist()
    far = np.abs(bends)
    found = []
    # between the top and the next: the line that led to it, and the one that leads on from the next
    if rise > later and 0.0 < (place := (fall - later) / (rise - later)) < 1.0:
        found.append((rise * place, place, float(np.max(far[[1, 2, 5, 6]])), abs(at + float(bends[4]))))
    if earlier > fall and 0.0 < (place := (earlier - rise) / (earlier - fall)) < 1.0:
        found.append((-fall * place, -place, float(np.max(far[[0, 1, 4, 5]])), abs(float(bends[2]) + at)))
    above, place, beside, bend = max(found, default=(0.0, 0.0, 0.0, 1.0))
    if not above > _ROUNDING * (rise - fall):
        # at the row itself, as near as the courses beside it bend
        bent = float(np.max(far[[1, 2, 4, 5]])) / -at
        return Top(0.0, max(rise, -fall) * bent, 0.0, bent) if bent < _OUTSIDE else None
    if beside < _OUTSIDE * bend:
        # the courses bend on the way to it as they do beside it
        return Top(above, beside, place, min(0.5, math.hypot(beside, _OF_SECOND_DIFFERENCE * noise) / bend))
    if np.max(bends[2:5]) < 0.0:
        return None  # a smooth top
    return Top(0.5 * above, above / math.sqrt(12.0), 0.5 * place, 0.5)
