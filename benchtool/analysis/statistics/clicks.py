"""Clicks: values far beyond the rest of a record, which are not the tail of its noise."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import least_odds, students_deviation

Floats = NDArray[np.float64]

_FURTHEST, _CELLS = 10.0, 2000  # standard deviations, in a table
_FEWEST_CLICKS, _MOST_CLICKS = 5, 20  # fewer have no deviation to speak of, more are a tail
_ROUNDING = 1e-9  # of a size
_JEFFREYS = 0.5  # prior of a Poisson number
_LEVELS, _HIGHEST = 64, 4.0  # of a course; standard deviations of a click
_OF_ONE = 0.75  # of its size: the deviation of sizes about their mean where heights are normal


@dataclass(frozen=True)
class ClicksApart:
    """Values far beyond the rest: their `sizes`, shape (n,), how many of them are above zero, the largest of
    the `rest` there, and how probable it is that they are not the tail of that."""

    sizes: Floats
    above: int
    rest: float
    probability: float

    def scatter_of_largest(self, share: float) -> float:
        """Return the standard deviation of the largest value over records of this length times a share.

        Their number is Poisson's: with k expected the largest has the distribution function exp(-k (1 - F)),
        F their own, which is taken to be normal, and is that of the rest where there are none. Their
        deviation is Student's, as they are few.
        """
        dof = len(self.sizes) - 1.0
        spread = float(np.std(self.sizes, ddof=1)) * students_deviation(dof)
        expected = share * (self.above + _JEFFREYS)
        value, above = normal_above()
        largest = float(np.mean(self.sizes)) + spread * value
        largest[0] = self.rest
        return _deviation(largest, np.exp(-expected * above))


@dataclass(frozen=True)
class KnownClicks:
    """Clicks of a record of so many `rows`: how far each is above what it would be, `heights`, and in which
    row, `places`, both of shape (n,)."""

    heights: Floats
    places: NDArray[np.int64]
    rows: int

    @property
    def are_few(self) -> bool:
        """Whether there are any, and no more than are told from a tail."""
        return 0 < len(self.heights) <= _MOST_CLICKS

    @property
    def tell_their_size(self) -> bool:
        """Whether they are enough to have a deviation to speak of."""
        return len(self.heights) >= _FEWEST_CLICKS

    def scatter_of_greatest(self, side: Callable[[Floats], Floats], course: Floats, others: Floats) -> float:
        """Return the standard deviation of the greatest of values about a course, shape (n,), over records in
        which such clicks may be in any row; course and the `others`, the values that are none, shape (m,),
        are as seen from a side.

        Of one click no spread is known: it is taken to be that of normal heights.
        """
        if not len(others):
            return 0.0
        sizes, rest = np.abs(self.heights), float(np.max(others))
        mean = float(np.mean(sizes))
        spread = _OF_ONE * mean
        if len(sizes) > 1:
            spread = float(np.std(sizes, ddof=1)) * students_deviation(len(sizes) - 1.0)
        rows, edges = np.histogram(course, _LEVELS)
        levels = 0.5 * (edges[:-1] + edges[1:])
        value, above = normal_above()
        greatest = np.linspace(rest, max(rest, float(levels[-1]) + mean + _HIGHEST * spread), _CELLS)
        higher = (greatest - levels[:, np.newaxis] - mean) / max(spread, _ROUNDING * mean)
        of_one = rows @ np.interp(higher, value, above) / self.rows
        expected = np.count_nonzero(side(self.heights) > 0.0) + _JEFFREYS
        return _deviation(greatest, np.exp(-expected * of_one))

    def scatter_of_sum_of_squares(self, rows: int) -> float:
        """Return the standard deviation of the sum of their squares in so many rows."""
        largest = float(np.max(np.abs(self.heights)))
        fourth = (self.heights / largest) ** 4
        expected = rows / self.rows * (float(np.sum(fourth)) + _JEFFREYS * float(np.mean(fourth)))
        return largest * largest * math.sqrt(expected)


def _deviation(values: Floats, below: Floats) -> float:
    """Return the standard deviation of a value by the probabilities `below` that it is at most each of rising
    `values`, both of shape (n,)."""
    mass = np.diff(below, prepend=0.0)
    mean = float(mass @ values)
    return math.sqrt(float(mass @ (values - mean) ** 2))


def clicks_apart(deviations: Floats, step: float = 0.0) -> ClicksApart | None:
    """Return the clicks among deviations about zero, shape (n,), whose magnitudes a gap separates from the
    rest, by more than the `step` of a converter; None where there may be none.

    Between the order statistics of a power law's values the i-th gap of their logarithms from above is
    exponential with mean 1 / i (Rényi: David and Nagaraja, Order Statistics, 3rd ed. 2003, 2.5). That the
    m-th is more than c times the spread of the m values above it has a probability of the product over i < m
    of i / (i + c m); of so many m one may be so by chance (Bonferroni). It must also be more than they differ
    by among themselves, by their standard deviation.
    """
    order = np.argsort(np.abs(deviations))[::-1]
    sizes = np.abs(deviations[order[: _MOST_CLICKS + 1]])
    counts = np.arange(_FEWEST_CLICKS, len(sizes))
    least, next_to, tiny = sizes[counts - 1] - 0.5 * step, sizes[counts] + 0.5 * step, np.finfo(float).tiny
    if not np.any(least > next_to):
        return None
    # a ratio to the least number there is would overflow
    gaps = np.log(np.maximum(least, tiny)) - np.log(np.maximum(next_to, tiny))
    spread = np.log(sizes[0]) - np.log(np.maximum(sizes[counts - 1], tiny))
    ratios = counts * np.maximum(gaps, 0.0) / np.maximum(spread, _ROUNDING)
    chances = [-float(np.sum(np.log1p(c / np.arange(1, m)))) for m, c in zip(counts, ratios, strict=True)]
    at = int(np.argmin(chances))
    count, odds = int(counts[at]), least_odds(min(1.0, len(counts) * math.exp(chances[at])))
    is_clear = least[at] - next_to[at] > float(np.std(sizes[:count], ddof=1))
    if not is_clear or odds >= 1.0:
        return None
    above, rest = int(np.count_nonzero(deviations[order[:count]] > 0.0)), deviations[order[count:]]
    return ClicksApart(sizes[:count], above, float(np.max(rest)), 1.0 / (1.0 + odds))


@cache
def normal_above() -> tuple[Floats, Floats]:
    """Return normal values, and with which probability others are above them."""
    value = np.linspace(-_FURTHEST, _FURTHEST, _CELLS)
    return value, np.array([0.5 * math.erfc(each / math.sqrt(2.0)) for each in value])
