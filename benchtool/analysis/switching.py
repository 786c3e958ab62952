"""Switching frequency from the drive's counter of turn-ons."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.errors import AnalysisError

_LEGS = 3
_WRAP = 2.0**32


def mean_switching_frequency_Hz(switching_count: NDArray[np.float64], sample_period_s: float) -> float:
    """Mean frequency of one switch: turn-ons of the three upper switches / (3 * duration).

    `switching_count`, shape (n,), counts the turn-ons of all three upper switches since power-up and wraps
    around as a u32; the duration is that of the n - 1 intervals between the samples.

    Raises:
        AnalysisError: fewer than two samples, or the counter went backwards (the drive restarted).
    """
    if len(switching_count) < 2:
        raise AnalysisError(
            f"'switching_count' has {len(switching_count)} samples, at least 2 are needed: "
            f"record a longer window"
        )
    turn_ons = np.mod(np.diff(switching_count), _WRAP)
    if not np.all(turn_ons < _WRAP / 2):
        raise AnalysisError(
            "'switching_count' went backwards within the window, a counter that only grows (u32, wrapping) "
            "is expected: the drive restarted, choose a window on one side of it"
        )
    return float(np.sum(turn_ons)) / (_LEGS * len(turn_ons) * sample_period_s)
