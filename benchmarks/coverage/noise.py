"""Noise that every family may have, and the steps of a converter."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Floats = NDArray[np.float64]


def coloured(noise: Floats, pole: float) -> Floats:
    """Return the white noise of unit rms behind a first-order low-pass with this pole, of unit rms again."""
    if not pole:
        return noise
    begin = np.array([pole * noise[0] / math.sqrt(1.0 - pole**2)])
    filtered, _ = signal.lfilter([1.0], [1.0, -pole], noise, zi=begin)
    return np.asarray(filtered * math.sqrt(1.0 - pole**2))


def converted(values: Floats, step: float, random: np.random.Generator) -> Floats:
    """Return the values as a converter gives them, whose offset puts its levels anywhere."""
    offset = step * random.uniform(-0.5, 0.5)
    return np.asarray(np.round((values - offset) / step) * step + offset)
