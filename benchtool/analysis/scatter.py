"""How far a mean is to be trusted, from the record itself."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_PARTS = 10


def error_of_mean(samples: NDArray[np.float64]) -> float:
    """Standard uncertainty of the mean of samples, shape (n,), that need not be independent; nan if n < 20.

    The record is cut into ten equal parts; the scatter of their means over sqrt(10) is what is wanted
    (batch means: Law, Simulation Modeling and Analysis, 9.5.3), as long as a part is longer than what
    correlates the samples.
    """
    size = len(samples) // _PARTS
    if size < 2:
        return math.nan
    means = np.mean(samples[: size * _PARTS].reshape(_PARTS, size), axis=1)
    return float(np.std(means, ddof=1)) / math.sqrt(_PARTS)


def extreme_scatter(samples: NDArray[np.float64]) -> float:
    """Standard uncertainty of the greatest or least of samples, shape (n,), as records like it scatter.

    The greatest of many follow Gumbel's distribution, whose width does not depend on how many they are: the
    greatest of each tenth of the record scatter as the greatest of records do (Coles, An Introduction to
    Statistical Modeling of Extreme Values, 3.1). Of the two ends the one that scatters more; nan if n < 20.
    """
    size = len(samples) // _PARTS
    if size < 2:
        return math.nan
    parts = samples[: size * _PARTS].reshape(_PARTS, size)
    return max(float(np.std(of(parts, axis=1), ddof=1)) for of in (np.min, np.max))
