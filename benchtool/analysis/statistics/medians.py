"""The median, for where thousands of few values each have one."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def median(values: NDArray[np.float64]) -> float:
    """Return the median of finite values, shape (n,), n > 0: that of numpy, which takes ten times as long to
    look at its arguments."""
    lower, upper = (len(values) - 1) // 2, len(values) // 2
    ordered = values.copy()
    ordered.partition((lower, upper))
    return 0.5 * (ordered.item(lower) + ordered.item(upper))
