"""How far an angle gets about a steady rise, from one end of a record to the other: what it repeats in every
turn, and its course, by splines of any stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

_OF_QUADRATIC = 3
FEWEST = 12
"""Means, of which a quadratic leaves nine degrees of freedom."""

_LEAST, _GREATEST, _STIFFNESSES = 1e-2, 1e8, 31  # of the variance of the course over that of the noise
_NONE = 0.1  # probability beforehand that there is no course but a quadratic
_MOST_PLACES, _FEWEST_PLACES = 64, 8
FEWEST_TURNS = 2

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Change:
    """From the first to the last instant: `size`, its standard uncertainty, and degrees of freedom of
    that."""

    size: float
    standard: float
    dof: float


@dataclass(frozen=True)
class Repeated:
    """What is done in every turn alike: its `values` about zero, shape (n,), and the `standard` uncertainty
    of how far these get from the first to the last, by what differs from turn to turn."""

    values: Floats
    standard: float


@dataclass(frozen=True)
class _Course:
    """A random course over n means, of covariance `together`, shape (n, n), `with_end` of its change, shape
    (n,), and `of_end`. Beside a quadratic it has `variances`, shape (n - 3,), along a `basis`, shape (n, n -
    3), in which the change by the quadratic alone leaves out `missed`."""

    variances: Floats
    basis: Floats
    missed: Floats
    together: Floats
    with_end: Floats
    of_end: float


def repeated_in_turns(values: Floats, turns: Floats) -> Repeated:
    """Return what `values` do in every turn alike; both of shape (n,), `turns` rising from zero.

    Means over the turns at up to 64 places in them, without what the means of whole turns rise, less the
    share of their power that what differs from turn to turn leaves in them (Wiener's estimate, and the noise
    in that); zero of fewer than two turns.
    """
    whole = int(turns[-1])
    places = min(_MOST_PLACES, int(0.5 * len(turns) / max(float(turns[-1]), 1.0)))
    if whole < FEWEST_TURNS or places < _FEWEST_PLACES:
        return Repeated(np.zeros(len(values)), 0.0)
    cells = whole * places
    cell = np.minimum(np.floor(turns * places).astype(np.int64), cells)
    count = np.maximum(1, np.bincount(cell, minlength=cells)[:cells])
    table = (np.bincount(cell, weights=values, minlength=cells)[:cells] / count).reshape(whole, places)
    centre, middles = (np.arange(places) + 0.5) / places, np.mean(table, axis=1)
    table = table - middles[:, np.newaxis] - np.outer(np.gradient(middles), centre - 0.5)
    shape = np.mean(table, axis=0)
    power, noise = float(np.mean(shape**2)), float(np.mean(np.var(table, axis=0, ddof=1))) / whole
    if not power > noise:
        return Repeated(np.zeros(len(values)), 0.0)
    share = 1.0 - noise / power
    found = share * np.interp(turns % 1.0, centre, shape, period=1.0)
    between = abs(float(turns[-1]) % 1.0 - float(turns[0]) % 1.0)
    apart = min(1.0, places * min(between, 1.0 - between))  # ends at one place err alike
    return Repeated(np.asarray(found), apart * share * math.sqrt(2.0 * noise))


def change_over_record(means: Floats) -> Change:
    """Return how far a course gets over the record, whose means over equal parts are of shape (n,), with n of
    at least `FEWEST`.

    Means are a quadratic, a course, and noise that is another in each. A course is the sum of random steps,
    or the sum of that, as an angle is whose speed wanders: the best estimate is then a linear or a cubic
    smoothing spline (Wahba, *Spline Models for Observational Data*, 1.5), carried on to the ends of the
    record. How much of it there is beside the noise is as likely as the means say (restricted likelihood);
    what all of these differ by is in the uncertainty.
    """
    own, courses = _courses(len(means))
    left2 = np.square(courses[0].basis.T @ means)
    free, power = len(left2), float(np.sum(left2))
    sizes, variances = [float(own @ means)], [power / free * float(own @ own)]
    if not power > 0.0:
        return Change(sizes[0], 0.0, float(free))
    likelihoods = [math.log(_NONE) - 0.5 * free * math.log(power)]
    of_each = math.log((1.0 - _NONE) / (len(courses) * _STIFFNESSES))
    for course in courses:
        left2 = np.square(course.basis.T @ means)
        for ratio in np.geomspace(_LEAST, _GREATEST, _STIFFNESSES) / float(np.mean(course.variances)):
            spread = 1.0 + ratio * course.variances
            power = float(np.sum(left2 / spread))
            weights = own - course.basis @ (ratio * course.missed / spread)
            of_course = weights @ course.together @ weights - 2.0 * weights @ course.with_end + course.of_end
            error2 = float(weights @ weights + ratio * of_course)
            sizes.append(float(weights @ means))
            variances.append(power / free * max(0.0, error2))
            likelihoods.append(of_each - 0.5 * float(np.sum(np.log(spread))) - 0.5 * free * math.log(power))
    shares = np.exp(np.array(likelihoods) - max(likelihoods))
    shares /= np.sum(shares)
    size = float(shares @ sizes)
    variance = float(shares @ (np.array(variances) + (np.array(sizes) - size) ** 2))
    return Change(size, math.sqrt(variance), float(free))


@lru_cache(maxsize=8)
def _courses(count: int) -> tuple[Floats, tuple[_Course, ...]]:
    """Return the weights of so many means in the change of the quadratic alone, and the kinds of courses."""
    at = (np.arange(count) + 0.5) / count
    quadratic = np.vander(at, _OF_QUADRATIC)
    own = np.linalg.pinv(quadratic).T @ np.array([1.0, 1.0, 0.0])  # of x^2, x and 1, from 0 to 1
    rest = np.linalg.qr(quadratic, mode="complete")[0][:, _OF_QUADRATIC:]
    least, greatest = np.minimum.outer(at, at), np.maximum.outer(at, at)
    kinds = (
        (least, at, 1.0),
        (least**2 * (3.0 * greatest - least) / 6.0, at**2 * (3.0 - at) / 6.0, 1.0 / 3.0),
    )
    courses = []
    for together, with_end, of_end in kinds:
        variances, turned = np.linalg.eigh(rest.T @ together @ rest)
        basis = rest @ turned
        missed = basis.T @ (together @ own - with_end)
        courses.append(_Course(np.maximum(variances, 0.0), basis, missed, together, with_end, of_end))
    return own, tuple(courses)
