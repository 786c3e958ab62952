"""Resolution of a channel: the step between its values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_COARSE = 1e-5  # of the peak-to-peak: a smaller step is the last digit of a 32-bit number
_BY_CHANCE = 10.0  # times the mean of the least distance between as many values, exp(-10) by chance
_LOOKED_AT = 1 << 16  # samples


def resolution(samples: NDArray[np.float64]) -> float:
    """Return the smallest nonzero difference between distinct values of samples, shape (n,); 0 if all are the
    same.

    The step of a quantised signal; of one that was computed, only the rounding. Of a long record 65536
    samples, evenly spread, are used.
    """
    few = samples[:: max(1, len(samples) // _LOOKED_AT)]
    steps = np.diff(np.unique(few))
    return float(np.min(steps)) if len(steps) else 0.0


def counting_step(samples: NDArray[np.float64]) -> float:
    """Return resolution of samples, shape (n,), where it is that of a converter; 0 where it is no such step.

    A smaller step than a hundred-thousandth of the peak-to-peak is the last digit of a number. Of n values
    anywhere the two nearest are peak-to-peak / n^2 apart on average, which is no step either.
    """
    few = samples[:: max(1, len(samples) // _LOOKED_AT)]
    values = np.unique(few)
    if len(values) < 2:
        return 0.0
    step, span = float(np.min(np.diff(values))), float(values[-1] - values[0])
    return step if step > max(_COARSE, _BY_CHANCE / len(few) ** 2) * span else 0.0
