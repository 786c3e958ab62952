"""A line whose frequency drifts over many bins: in none of them it stands out, and together they may be the
largest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.spectral_window import spectral_window

_OF_LINE = 1.5  # power of a line in all of its bins, relative to a bin that has its amplitude
_NARROWEST = 10  # bins in which a line that drifts is sought, then twice as many, and so on
_MOST = 0.25  # of all bins
_SPREAD = 6.0  # bins that have the power; a steady line has two
_AT_EDGES = 0.5  # of the greatest power within
_ONE_SIZE = 0.95  # squared correlation of the envelope with the window; of noise it is pi / 4
_PER_BIN = 4  # points of an envelope


@dataclass(frozen=True)
class DriftingLine:
    """A line that drifts: its mean place, and how far from that it is, in bins of the record, and its peak
    amplitude."""

    place: float
    reach: float
    amplitude: float


def drifting_line(bins: NDArray[np.complex128], lowest: int) -> DriftingLine | None:
    """Return the largest line that drifts over many bins, from the `lowest` on, of a spectrum under a Hann
    window, as peak amplitudes of shape (n,); None where what has most power in as many bins is none.

    Its power is spread, and at any time it has one size: the envelope of these bins is that of the window. Of
    noise it has Rayleigh's distribution, of clicks it is high at few times.
    """
    power = np.abs(bins) ** 2
    sums = np.concatenate([[0.0], np.cumsum(power)])
    found: DriftingLine | None = None
    width = _NARROWEST
    while lowest + width < _MOST * len(bins):
        within = sums[lowest + width :] - sums[lowest:-width]
        first = lowest + int(np.argmax(within))
        band = slice(first, first + width)
        if _is_spread(power[band]) and _has_one_size(bins[band]):
            total = float(np.sum(power[band]))
            place = float(np.arange(band.start, band.stop) @ power[band]) / total
            amplitude = math.sqrt(total / _OF_LINE)
            if found is None or amplitude > found.amplitude:
                found = DriftingLine(place, 0.5 * width, amplitude)
        width *= 2
    return found


def _is_spread(power: NDArray[np.float64]) -> bool:
    """Return whether powers of bins, shape (n,), rise to many of them and fall again."""
    spread = float(np.sum(power)) ** 2 / float(power @ power) if np.any(power) else 0.0
    return spread > _SPREAD and max(power[0], power[-1]) < _AT_EDGES * float(np.max(power))


def _has_one_size(bins: NDArray[np.complex128]) -> bool:
    """Return whether the envelope of bins, shape (n,), is that of their Hann window."""
    count = _PER_BIN * len(bins)
    envelope, window = np.abs(fft.fft(bins, count)), spectral_window("hann", count)
    alike = float(envelope @ window) ** 2 / (float(envelope @ envelope) * float(window @ window))
    return alike > _ONE_SIZE
