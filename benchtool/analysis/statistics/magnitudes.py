"""Magnitudes and roots of powers, which noise bends where they are small."""

from __future__ import annotations

import math

from benchtool.analysis.uncertainty import coverage_factor

_MAY_BE_NOISE = 4.45  # times either part of the noise: by chance one magnitude in twenty thousand
_OF_NOISE_ALONE = 0.75  # of its parts: noise reads up to 2.45 of them in 95 % of records (Rayleigh)


def added_by_noise(magnitude: float, part: float) -> float:
    """Return by how much noise makes a magnitude larger, or may do so where it may be noise alone; `part` is
    the standard deviation of the noise across it (Rice distribution)."""
    if not math.isfinite(part):
        return 0.0
    bias = magnitude - math.sqrt(max(0.0, magnitude**2 - part**2))
    return max(bias, _OF_NOISE_ALONE * part) if magnitude < _MAY_BE_NOISE * part else bias


def standard_of_root(square: float, deviation: float) -> float:
    """Return the standard uncertainty of the root of a square, at least 0, of a known standard deviation.

    The root is steep at zero: its expanded uncertainty is the longer side of the roots of two standard
    deviations of the square.
    """
    root, least = math.sqrt(square), math.sqrt(max(0.0, square - 2.0 * deviation))
    return max(math.sqrt(square + 2.0 * deviation) - root, root - least) / coverage_factor(math.inf)
