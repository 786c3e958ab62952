"""Turning directions: what machine and control share of trigonometry."""

from __future__ import annotations

import math

from benchtool.emulator.jit import njit

_SMALL = 0.05  # rad, up to which the series below are exact to rounding


@njit
def rotate(cosine: float, sine: float, angle: float) -> tuple[float, float]:
    """Return the cosine and sine of an angle that has grown by `angle` rad."""
    if abs(angle) <= _SMALL:
        q = angle * angle
        s = angle * (1.0 + q * (-1.0 / 6.0 + q * (1.0 / 120.0 - q * (1.0 / 5040.0))))
        c = 1.0 + q * (-0.5 + q * (1.0 / 24.0 + q * (-1.0 / 720.0 + q * (1.0 / 40320.0))))
    else:
        s, c = math.sin(angle), math.cos(angle)
    return cosine * c - sine * s, sine * c + cosine * s
