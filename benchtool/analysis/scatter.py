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
