"""What phases of periods do about a slow course: swings, and their spectrum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.spectral_window import spectral_window

Floats = NDArray[np.float64]

DEGREE = 3
"""Of a course that is no swing."""


@dataclass(frozen=True)
class Swings:
    """Phases about a cubic `course` over their numbers, shape (n,), rad; their `power` in bins of n periods,
    shape (n // 2 + 1,), under a Hann window, rad^2 so that it sums up to their mean square."""

    course: np.polynomial.Polynomial
    phase_rad: Floats
    power: Floats

    @staticmethod
    def of(phase_rad: Floats) -> Swings:
        """Return those of phases in each period, shape (n,)."""
        count = len(phase_rad)
        place = np.arange(count, dtype=np.float64)
        course = np.polynomial.Polynomial.fit(place, phase_rad, DEGREE)
        swings = phase_rad - course(place)
        window = spectral_window("hann", count)
        power = np.abs(fft.rfft(swings * window)) ** 2 * (2.0 / count / float(window @ window))
        return Swings(course, np.asarray(swings), power)
