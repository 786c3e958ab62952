"""Medians, for where thousands of few values each have one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

MEDIAN_OF_RMS = math.sqrt(math.log(2.0))
"""Median of Rayleigh-distributed amplitudes over their rms, 0.8326.

Their distribution is P(A < a) = 1 - exp(-a^2 / rms^2) (Papoulis, Probability, Random Variables, and
Stochastic Processes, 4th ed., 6.2), which is one half at a = rms sqrt(ln 2).
"""


def median(values: NDArray[np.float64]) -> float:
    """Return the median of finite values, shape (n,), n > 0: that of numpy, which takes ten times as long to
    look at its arguments."""
    lower, upper = (len(values) - 1) // 2, len(values) // 2
    ordered = values.copy()
    ordered.partition((lower, upper))
    return 0.5 * (ordered.item(lower) + ordered.item(upper))


def medians(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the median of each row of finite values, shape (rows, n), n > 0."""
    lower, upper = (values.shape[1] - 1) // 2, values.shape[1] // 2
    ordered = np.partition(values, (lower, upper), axis=1)
    return np.asarray(0.5 * (ordered[:, lower] + ordered[:, upper]))
