"""Course of a signal that is slower than a revolution, such as that of a speed that is run up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.statistics.neighbours import neighbours_alike

_FEWEST = 4  # means
_ROWS = 32  # in a mean, on average: of fewer the course would take noise along
_WHOLE = 0.5  # of the places of a whole revolution
_FEW = 6  # means, of which fewer tell hardly any course from chance
_BY_CHANCE, _OF_FEW = 1e-3, 0.03  # that means of noise alone have a line, or a parabola
_CLEARLY = 3.3  # standard deviations of what neighbours have in common


@dataclass(frozen=True)
class Turns:
    """Revolutions, or groups of them, in order: the middle of each and its `edges`, shape (n, 2), in turns,
    its weight, and at how many places of the circle it has rows, of shape (n,), how many rows each has on
    average, and how many turns there are in `total`."""

    middle: NDArray[np.float64]
    edges: NDArray[np.float64]
    weight: NDArray[np.float64]
    places: NDArray[np.int64]
    rows: float
    total: float

    @property
    def whole(self) -> NDArray[np.bool_]:
        """Which of them have rows nearly all round, shape (n,)."""
        return np.asarray(self.places > _WHOLE * np.max(self.places))


@dataclass(frozen=True)
class SlowCourse:
    """A cubic spline through means of turns, `values` in the middle of each, `at`, both of shape (n,)."""

    at: NDArray[np.float64]
    values: NDArray[np.float64]

    def __call__(self, turns: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the course at places in turns, shape (n,), on along the outer cubics beyond the means."""
        from scipy.interpolate import CubicSpline

        return np.asarray(CubicSpline(self.at, self.values)(turns))


def slow_course(left: NDArray[np.float64], turns: Turns) -> SlowCourse | None:
    """Return the course of what orders leave, whose sum in each turn times weights is `left`, shape (n,);
    None of fewer than four whole turns.

    Within a turn a course looks like orders: of one that rises by h in each, order k reads h / (pi k). The
    spline has next to nothing of orders itself, as their means are zero.
    """
    together = max(1, round(_ROWS / turns.rows))
    group = np.arange(len(left)) // together
    weight = np.bincount(group, weights=turns.weight)
    places = np.bincount(group, weights=turns.places)
    whole = places > _WHOLE * float(np.max(places))
    if np.count_nonzero(whole) < _FEWEST:
        return None
    means = np.bincount(group, weights=left)[whole] / weight[whole]
    at = np.bincount(group, weights=turns.weight * turns.middle)[whole] / weight[whole]
    return SlowCourse(at, means)


def is_no_chance(course: SlowCourse) -> bool:
    """Return whether means have a line, a parabola or neighbours in common by more than noise alone has."""
    means, count = course.values, len(course.values)
    whole = float(np.sum((means - np.mean(means)) ** 2))
    chance = _BY_CHANCE if count >= _FEW else _OF_FEW
    if not whole > 0.0:
        return False
    for degree in (1, 2):
        dof = count - degree - 1
        if dof < 1:
            break
        line = np.polynomial.Polynomial.fit(course.at, means, degree)
        left = float(np.sum((means - line(course.at)) ** 2))
        ratio = (whole - left) / degree / max(left / dof, np.finfo(float).tiny)
        if fisher_above(degree, dof, ratio) < chance:
            return True
    return neighbours_alike(means) > _CLEARLY
