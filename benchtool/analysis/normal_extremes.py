"""By how much the largest of normal values differs from record to record.

Of N independent normal values the largest has the distribution function Phi^N (David and Nagaraja, Order
Statistics, 3rd ed. 2003, 2.1). Its standard deviation falls with N, in the end as 1 / sqrt(2 ln N), where
that of values with an exponential tail stays. Both come to Gumbel's distribution, normal ones so slowly
(ibid., 10.5) that its deviation, taken where the tail begins, is up to one and a half times theirs.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_OCTAVES = 24  # of numbers of values
_FURTHEST, _CELLS = 10.0, 2000  # standard deviations, in a table
_BY_CHANCE = 2.0  # standard deviations of a kurtosis


def is_no_heavier_than_normal(deviations: Floats) -> bool:
    """Return whether the kurtosis of deviations about zero, shape (n,), is at most by chance above that of
    normal ones, 3 with a variance of 24 / n."""
    square = float(np.mean(deviations**2)) if len(deviations) else 0.0
    if not square > 0.0:
        return False
    excess = float(np.mean(deviations**4)) / square**2 - 3.0
    return excess < _BY_CHANCE * math.sqrt(24.0 / len(deviations))


def scatter_of_largest_normal(maxima: Floats, noise_rms: float) -> float:
    """Return the standard deviation of the largest of maxima, shape (n,), over records of as many, where each
    is the largest of values in normal noise.

    Of how many values each is the largest is told by its deviation, over that of the noise.
    """
    of_one, count = float(np.std(maxima, ddof=1)), len(maxima)
    if not noise_rms > 0.0:
        return of_one
    octaves, deviations = _table()
    own = float(np.interp(-min(1.0, of_one / noise_rms), -deviations, octaves))
    of_all = float(np.interp(own + math.log2(count), octaves, deviations))
    return of_one * of_all / float(np.interp(own, octaves, deviations))


@cache
def _table() -> tuple[Floats, Floats]:
    """Return logarithms to the base 2 of numbers of values, and the standard deviation of the largest of as
    many, of normal ones of standard deviation 1."""
    value = np.linspace(-_FURTHEST, _FURTHEST, _CELLS)
    above = np.array([0.5 * math.erfc(each / math.sqrt(2.0)) for each in value])
    # above the mean by what is above, whose logarithm keeps its digits
    below = np.where(value > 0.0, np.log1p(-np.minimum(above, 0.5)), np.log(above[::-1]))
    octaves, middle = np.arange(0.0, _OCTAVES + 0.5, 0.5), 0.5 * (value[1:] + value[:-1])
    share = np.diff(np.exp(2.0 ** octaves[:, np.newaxis] * below), axis=1)
    mean = share @ middle
    return octaves, np.sqrt(np.sum(share * (middle - mean[:, np.newaxis]) ** 2, axis=1))
