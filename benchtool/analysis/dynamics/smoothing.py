"""Noise of a record, and a smooth curve through a noisy transient.

A functional of single samples (greatest, first beyond a level) takes noise for the answer, so the curve is
smoothed first: at every sample by a local parabola (Savitzky and Golay, Anal. Chem. 36 (1964) no. 8) over a
window that grows with the time since the event that set the transient off, up to a greatest length. How
fast and how long is chosen by Stein's unbiased estimate of the risk (Ann. Statist. 9 (1981) no. 6) for the
noise as it is, and then shortened, so that what is left is noise and hardly any bias (undersmoothing: Hall,
Ann. Statist. 20 (1992) no. 2). Where there is no noise, the samples stay as they are.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy import fft, signal

Floats = NDArray[np.float64]

_GROWTH = (0.1, 0.2, 0.3, 0.45, 0.65)  # half window over samples since the event
_STEPS = 4  # of the half window, for each time it doubles
_SHORTER = 1.5  # how much shorter the window is than the one of least risk
_PART = 5  # the greatest half window is at most this part of what follows the event
_LAGS = 4  # lags of an autocovariance: this part of its samples
_ROUNDING = 1e-7  # of the level: what is less is rounding of 32-bit numbers, and no noise


@dataclass(frozen=True)
class Noise:
    """Stationary noise of equally spaced samples: its autocovariance at lags 0, 1, ..., beyond them 0."""

    autocovariance: Floats

    @classmethod
    def of(cls, *pieces: Floats) -> Noise:
        """What a straight line leaves over of samples at rest; of several pieces the noisiest.

        The autocovariance is tapered by Bartlett's window, with which its spectrum is nowhere negative
        (Priestley, Spectral Analysis and Time Series, 6.2.3). Pieces of fewer than eight samples say nothing.
        """
        found = [_autocovariance(piece) for piece in pieces if len(piece) >= 8]
        return cls(max(found, key=lambda each: float(each[0]), default=np.zeros(1)))

    @property
    def rms(self) -> float:
        return math.sqrt(float(self.autocovariance[0]))

    def draw(self, random: np.random.Generator, shape: tuple[int, int]) -> Floats:
        """Gaussian noise of this autocovariance, shape (records, samples)."""
        records, samples = shape
        lags = len(self.autocovariance)
        size = fft.next_fast_len(samples + lags, real=True)
        circular = np.zeros(size)
        circular[:lags] = self.autocovariance
        circular[size - lags + 1 :] = self.autocovariance[:0:-1]
        amplitude = np.sqrt(np.maximum(fft.rfft(circular).real, 0.0))
        white = fft.rfft(random.standard_normal((records, size)), axis=1)
        return np.asarray(fft.irfft(white * amplitude, size, axis=1)[:, :samples], dtype=np.float64)


@dataclass(frozen=True)
class Smoother:
    """Windows of a smooth curve: the `half` of each in samples, shape (n,), never decreasing.

    The smoother is linear: it makes of signal and noise together what it makes of each.
    """

    half: NDArray[np.int64]

    @classmethod
    def growing(cls, count: int, growth: float, longest: float) -> Smoother:
        """Half windows of `growth` times the samples since the event, in steps, up to `longest`."""
        wanted = np.minimum(growth * np.arange(count), longest)
        stepped = np.exp2(np.floor(_STEPS * np.log2(np.maximum(wanted, 1.0))) / _STEPS)
        return cls(np.where(wanted < 1.0, 0, np.floor(stepped)).astype(np.int64))

    def apply(self, records: Floats) -> Floats:
        """Smooth curves of records, shape (..., n); at the end they are continued as in a mirror."""
        curve = records.astype(np.float64, copy=True)
        for half in np.unique(self.half[self.half > 0]).tolist():
            rows = np.flatnonzero(self.half == half)
            begin, end = int(rows[0]), int(rows[-1]) + 1
            mirrored = records[..., -2 : -2 - max(0, end + half - records.shape[-1]) : -1]
            window = np.concatenate([records[..., begin - half : end + half], mirrored], axis=-1)
            weights = _parabola(half).reshape((1,) * (records.ndim - 1) + (-1,))
            curve[..., begin:end] = signal.oaconvolve(window, weights, mode="valid", axes=-1)
        return curve


class _Smoothed:
    """Samples, shape (n,), under every window that a smoother may have, each calculated once."""

    def __init__(self, samples: Floats, noise: Noise) -> None:
        self._samples = samples
        self._noise = noise
        self._curves: dict[int, tuple[Floats, float]] = {}

    def risk(self, smoother: Smoother) -> float:
        """Stein's unbiased estimate of the sum of the squared errors that a smoother leaves."""
        total = -float(self._noise.autocovariance[0]) * len(self._samples)
        edges = [0, *(np.flatnonzero(np.diff(smoother.half)) + 1).tolist(), len(smoother.half)]
        for begin, end in pairwise(edges):
            curve, correlation = self._under(int(smoother.half[begin]))
            left = curve[begin:end] - self._samples[begin:end]
            total += float(left @ left) + 2.0 * (end - begin) * correlation
        return total

    def _under(self, half: int) -> tuple[Floats, float]:
        """The samples under one window, and the covariance of what it makes of noise with that noise."""
        if half not in self._curves:
            weights = _parabola(half)
            ends = np.pad(self._samples, half, mode="reflect") if half else self._samples
            curve = signal.oaconvolve(ends, weights, mode="valid")
            lags = min(half + 1, len(self._noise.autocovariance))
            products = weights[half : half + lags] * self._noise.autocovariance[:lags]
            self._curves[half] = curve, float(2.0 * np.sum(products) - products[0])
        return self._curves[half]


