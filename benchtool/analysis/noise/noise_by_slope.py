"""Noise at harmonics of few periods, by the bins of several orders around, along whose slope it goes on."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum
from benchtool.analysis.distributions import median_of_exponentials
from benchtool.analysis.noise.noise import FEWEST_BINS, bins_between, slope_within
from benchtool.analysis.statistics.medians import medians

Floats = NDArray[np.float64]

_AROUND = 20  # bins
_DOF_OF_BIN = 2.0 * math.log(2.0) ** 2  # of a median of exponentials, whose variance is 1 / (n log(2)^2)


def noise_by_slope(spectrum: CoherentSpectrum, orders: int) -> tuple[Floats, Floats]:
    """Return the power of one component of the noise at harmonics 1 to `orders`, and its degrees of freedom,
    both of shape (orders,); nan, and 0, where fewer than eight bins are between harmonics.

    It is the median of the twenty nearest bins between harmonics, along a power law of frequency where their
    density clearly has one; to both sides as far as there are any, so that at the fundamental the power law
    goes on beyond them, and tells less.
    """
    between = bins_between(spectrum)
    between = between[(between > 0) & (spectrum.amplitude[between] > 0.0)]
    count = min(_AROUND, len(between))
    if count < FEWEST_BINS:
        return np.full(orders, np.nan), np.zeros(orders)
    lines = spectrum.periods * np.arange(1, orders + 1)
    first = np.clip(np.searchsorted(between, lines) - count // 2, 0, len(between) - count)
    around = between[first[:, np.newaxis] + np.arange(count)]
    place = np.log(around)
    centre = np.mean(place, axis=1)
    about = place - centre[:, np.newaxis]
    width2 = np.sum(about**2, axis=1)
    square = np.square(spectrum.amplitude[around])
    slope = np.array([slope_within(*each) for each in zip(square, around, strict=True)])
    away = np.log(lines) - centre
    level = medians(square * np.exp(-slope[:, np.newaxis] * about)) / median_of_exponentials(count)
    dof = _DOF_OF_BIN * count / (1.0 + count * away**2 / width2)
    return 0.5 * level * np.exp(slope * away), dof
