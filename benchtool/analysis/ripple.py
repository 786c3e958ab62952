"""Ripple of a signal about its mean."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.validity import require_signal


@dataclass(frozen=True)
class Ripple:
    """Mean and deviation of a signal, in the signal's `unit`."""

    mean: float
    peak_to_peak: float
    rms: float
    unit: str


def ripple(samples: NDArray[np.float64], unit: str, name: str = "signal") -> Ripple:
    """Ripple of uniformly sampled values, shape (n,).

    `peak_to_peak` is maximum minus minimum of all samples, `rms` the root mean square of the deviation from
    the mean (divided by n, not n - 1). Nothing is filtered. `name` stands in the messages.

    Raises:
        AnalysisError: too short, not finite, or constant.
    """
    require_signal(samples, name)
    return Ripple(
        mean=float(np.mean(samples)),
        peak_to_peak=float(np.max(samples) - np.min(samples)),
        rms=float(np.std(samples)),
        unit=unit,
    )