def fitted_smoothers(samples: Floats, noise: Noise) -> tuple[Smoother, Smoother]:
    """Smoothers for the samples since an event, shape (n,): the shortened one and that of least risk.

    What the second makes otherwise than the first is as large as the bias that may be left in the first.
    """
    count = len(samples)
    none = Smoother(np.zeros(count, dtype=np.int64))
    if noise.rms == 0.0:
        return none, none
    smoothed = _Smoothed(samples, noise)
    best, shortened, least = none, none, smoothed.risk(none)
    longest = max(1.0, count / _PART)
    for growth in _GROWTH:
        for step in range(int(2.0 * math.log2(longest)) + 1):
            length = longest / 2.0 ** (0.5 * step)
            smoother = Smoother.growing(count, growth, length)
            if (risk := smoothed.risk(smoother)) < least:
                best, least = smoother, risk
                shortened = Smoother.growing(count, growth / _SHORTER, length / _SHORTER)
    return shortened, best


def _parabola(half: int) -> Floats:
    """Weights by which 2 `half` + 1 samples give the middle of their least-squares parabola."""
    places = np.arange(-half, half + 1, dtype=np.float64)
    if half == 0:
        return np.ones(1)
    weights = 3.0 * (3.0 * half * (half + 1.0) - 1.0) - 15.0 * places**2
    return weights / ((2.0 * half - 1.0) * (2.0 * half + 1.0) * (2.0 * half + 3.0))


def _autocovariance(piece: Floats) -> Floats:
    places = np.linspace(-1.0, 1.0, len(piece))
    level = float(np.mean(piece))
    slope = float(np.sum(places * (piece - level)) / np.sum(places**2))
    left = piece - level - slope * places
    if float(np.std(left)) <= _ROUNDING * float(np.max(np.abs(piece))):
        return np.zeros(1)
    lags = max(1, len(piece) // _LAGS)
    size = fft.next_fast_len(2 * len(piece), real=True)
    power = np.abs(fft.rfft(left, size)) ** 2
    found = fft.irfft(power, size)[:lags] / max(1, len(piece) - 2)
    return np.asarray(found * (1.0 - np.arange(lags) / lags), dtype=np.float64)
