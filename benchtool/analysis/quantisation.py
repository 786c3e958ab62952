"""The step in which the values of a channel count."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

COARSE = 1e-4  # of the peak-to-peak: a smaller step is the last digit of a number, and no resolution
_LOOKED_AT = 1 << 16  # samples


def resolution(samples: NDArray[np.float64]) -> float:
    """Smallest nonzero difference between distinct values of samples, shape (n,); 0 if all are the same.

    The step of a quantised signal; of one that was computed, only the rounding. Of a long record 65536
    samples, evenly spread, are looked at.
    """
    few = samples[:: max(1, len(samples) // _LOOKED_AT)]
    steps = np.diff(np.unique(few))
    return float(np.min(steps)) if len(steps) else 0.0
