"""Whether neighbouring values of a series are correlated, by its own mean (von Neumann, 1941)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray


def neighbours_alike(values: NDArray[np.float64]) -> float:
    """Return the correlation of neighbouring values, shape (n,), n > 2, in standard deviations of that of
    independent ones, about their mean."""
    count, deviation = len(values), values - np.mean(values)
    square = float(deviation @ deviation)
    correlation = float(deviation[1:] @ deviation[:-1]) / square if square > 0.0 else 0.0
    return in_deviations(correlation, count)


def in_deviations(correlation: float, count: int) -> float:
    """Return the correlation of neighbours among `count` values, in standard deviations of that of
    independent ones, which is -1 / n on average."""
    return (correlation + 1.0 / count) / math.sqrt((count - 2.0) / (count**2 - 1.0))
