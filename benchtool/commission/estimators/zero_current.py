"""What the current sensors read without current: offset and noise of each phase."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import resolution
from benchtool.errors import AnalysisError

_FEWEST = 50


@dataclass(frozen=True)
class ZeroCurrent:
    """Offset of one sensor in A, its standard uncertainty and degrees of freedom; rms noise of a sample."""

    offset_A: float
    standard_A: float
    dof: float
    noise_A_rms: float


def zero_current(readings_A: NDArray[np.float64]) -> ZeroCurrent:
    """Return offset and noise from readings without current, shape (n,).

    The offset is the mean. Its uncertainty is that of a mean of independent samples, and of the converter's
    step where the noise is too small to spread the readings over several: the mean of a quantised value lies
    then within half a step of the true one, a rectangular distribution (JCGM 100:2008, 4.3.7). Noise of half
    a step, rms, and more makes the mean free of it (Widrow and Kollar, Quantization Noise, 2008).

    Raises:
        AnalysisError: fewer than 50 readings.
    """
    n = len(readings_A)
    if n < _FEWEST:
        raise AnalysisError(f"{n} readings without current, {_FEWEST} at least are needed: record longer")
    noise = float(np.std(readings_A, ddof=1))
    step = resolution(readings_A)
    lost = step / math.sqrt(12.0) if noise < 0.5 * step else 0.0
    mean = noise / math.sqrt(n)
    return ZeroCurrent(float(np.mean(readings_A)), math.hypot(mean, lost), n - 1.0, noise)
