"""The noise around a line of a spectrum under a Hann window: of neighbouring bins, without other lines."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.lines.line_models import middle_bins
from benchtool.analysis.spectral_window import hann_response, interpolated, line_at
from benchtool.analysis.statistics.medians import MEDIAN_OF_RMS, median

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

MAIN_LOBE = 3
"""Bins on either side of a line that belong to it, under a Hann window."""

BESIDE = 30
"""Further bins on either side, whose median is the noise."""

_NEAR = 6  # of these the nearest, which a narrow band of noise fills on both sides, another line on one
_STEEPEST = 3.0  # fall of an amplitude over frequency, as a power: that of a drift under a Hann window
_CLUSTER = 14  # bins on either side in which lines beside a line are fitted
_STANDS_OUT, _LINES_ALONE = 5.0, 0.2  # of the noise further away; of what there is without the lines
_MOST_UNKNOWNS = 0.7  # of the bins
_ROUNDS, _STEP = 3, 1e-3  # of the fit; bins
_ROUNDING = 1e-13  # of a line, by the Fourier transform


@dataclass(frozen=True)
class Surrounded:
    """A line at a `place`, in bins, of an `amplitude`, and the rms amplitude of noise in a bin there, and, as
    far as other bins tell it, `far` from there."""

    place: float
    amplitude: float
    noise: float
    far: float


def surrounded(bins: Complexes, size: Floats, place: int) -> Surrounded:
    """Return the line at a local maximum of `size`, the magnitude of `bins`, both of shape (bins,), and the
    noise around it, nan where there are no bins.

    The line is interpolated between its two greatest bins (Jain, Collins, Davis, IEEE Trans. Instrum. Meas.
    28 (1979) 113). The noise is that of the bins to both sides, or more where these fall with frequency, as
    red noise does: then a power law through them is continued to the place; rounding at least. A narrow band
    of noise is as high on both sides nearby. So are other lines on both sides, as of a speed that swings:
    those are fitted, all at once, and what they leave is the noise.
    """
    offset, amplitude = line_at(size, place)
    first, last = place - MAIN_LOBE, place + MAIN_LOBE + 1
    number = np.concatenate(
        [np.arange(max(1, first - BESIDE), max(1, first)), np.arange(last, min(last + BESIDE, len(size)))]
    )
    if not len(number):
        return Surrounded(place + offset, amplitude, math.nan, math.nan)
    by_bins = max(median(size[number]) / MEDIAN_OF_RMS, _continued(number, size[number], place))
    far = noise = max(by_bins, _ROUNDING * amplitude)
    below, above = size[max(1, first - _NEAR) : max(1, first)], size[last : last + _NEAR]
    if len(below) == len(above) == _NEAR:
        nearby = min(median(below), median(above)) / MEDIAN_OF_RMS
        if nearby > noise:
            fitted = _among_lines(bins, size, place, noise)
            if fitted is not None and fitted.noise < _LINES_ALONE * nearby:
                return replace(fitted, noise=max(noise, fitted.noise))
            noise = nearby
    return Surrounded(place + offset, amplitude, noise, far)


def _continued(number: NDArray[np.int64], around: Floats, place: int) -> float:
    """Return the rms amplitude at a place by a falling power law through amplitudes around it, at bins
    `number`, both of shape (n,); its slope is the median of those between all pairs (Theil and Sen), which
    single lines do not move."""
    if len(number) < 2 or not np.all(around > 0.0):
        return 0.0
    at, level = np.log(number.astype(np.float64)), np.log(around)
    one, other = _pairs(len(number))
    slope = median((level[other] - level[one]) / (at[other] - at[one]))
    slope = min(0.0, max(-_STEEPEST, slope))
    return math.exp(median(level - slope * (at - math.log(place)))) / MEDIAN_OF_RMS


@cache
def _pairs(count: int) -> tuple[NDArray[np.int64], ...]:
    """Return the numbers of both of every pair of so many."""
    return np.triu_indices(count, 1)


def _among_lines(bins: Complexes, size: Floats, place: int, noise: float) -> Surrounded | None:
    """Return the line at a place by least squares of the amplitudes and places of all lines nearby, and the
    noise that they leave; None where there are too many to tell them from noise."""
    number = np.arange(max(1, place - _CLUSTER), min(len(size) - 1, place + _CLUSTER + 1))
    is_peak = (size[number] > size[number - 1]) & (size[number] >= size[number + 1])
    peaks = number[is_peak & (size[number] > _STANDS_OUT * noise)]
    if place not in peaks or 2 * len(peaks) > _MOST_UNKNOWNS * len(number):
        return None
    places = np.array([peak + interpolated(size, int(peak))[0] for peak in peaks])
    in_the_middle = middle_bins(bins, number)  # there size and place are independent
    for _ in range(_ROUNDS):
        apart = number[:, np.newaxis] - places
        steeper = (hann_response(apart + _STEP) - hann_response(apart - _STEP)) / (2.0 * _STEP)
        basis = np.concatenate([hann_response(apart), steeper], axis=1)
        found = np.linalg.lstsq(basis, in_the_middle, rcond=None)[0]
        amplitudes, moved = found[: len(places)], found[len(places) :]
        rest = in_the_middle - basis @ found
        places = places - np.clip(np.real(moved / amplitudes), -1.0, 1.0)
    own = int(np.argmin(np.abs(peaks - place)))
    left = math.sqrt(float(np.sum(np.abs(rest) ** 2)) / (len(number) - basis.shape[1]))
    return Surrounded(float(places[own]), float(np.abs(amplitudes[own])), left, noise)
