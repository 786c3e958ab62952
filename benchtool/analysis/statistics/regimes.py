"""Whether a record is stationary, by the sizes of its periods."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

STANDS_OUT = 5.0  # standard uncertainties
_QUARTERS = 4
_LARGEST_CHANGE = 0.1


def change_of_regime(sizes: NDArray[np.float64], what: str) -> str:
    """Return why a record is not stationary; empty if it is.

    Its quarters differ in their mean of `sizes`, shape (periods,), by more than 10 % and what noise does.
    `what` names the sizes in the reason.
    """
    parts = min(_QUARTERS, len(sizes) // 2)
    if parts < 2:
        return ""
    groups = np.array_split(sizes, parts)
    means = np.array([float(np.mean(each)) for each in groups])
    # the median, because the change itself may be within one of the parts
    squares = [float(np.var(each, ddof=1)) / len(each) / _median_of_variance(len(each)) for each in groups]
    noise = math.sqrt(float(np.median(squares)))
    change, middle = float(np.ptp(means)), abs(float(np.mean(means)))
    if change <= _LARGEST_CHANGE * middle + STANDS_OUT * noise:
        return ""
    return (
        f"{what} changes from {means.min():.3g} to {means.max():.3g} between parts of the window, at most "
        f"{100 * _LARGEST_CHANGE:g} % is allowed: choose a window in steady state"
    )


def _median_of_variance(count: int) -> float:
    """Return the median of the variance of so many normal values, over its mean (Wilson and Hilferty)."""
    return (1.0 - 2.0 / (9.0 * (count - 1))) ** 3
