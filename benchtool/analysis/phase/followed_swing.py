"""By how much a track that follows a phase is off what swings within few periods.

It is a cubic spline through one phase in each period, and between these not the swing itself: of a sinusoid
of f cycles in a period the spline has the images f + k, each in proportion to sinc^4 (Unser, IEEE Signal
Processing Magazine 16 (1999), no. 6). Followed is what a Hann window over two periods sees alike of both.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.phase.swings import Swings
from benchtool.analysis.spectral_window import hann_response

Floats = NDArray[np.float64]

_IMAGES = np.arange(-3, 4)


def off_swing_rad(phase_rad: Floats) -> float:
    """Return how far, rms, a track is off the phase halfway between its knots, of phases in each period,
    shape (n,), by the spectrum of their swings."""
    power = Swings.of(phase_rad).power
    missed = _missed(np.arange(len(power)) / len(phase_rad))
    return math.sqrt(float(np.sum(power * missed**2)))


def _missed(cycles: Floats) -> Floats:
    """Return by how much the spline is off a sinusoid of so many cycles in a period, halfway, relative to its
    amplitude, shape (n,)."""
    image = cycles[:, np.newaxis] + _IMAGES
    share = np.sinc(image) ** 4
    share /= np.sum(share, axis=1, keepdims=True)
    seen = np.sum(share * hann_response(2.0 * image), axis=1)
    return np.asarray(np.sum(share * (-1.0) ** _IMAGES, axis=1) * hann_response(2.0 * cycles) / seen - 1.0)
