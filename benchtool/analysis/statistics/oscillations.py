"""By how much oscillations of a record, which holds no whole number of their cycles, move its mean."""

from __future__ import annotations

import math

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.spectral_window import line_at, spectral_window
from benchtool.analysis.statistics.medians import MEDIAN_OF_RMS, median

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_OF_HANN = 0.375  # mean square of the window
_MOST_LINES, _OF_LINE = 8, 2  # lines whose cycles are told; bins on either side of one that have its power
_BESIDE = 30  # further bins on either side, whose median is the noise


def mean_moved_by_oscillations(samples: Floats, lowest: int) -> float:
    """Return the standard deviation of the mean of samples, shape (n,), by oscillations of `lowest` cycles
    and more, wherever they begin: sin^2(pi k) / (pi k)^2 of the mean square of k cycles.

    How many cycles a line has, its noise leaves uncertain by about its rms amplitude over that of the line,
    in cycles. Where that is a large part of one, as of noise, any part of a cycle is as likely, and the
    square of the sine a half.
    """
    bins = _tapered_bins(samples)
    power, number = _power(bins, len(samples)), np.arange(len(bins))
    of_cycles = np.full(len(bins), 0.5)
    for place, sine2 in _lines(bins, lowest):
        of_cycles[max(lowest, place - _OF_LINE) : place + _OF_LINE + 1] = sine2
    inner = slice(lowest, None)
    return math.sqrt(2.0 * float(np.sum(of_cycles[inner] * power[inner] / number[inner] ** 2))) / math.pi


def tapered_power(samples: Floats) -> Floats:
    """Return the power of samples, shape (n,), in bins under Hann's window, which keeps oscillations from the
    lowest of them, as the variance of a mean that noise of this density has, shape (n // 2 + 1,)."""
    return _power(_tapered_bins(samples), len(samples))


def _lines(bins: Complexes, lowest: int) -> list[tuple[int, float]]:
    """Return the bins of the lines that move the mean most, the largest of them last, whose power is in bins
    beside it too, and of each the expectation of sin^2(pi k), k the cycles of it in the record."""
    size = np.abs(bins)
    inner = np.arange(lowest, len(size) - 1)
    peaks = inner[(size[inner] > size[inner - 1]) & (size[inner] >= size[inner + 1])]
    found = []
    for peak in peaks[np.argsort(size[peaks] / peaks)][-_MOST_LINES:].tolist():
        offset, amplitude = line_at(size, peak)
        first, last = peak - _OF_LINE - 1, peak + _OF_LINE + 2
        beside = np.concatenate([size[max(1, first - _BESIDE) : max(1, first)], size[last : last + _BESIDE]])
        if amplitude > 0.0 and len(beside):
            is_told = math.exp(-2.0 * (math.pi * median(beside) / MEDIAN_OF_RMS / amplitude) ** 2)
            found.append((peak, 0.5 * (1.0 - is_told * math.cos(2.0 * math.pi * (peak + offset)))))
    return found


def _tapered_bins(samples: Floats) -> Complexes:
    window = spectral_window("hann", len(samples))
    return np.asarray(fft.rfft((samples - np.sum(window * samples) / np.sum(window)) * window))


def _power(bins: Complexes, count: int) -> Floats:
    return np.asarray((bins.real**2 + bins.imag**2) / (_OF_HANN * count**2))
