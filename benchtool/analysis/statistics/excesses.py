"""By how much the largest of values differs from record to record, by what they exceed a high level by.

Peaks over threshold: beyond a high level the values of most distributions have Pareto's generalised
distribution, of the index of their tail (Embrechts, Klüppelberg and Mikosch, Modelling Extremal Events, 3.4
and 6.5).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import equally_likely
from benchtool.analysis.statistics.maxima import l_moments
from benchtool.analysis.statistics.scatter import error_of_series
from benchtool.analysis.statistics.tail import GUMBEL, extreme_over_excess, moment_estimate

FEWEST_EXTREMES = 4
"""Fewest values whose largest tell how it scatters."""

_OF_ROOT = 1.5  # largest values, over the root of how many there are
_FEW_MAXIMA, _OF_THEIR_OWN = 20, 0.6  # values, and of the deviation of all
_NEIGHBOURS = 2  # values that count as one by chance alone
_OF_HEAVY, _FEWEST_OF_HEAVY = 20, 20  # one value in so many is of a heavy tail; values
_NORMAL = equally_likely(16)
_NORMAL_OVER_WIDTH, _OF_HEAVY_WIDTH = math.sqrt(math.pi), 0.5  # of an L-moment; so of tails of index 1/3


def scatter_of_largest(values: NDArray[np.float64], *tails: float) -> float:
    """Return standard deviation of the largest of values, shape (n,), over records of as many; nan if n < 4.

    Beyond a high level the values of most distributions fall off exponentially; the largest then has Gumbel's
    distribution, of the standard deviation pi / sqrt(6) times the mean excess over that level (Embrechts,
    Klüppelberg and Mikosch, Modelling Extremal Events, 3.4 and 6.5). With heavy tails, of the index that
    `tail_index` finds, the excess has Pareto's distribution and the largest Fréchet's; of several indices,
    each as likely, the mean of the variances is taken. Of correlated values few maxima are left, whose top
    says little: their own deviation, or that above the median where it is less, is the least then. Of few
    values the excess of three or four is low by chance: six tenths of the deviation of all are the least.
    """
    if len(values) < FEWEST_EXTREMES:
        return math.nan
    # the largest of as many neighbours as are correlated counts as one
    apart = math.ceil(len(values) / (error_of_series(values).dof + 1.0) - 1e-9)
    least = 0.0
    if 1 < apart <= len(values) // FEWEST_EXTREMES:
        values = np.maximum.reduceat(values, np.arange(0, len(values), apart))
        if apart > _NEIGHBOURS:
            least = min(float(np.std(values, ddof=1)), _above_median(values))
    count = len(values)
    # fewer are low by chance where the largest is, and its error then is many times what they say
    beyond = max(FEWEST_EXTREMES - 1, round(_OF_ROOT * math.sqrt(count)))
    if count <= _FEW_MAXIMA:
        least = max(least, _OF_THEIR_OWN * float(np.std(values, ddof=1)))
    top = np.partition(values, count - beyond - 1)[count - beyond - 1 :]
    excess = float(np.sum(top - np.min(top))) / beyond / _of_gumbel(count, beyond)
    square = (
        sum(extreme_over_excess(tail, beyond) ** 2 for tail in tails) / len(tails) if tails else GUMBEL**2
    )
    return max(least, math.sqrt(square) * excess)


def _above_median(values: NDArray[np.float64]) -> float:
    """Return the root mean square of how far values, shape (n,), are above their median: the largest does not
    scatter by what is below."""
    above = values - np.median(values)
    above = above[above > 0.0]
    return float(np.sqrt(np.sum(above**2) / max(1.0, len(values) // 2 - 0.5))) if len(above) else 0.0


@cache
def _of_gumbel(count: int, beyond: int) -> float:
    """Return the mean excess of the `beyond` largest of `count` values over the next, on average, of Gumbel's
    distribution of scale 1, by its quantiles at (i - 1/2) / n: above few values its tail has not begun."""
    share = (np.arange(count - beyond - 1, count) + 0.5) / count
    places = -np.log(-np.log(share))
    return float(np.mean(places[1:]) - places[0])


@dataclass(frozen=True)
class HeavyTail:
    """Tail of independent values that is heavier than a normal one: the mean `excess` of its `count` largest
    over the next, and indices, each as likely."""

    excess: float
    count: int
    indices: tuple[float, ...]

    @staticmethod
    def above(deviations: NDArray[np.float64]) -> HeavyTail | None:
        """Return that of the twentieth of deviations, shape (n,), that is largest; None of too few. Each
        index that the moment estimate allows counts the same."""
        above, top = deviations - np.median(deviations), len(deviations) // _OF_HEAVY
        if top < _FEWEST_OF_HEAVY:
            return None
        largest = np.partition(above, len(above) - top - 1)[len(above) - top - 1 :]
        index, standard = moment_estimate(above, top)
        excess = float(np.mean(largest) - np.min(largest)) * (top + 1.0) / top
        return HeavyTail(excess, top, tuple(index + standard * each for each in _NORMAL))

    def scatter_of_largest(self, maxima: NDArray[np.float64]) -> float:
        """Return the standard deviation of the largest of all values over records of as many; 0 where
        `maxima`, shape (periods,), of what they are in differ by clearly less than theirs, as where the
        largest are beside its crests. The largest of few maxima alone hardly tell it."""
        width, _ = l_moments(np.sort(maxima))
        # less two of its own standard deviations, each of some 1 / sqrt(n)
        least = _OF_HEAVY_WIDTH * max(0.0, 1.0 - 2.0 / math.sqrt(len(maxima)))
        least *= self._of_largest(max(1, self.count // len(maxima)))
        return self._of_largest(self.count) if width * _NORMAL_OVER_WIDTH > least else 0.0

    def _of_largest(self, count: int) -> float:
        squares = sum(extreme_over_excess(each, count) ** 2 for each in self.indices)
        return self.excess * math.sqrt(squares / len(self.indices))
