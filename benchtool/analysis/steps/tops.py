"""The greatest value of a curve between its samples: on a polynomial, or where two straight courses meet."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_OUTSIDE = 0.1  # of the bend at a kink: what the curve bends by on both sides of it
_ROUNDING = 1e-9  # of a slope
_SIGNIFICANT = 5.0  # standard deviations of a second difference that noise alone does not have
_OF_SECOND_DIFFERENCE = math.sqrt(6.0)  # standard deviation over that of a sample
_SMOOTH = 0.9  # square of the rate of a mode per row: a period in seven rows, and no kink
_OF_OTHERS, _SPARSE = 0.25, 1.0  # of a fifth difference: by other modes; more where the rows are few
_REACHED, _NEWTON = 0.6, 4  # rows from its greatest sample that a top may be; steps of Newton's method
_OF_PARABOLA, _OF_BEND = 0.4, 0.02  # of what it adds, and of the bend: how uncertain a top of three is
_SWINGS = 0.05  # of how far the curve falls from it: it comes back by more, if it oscillates
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


def of_three(values: Floats, top: int, noise: float) -> Top | None:
    """Return the top of a peak of so few of the values, shape (n,), that the curve bends the other way beside
    it: that of the parabola through three. None where the curve does not, and where it does not swing back
    within the next four beyond `noise`, the standard deviation of a value: after an edge the greatest may be
    the first.
    """
    if not 0 < top < len(values) - 4 or (top > 1 and np.max(np.diff(values[top - 2 : top + 3], 2)) < 0.0):
        return None
    before, greatest, after = values[top - 1 : top + 2].tolist()
    later = values[top + 1 : top + 5]
    lowest = int(np.argmin(later))
    falls, rises = greatest - float(later[lowest]), float(np.max(later[lowest:]) - later[lowest])
    least = max(_SIGNIFICANT * _OF_SECOND_DIFFERENCE * noise, _SWINGS * falls)
    bend, slope = before + after - 2.0 * greatest, 0.5 * (after - before)
    if not min(-bend, falls, rises, greatest - before) > least:
        return None
    above = -(slope**2) / (2.0 * bend)
    error = math.hypot(_OF_PARABOLA * above, _OF_BEND * bend)
    return Top(above, error, min(max(-slope / bend, -0.5), 0.5), 0.5)
