"""Noise that every family may have."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Floats = NDArray[np.float64]


def coloured(noise: Floats, pole: float) -> Floats:
    """White noise of unit rms behind a first-order low-pass with this pole, of unit rms again."""
    if not pole:
        return noise
    begin = np.array([pole * noise[0] / math.sqrt(1.0 - pole**2)])
    filtered, _ = signal.lfilter([1.0], [1.0, -pole], noise, zi=begin)
    return np.asarray(filtered * math.sqrt(1.0 - pole**2))
