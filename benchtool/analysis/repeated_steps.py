"""Errors that the steps of a converter make alike in every period of a signal, so that no scatter shows them.

Where the levels of a converter lie is not known to a fraction of its step: over all places of them the error
of a waveform x, read in steps of q under normal noise of s rms, is on average over the noise

    e = sum over k of c_k sin(2 pi k x / q - psi_k),   c_k = q / (pi k) exp(-2 pi^2 k^2 s^2 / q^2)

with phases psi_k that are uniform and, for different k, uncorrelated (Widrow and Kollar, Quantization Noise,
2008, ch. 4 and 16; Gray, IEEE Trans. Inf. Theory 36 (1990) 1220). What it does to a mean, to an rms or to a
line is linear in it, and its mean square a sum over k.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

_TERMS = 20  # of few places in a period all fold into each line, and six hold a tenth less of the power
_NEGLIGIBLE = 1e-3  # of the first term
_FEWEST_POINTS, _MOST_POINTS = 1 << 10, 1 << 16
_POINTS_PER_STEP = 16  # that a waveform spans: the first two terms, of most of the power, do not fold back
_AT_PLACES = 0.9  # mean vector of samples about their places
_WHOLE = 0.5  # of the distance of such points: rows that move by less over the record stay on their places

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class RepeatedSteps:
    """Of one period of a waveform: `waveform`, shape (points,), at equal steps of its phase, and the `terms`,
    shape (k, points), complex: c_k exp(2 pi j k x / q), times the share of samples there over the mean share.
    """

    waveform: Floats
    terms: Complex

    def of_mean(self, weights: Floats | float = 1.0) -> float:
        """Return the rms of the mean of the error times weights, shape (points,)."""
        means = np.mean(self.terms * weights, axis=1)
        return math.sqrt(0.5 * float(np.sum(np.abs(means) ** 2)))

    @property
    def of_rms(self) -> float:
        """The rms of the change of the waveform's rms about its mean."""
        deviation = self.waveform - np.mean(self.waveform)
        rms = float(np.std(self.waveform))
        return self.of_mean(deviation / rms) if rms > 0.0 else 0.0

    def of_lines(self, phasors: Complex) -> tuple[Floats, Floats]:
        """Return the rms of the change of the amplitudes of harmonics 1, 2 ..., shape (n,), with the phase of
        `phasors`, and the mean square of the amplitude that is added to each.
        """
        count, points = len(phasors), self.terms.shape[1]
        bins = fft.fft(self.terms, axis=1) / points
        order = np.arange(1, count + 1)
        upper, lower = bins[:, order % points], bins[:, -order % points]
        towards = np.exp(1j * np.angle(phasors))
        along = np.abs(upper * np.conj(towards) + lower * towards) ** 2
        power = np.abs(upper) ** 2 + np.abs(lower) ** 2
        return np.sqrt(0.5 * np.sum(along, axis=0)), np.asarray(np.sum(power, axis=0))

    def power_at(self, orders: NDArray[np.int64]) -> Floats:
        """Return the mean square of the amplitude that the errors have at these orders, shape (n,)."""
        points = self.terms.shape[1]
        bins = fft.fft(self.terms, axis=1) / points
        power = np.abs(bins[:, orders % points]) ** 2 + np.abs(bins[:, -orders % points]) ** 2
        return np.asarray(np.sum(power, axis=0))


def repeated_steps(
    mean: float,
    phasors: Complex,
    step: float,
    noise_rms: float,
    samples: float,
    periods: int,
    turns: Floats | None = None,
) -> RepeatedSteps | None:
    """Return the errors of a quantised signal that are the same in every period; None where noise hides them.

    Of the measured harmonics 1, 2 ..., peak `phasors` of shape (n,), the waveform takes the strongest, until
    those left out are no more together than the quantisation's own rms: weaker ones may be made by it.

    Args:
        mean, phasors: of the signal as measured.
        step: of the converter.
        noise_rms: of all that differs from period to period.
        samples: in all periods; where a whole number of them is in one or a few periods, they fall on the
            same few places of the waveform again and again.
        periods: of the record.
        turns: where the samples are, in periods from the phase of the phasors on, shape (n,), if it is known:
            those of a speed that swings are at some places more often than at others.
    """
    number = np.arange(1, _TERMS + 1)
    exponent = -2.0 * math.pi**2 * number**2 * (noise_rms / step) ** 2
    size = step / (math.pi * number) * np.exp(exponent)
    number, size = number[size > _NEGLIGIBLE * step], size[size > _NEGLIGIBLE * step]
    if not len(number):
        return None
    kept = _without_the_weakest(phasors, step)
    spanned = 2.0 * float(np.sum(np.abs(kept))) / step
    needed = max(_FEWEST_POINTS, 4 * len(phasors), math.ceil(_POINTS_PER_STEP * spanned))
    points = _distinct(samples, periods, needed)
    if turns is not None and points < needed and _stay(turns, points):
        turns = None
    if turns is not None:
        points = min(needed, _MOST_POINTS)
    bins = np.zeros(points, dtype=np.complex128)
    np.add.at(bins, np.arange(1, len(kept) + 1) % points, kept)
    waveform = mean + np.real(fft.ifft(bins) * points)
    level = np.exp(2j * np.pi * np.mod(waveform / step, 1.0))
    terms = size[:, np.newaxis] * np.power(level[np.newaxis, :], number[:, np.newaxis])
    if turns is not None:
        place = np.floor(np.mod(turns, 1.0) * points).astype(np.int64) % points
        terms *= np.bincount(place, minlength=points) * (points / len(turns))
    return RepeatedSteps(waveform, terms)


def noise_beside(power: float, step: float) -> float:
    """Return the rms of the noise in a signal, by the mean square of what does not repeat: of that a twelfth
    of the step's square may be of the steps themselves."""
    return math.sqrt(max(0.0, power - step**2 / 12.0))


def share_left(noise_rms: float, step: float) -> float:
    """Return the rms of the error of a mean, of steps under noise, over that of steps without: 1 / sqrt(12)
    of them.

    The terms are by the characteristic function of the noise; of one whose distribution is not known it is
    that of Laplace's, with which more is left than with the normal one.
    """
    number = np.arange(1, _TERMS + 1)
    left = 1.0 / (1.0 + 2.0 * (math.pi * number * noise_rms / step) ** 2)
    return math.sqrt(float(np.sum((left / number) ** 2) / np.sum(1.0 / number**2)))


def _stay(turns: Floats, places: int) -> bool:
    """Return whether samples are at that many equally spaced places of the period, again and again."""
    return float(np.abs(np.mean(np.exp(2j * np.pi * places * turns)))) > _AT_PLACES


def _without_the_weakest(phasors: Complex, step: float) -> Complex:
    power = 0.5 * np.abs(phasors) ** 2
    order = np.argsort(power)
    weak = order[np.cumsum(power[order]) <= step**2 / 12.0]
    kept = phasors.copy()
    kept[weak] = 0.0
    return kept


def _distinct(samples: float, periods: int, needed: int) -> int:
    """Return at how many places of the waveform the samples are, at most as many as are needed."""
    per_period = samples / periods
    apart = per_period / needed
    for together in range(1, periods + 1):
        whole = round(together * per_period)
        if whole >= needed:
            break
        if abs(together * per_period - whole) * periods < _WHOLE * apart * together:
            return whole
    return min(needed, _MOST_POINTS)
