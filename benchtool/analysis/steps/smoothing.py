"""Noise of a record, and a smooth curve through a noisy transient.

A functional of single samples (greatest, first beyond a level) takes noise for the answer, so the curve is
smoothed first: at every sample by a local parabola (Savitzky and Golay, Anal. Chem. 36 (1964) no. 8) over a
window that grows with the time since the event that set the transient off, up to a greatest length. How
fast and how long is chosen by Stein's unbiased estimate of the risk (Ann. Statist. 9 (1981) no. 6) for the
noise as it is. Where a window spans an edge or a bend of the signal, at the end of a pulse or of a ramp, say,
it contradicts the shorter ones there, and the longest that contradicts none is taken (intersection of
confidence intervals: Goldenshluger and Nemirovski, Math. Methods Statist. 6 (1997) no. 2). Then all are
shortened, so that what is left is noise and hardly any bias (undersmoothing: Hall, Ann. Statist. 20 (1992)
no. 2). Where there is no noise, the samples stay as they are.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.fast_lengths import next_fast_length
from benchtool.analysis.statistics.lowest_frequencies import slow_noise
from benchtool.analysis.statistics.outlying_samples import without_outliers

Floats = NDArray[np.float64]

_GROWTH = (0.1, 0.2, 0.3, 0.45, 0.65)  # half window over samples since the event
_STEPS = 4  # of the half window, for each time it doubles
_CONTRADICTS = 6.0  # standard deviations between the values of two windows that noise does not exceed
_STRETCH, _CLIPPED = 4, 4.0  # windows over which differences are averaged; standard deviations of one in it
_ON_AVERAGE, _MOST_DOF = 4.0, 8.0  # standard deviations; of a mean square no more is known than noise itself
_OF_FEW = 2  # half window: a parabola through so few samples goes with any of them
_OUTLIER = 3.0  # standard deviations of a sample beyond all around it: rare in noise, and no edge
_CLEARANCE = 0.5  # of the distance to a contradiction: the most by which a half window is longer than there
_SHORTER = 1.5  # how much shorter the window is than the one of least risk
_SLIGHTLY = 1e-9  # of a step: smaller differences are rounding
_PART = 5  # the greatest half window is at most this part of what follows the event
_LAGS = 4  # lags of an autocovariance: this part of its samples
_MOST_OF_RMS = 2.0  # that noise too slow for a piece has of the rms that it shows
_CLEARLY_SLOWER = 1.0  # times the variance of a mean by the autocovariance
_SEED, _RECORDS = 20_261_201, 20  # of normal noise that tell how heavy that looks
_FEWEST_INNOVATIONS, _HEAVY_TAILED = 50, 3.0  # samples; standard deviations of a normal kurtosis
_LEAST_DENSITY = 1e-6  # of the greatest
_ALIKE = 0.5  # of the longest piece: others as long tell of the same slow noise
_BY_CHANCE = 2.0  # standard deviations between the variances of two pieces of one noise
_PRODUCTS = 2**19  # of samples and weights: up to that many the sum itself is quicker than transforms
_ROUNDING = 1e-7  # of the level: what is less is rounding of 32-bit numbers, and no noise


@dataclass(frozen=True)
class Noise:
    """Stationary noise of equally spaced samples: its autocovariance at lags 0, 1, ..., beyond them 0.

    `offset` is the standard deviation of noise too slow to show in so few samples, the same in all. Noise
    that is a line wherever the signal stays, at another frequency at each level, is at most of rms `as_line`.
    """

    FEWEST: ClassVar = 8
    """Samples of a piece: fewer do not show their noise."""

    autocovariance: Floats
    offset: float = 0.0
    innovations: Floats | None = None
    as_line: float = 0.0

    @classmethod
    def of(cls, *pieces: Floats) -> Noise:
        """Return the noise of samples at rest about a straight line; of several pieces all together or, where
        one is noisier than the longest by more than chance, that one.

        The noisiest would be so by chance as often, and of a short piece the slowest noise is hardly known.
        The autocovariance is tapered by Bartlett's window, with which its spectrum is nowhere negative
        (Priestley, Spectral Analysis and Time Series, 6.2.3). The line takes the slowest noise with it, which
        is given back: of the variance of a mean, twice. Pieces of fewer than eight samples are ignored.

        Noise that is not normal is drawn from its own `innovations`.
        """
        found = [(_autocovariance(piece), piece) for piece in pieces if len(piece) >= cls.FEWEST]
        if not found:
            return cls(np.zeros(1))
        covariance, piece = max(found, key=lambda each: len(each[1]))
        noisiest, shorter = max(found, key=lambda each: float(each[0][0]))
        if is_noisier(noisiest, len(shorter), covariance, len(piece)):
            covariance, piece = noisiest, shorter
            return cls(covariance, _offset(covariance, piece), _innovations(covariance, piece))
        together = _together(found)
        every = [each for _, each in found]
        offset = max(_offset(*each, every) for each in found if len(each[1]) >= _ALIKE * len(piece))
        return cls(together, offset, _innovations(together, piece))

    @property
    def rms(self) -> float:
        return math.sqrt(float(self.autocovariance[0]))

    def of_sum(self, weights: Floats) -> float:
        """Return the standard deviation of a sum of samples, each times its weight, shape (n,)."""
        lags = min(len(self.autocovariance), len(weights))
        size = next_fast_length(2 * len(weights))
        products = fft.irfft(np.abs(fft.rfft(weights, size)) ** 2, size)[:lags]
        covariance = self.autocovariance[:lags]
        square = 2.0 * float(products @ covariance) - float(products[0] * covariance[0]) if lags else 0.0
        return math.hypot(math.sqrt(max(0.0, square)), self.offset * float(np.sum(weights)))

    def of_sum_after_first(self, weights: Floats) -> float:
        """Return likewise that of the part which is not correlated with the first sample."""
        lags = min(len(self.autocovariance), len(weights))
        with_first = float(weights[:lags] @ self.autocovariance[:lags])
        with_first += self.offset**2 * float(np.sum(weights))
        of_first = math.hypot(self.rms, self.offset)
        whole = self.of_sum(weights)
        return math.sqrt(max(0.0, whole**2 - (with_first / of_first) ** 2)) if of_first else whole

    def of_mean(self, count: int) -> float:
        """Return the standard deviation of the mean of so many samples."""
        return self.of_sum(np.full(count, 1.0 / count))

    def of_mean_square(self, count: int) -> float:
        """Return the standard deviation of the mean of the squares of so many samples, if they are normal."""
        return math.sqrt(2.0) * Noise(self.autocovariance**2).of_mean(count)

    def draw(self, random: np.random.Generator, shape: tuple[int, int]) -> Floats:
        """Return noise of this autocovariance, shape (records, samples)."""
        records, samples = shape
        lags = len(self.autocovariance)
        size = next_fast_length(samples + lags)
        amplitude = np.sqrt(_density(self.autocovariance, size))
        if self.innovations is None:
            independent = random.standard_normal((records, size))
        else:
            independent = random.choice(self.innovations, (records, size))
        white = fft.rfft(independent, axis=1)
        drawn = np.asarray(fft.irfft(white * amplitude, size, axis=1)[:, :samples], dtype=np.float64)
        return drawn + self.offset * random.standard_normal((records, 1)) if self.offset else drawn


@dataclass(frozen=True)
class UnevenNoise:
    """Noise times `levels` that samples have, shape (n,)."""

    noise: Noise
    levels: Floats

    def rows(self, first: int, end: int) -> UnevenNoise:
        """Return that of the samples from a row to before another."""
        return UnevenNoise(self.noise, self.levels[first:end])

    @property
    def rms(self) -> Floats:
        """Root mean square at each sample, shape (n,)."""
        return np.asarray(self.noise.rms * self.levels)

    def of_sum(self, weights: Floats) -> float:
        """Return the standard deviation of a sum of samples, each times its weight, shape (n,)."""
        return self.noise.of_sum(weights * self.levels)

    def of_sum_of_squares(self) -> float:
        """Return the standard deviation of the sum of the squares of the samples, if they are normal."""
        return math.sqrt(2.0) * Noise(self.noise.autocovariance**2).of_sum(self.levels**2)

    def draw(self, random: np.random.Generator, records: int) -> Floats:
        """Return such noise, shape (records, n)."""
        return self.levels * self.noise.draw(random, (records, len(self.levels)))


@dataclass(frozen=True)
class Smoother:
    """Windows of a smooth curve: the `half` of each in samples, shape (n,), nowhere beyond the first sample.

    The smoother is linear in signal and noise.
    """

    half: NDArray[np.int64]

    @classmethod
    def growing(cls, most: Floats, growth: float, longest: float) -> Smoother:
        """Return half windows of `growth` times the samples since the event, up to `longest` and `most`."""
        return cls(_in_steps(np.minimum(np.minimum(growth * np.arange(len(most)), longest), most)))

    @property
    def runs(self) -> Iterator[tuple[int, int, int]]:
        """First row, end and half window of each run of rows with the same window."""
        edges = [0, *(np.flatnonzero(np.diff(self.half)) + 1).tolist(), len(self.half)]
        return ((begin, end, int(self.half[begin])) for begin, end in pairwise(edges))

    def shortened(self) -> Smoother:
        """Return the smoother with shorter windows, whose bias is small against the remaining noise."""
        return Smoother(_in_steps(self.half / _SHORTER))

    def apply(self, records: Floats) -> Floats:
        """Return smooth curves of records, shape (..., n); at the end they are continued as in a mirror."""
        curve = records.astype(np.float64, copy=True)
        for begin, end, half in self.runs:
            if half == 0:
                continue
            mirrored = records[..., -2 : -2 - max(0, end + half - records.shape[-1]) : -1]
            window = np.concatenate([records[..., begin - half : end + half], mirrored], axis=-1)
            weights = _parabola(half).reshape((1,) * (records.ndim - 1) + (-1,))
            curve[..., begin:end] = _convolved(window, weights)
        return curve


class _Smoothed:
    """Samples, shape (n,), under every window that a smoother may have, each calculated once."""

    def __init__(self, samples: Floats, noise: Noise, levels: Floats) -> None:
        self._samples = samples
        self._noise = noise
        self._levels = levels
        self._are_even = bool(np.all(levels == levels[0]))
        self._curves: dict[int, tuple[Floats, float]] = {}

    def risk(self, smoother: Smoother) -> float:
        """Return Stein's unbiased estimate of the sum of the squared errors that a smoother leaves, each
        relative to the level of the noise there."""
        total = -float(self._noise.autocovariance[0]) * len(self._samples)
        for begin, end, half in smoother.runs:
            curve, correlation = self._under(half)
            left = (curve[begin:end] - self._samples[begin:end]) / self._levels[begin:end]
            total += float(left @ left) + 2.0 * (end - begin) * correlation
        return total

    def longest(self) -> Floats:
        """Return the longest half window at every sample, shape (n,), that contradicts no shorter one.

        Windows that differ by an outlier do not: it is noise, and the shorter follows it the more.
        """
        least = _OUTLIER * math.sqrt(float(self._noise.autocovariance[0])) * self._levels
        smooth = without_outliers(self._samples, least)
        is_even = np.array_equal(smooth, self._samples)
        even = self if is_even else _Smoothed(smooth, self._noise, self._levels)
        count = len(self._samples)
        most = _in_steps(np.minimum(_GROWTH[-1] * np.arange(count), count / _PART))
        ladder = np.unique(most)[:: -(_STEPS // 2)][::-1]
        most = np.minimum(most, ladder[-1])
        spectra, power = self._spectra(ladder)
        for at, longer in enumerate(ladder.tolist()):
            curve, _ = even._under(longer)
            for shorter, spectrum in zip(ladder[:at].tolist(), spectra[:at], strict=True):
                between = np.abs(spectra[at] - spectrum) ** 2 * power
                square = float(np.mean(between))
                levels = self._between(shorter, longer)
                relative = np.abs(curve - even._under(shorter)[0]) / (math.sqrt(square) * levels)
                apart = relative > _CONTRADICTS
                if shorter <= _OF_FEW:
                    apart = _in_rows(apart)
                if longer <= _STRETCH * shorter:  # those yet shorter are noisier, and tell less of a stretch
                    alike = float(np.mean(between**2)) / square**2  # rows that tell as much as one
                    apart |= _on_average(relative, most >= longer, _STRETCH * (2 * longer + 1), alike)
                most = np.where(apart & (most >= longer), np.minimum(most, ladder[at - 1]), most)
        # where part of a window reaches over an edge, too little to show, its end has still no place
        away = _CLEARANCE * np.arange(count)
        least = np.minimum.accumulate(most - away) + away
        return np.asarray(np.minimum.accumulate((least + away)[::-1])[::-1] - away)

    def _between(self, shorter: int, longer: int) -> Floats:
        """Return the level of the noise in the difference of two windows, shape (n,), as that of white noise:
        what is loud is in all windows that reach it."""
        if self._are_even:
            return self._levels
        weights = _parabola(longer)
        weights[longer - shorter : longer + shorter + 1] -= _parabola(shorter)
        square = _convolved(np.pad(self._levels**2, longer, mode="reflect"), weights**2)
        least = float(np.min(self._levels))  # and no less by rounding
        return np.asarray(np.maximum(least, np.sqrt(np.maximum(square, 0.0) / float(np.sum(weights**2)))))

    def _spectra(self, ladder: NDArray[np.int64]) -> tuple[list[Floats], Floats]:
        """Return the transfer of each window, and the power of the noise, over the same frequencies."""
        covariance = self._noise.autocovariance
        size = next_fast_length(2 * max(len(covariance), int(ladder[-1]) + 1))
        both = np.zeros(size)
        both[: len(covariance)] = covariance
        both[size - len(covariance) + 1 :] = covariance[:0:-1]
        spectra = []
        for half in ladder.tolist():
            weights = np.zeros(size)
            weights[np.arange(-half, half + 1)] = _parabola(half)
            spectra.append(np.asarray(fft.fft(weights).real))
        return spectra, np.maximum(np.asarray(fft.fft(both).real), 0.0)

    def _under(self, half: int) -> tuple[Floats, float]:
        """Return samples under one window, and the covariance of what it makes of noise with that noise."""
        if half not in self._curves:
            weights = _parabola(half)
            ends = np.pad(self._samples, half, mode="reflect") if half else self._samples
            curve = _convolved(ends, weights)
            lags = min(half + 1, len(self._noise.autocovariance))
            products = weights[half : half + lags] * self._noise.autocovariance[:lags]
            self._curves[half] = curve, float(2.0 * np.sum(products) - products[0])
        return self._curves[half]


def _in_rows(found: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return where three samples in a row are found: one or two of louder noise are no edge."""
    three = found[:-2] & found[1:-1] & found[2:]
    kept = np.zeros(len(found), dtype=np.bool_)
    for offset in range(3):
        kept[offset : len(found) - 2 + offset] |= three
    return kept


def _on_average(relative: Floats, valid: NDArray[np.bool_], stretch: int, alike: float) -> NDArray[np.bool_]:
    """Return where the mean square of differences, shape (n,), relative to their standard deviation, is more
    over a stretch of valid rows than it is by chance, where so many alike count as one: a mode of the signal
    that no row shows for certain, as chi squared (by Wilson and Hilferty, A&S 26.4.17)."""
    half = min(stretch, len(relative)) // 2
    both = np.stack([np.where(valid, np.minimum(relative, _CLIPPED) ** 2, 0.0), valid])
    sums = np.cumsum(np.pad(both, ((0, 0), (half + 1, half))), axis=1)
    total, count = sums[:, 2 * half + 1 :] - sums[:, : -2 * half - 1]
    dof = np.clip(count / alike, 1.0, _MOST_DOF)
    least = (1.0 - 2.0 / (9.0 * dof) + _ON_AVERAGE * np.sqrt(2.0 / (9.0 * dof))) ** 3
    return np.asarray(valid & (total > least * count))


def _convolved(samples: Floats, weights: Floats) -> Floats:
    """Return what lies fully within the samples of their convolution along the last axis."""
    if samples.ndim == 1 and len(samples) * len(weights) < _PRODUCTS:
        return np.convolve(samples, weights, "valid")
    from scipy import signal  # draws in scipy.stats, which takes longer than all else here

    return np.asarray(signal.oaconvolve(samples, weights, mode="valid", axes=-1), np.float64)


def fitted_smoothers(
    samples: Floats, noise: Noise, levels: Floats | float = 1.0
) -> tuple[Smoother, Smoother]:
    """Return smoothers for the samples since an event, shape (n,): the shortened one and that of least risk.

    The noise of each sample is that at rest times its level. The risk of noise that is a line, at whatever
    frequency, is that of white noise of its rms: what it leaves at one is no estimate of what it would on the
    way.

    The difference of the two is as large as the bias that may remain in the first.
    """
    count = len(samples)
    none = Smoother(np.zeros(count, dtype=np.int64))
    if noise.rms == 0.0:
        return none, none
    smoothed = _Smoothed(samples, noise, levels * np.ones(count))
    most = smoothed.longest()
    if noise.as_line:
        smoothed = _Smoothed(samples, Noise(np.array([noise.as_line**2])), levels * np.ones(count))
    best, least = none, smoothed.risk(none)
    longest = max(1.0, count / _PART)
    for growth in _GROWTH:
        for step in range(int(2.0 * math.log2(longest)) + 1):
            length = longest / 2.0 ** (0.5 * step)
            smoother = Smoother.growing(most, growth, length)
            if (risk := smoothed.risk(smoother)) < least:
                best, least = smoother, risk
    return best.shortened(), best


def _in_steps(half: Floats) -> NDArray[np.int64]:
    """Return half windows, shape (n,), of few different lengths: the next shorter or equal."""
    stepped = np.exp2(np.floor(_STEPS * np.log2(np.maximum(half, 1.0)) + _SLIGHTLY) / _STEPS)
    return np.where(half < 1.0, 0, np.floor(stepped)).astype(np.int64)


def _parabola(half: int) -> Floats:
    """Return the weights by which 2 `half` + 1 samples give the middle of their least-squares parabola."""
    places = np.arange(-half, half + 1, dtype=np.float64)
    if half == 0:
        return np.ones(1)
    weights = 3.0 * (3.0 * half * (half + 1.0) - 1.0) - 15.0 * places**2
    return weights / ((2.0 * half - 1.0) * (2.0 * half + 1.0) * (2.0 * half + 3.0))


def is_noisier(covariance: Floats, count: int, other: Floats, other_count: int) -> bool:
    """Return whether a piece of so many samples has more noise than another by more than chance: the variance
    of each scatters as a mean of squares of correlated samples does."""
    scatter = math.hypot(Noise(covariance).of_mean_square(count), Noise(other).of_mean_square(other_count))
    return float(covariance[0] - other[0]) > _BY_CHANCE * scatter


def _together(found: list[tuple[Floats, Floats]]) -> Floats:
    """Return the autocovariance of pieces of one noise, each by its own: their mean, each of as much weight
    as it has samples."""
    total = np.zeros(max(len(covariance) for covariance, _ in found))
    for covariance, piece in found:
        total[: len(covariance)] += len(piece) * covariance
    return np.asarray(total / sum(len(piece) for _, piece in found))


def _innovations(covariance: Floats, piece: Floats) -> Floats | None:
    """Return the independent values, of unit variance, that noise of this autocovariance was made of, by its
    whitened spectrum; None where they may be normal ones (sieve bootstrap: Bühlmann, Bernoulli 3 (1997) 123).

    Of noise with a long memory, as that of a line, the ends of a piece are far off, as what is beyond them is
    missing: they are heavy only if they are more so than those of normal noise.
    """
    count = len(piece)
    if not covariance[0] > 0.0 or count < _FEWEST_INNOVATIONS:
        return None
    values = _whitened(without_a_line(piece)[np.newaxis], covariance)[0]
    if not np.any(values):  # a piece of one reading, beside another of that noise
        return None
    excess, of_normal = float(np.mean(values**4)) - 3.0, math.sqrt(24.0 / count)
    if not excess > _HEAVY_TAILED * of_normal:
        return None
    drawn = Noise(covariance).draw(np.random.default_rng(_SEED), (_RECORDS, count))
    others = np.mean(_whitened(drawn, covariance) ** 4, axis=1) - 3.0
    usual, spread = float(np.mean(others)), max(of_normal, float(np.std(others, ddof=1)))
    return values if excess > usual + _HEAVY_TAILED * spread else None


def _whitened(pieces: Floats, covariance: Floats) -> Floats:
    """Return pieces of noise of this autocovariance, shape (pieces, n), with a white spectrum, mean zero and
    unit variance each, where they have any."""
    count = pieces.shape[1]
    size = next_fast_length(count + len(covariance))
    white = fft.rfft(pieces, size, axis=1) / np.sqrt(_density(covariance, size))
    values = np.asarray(fft.irfft(white, size, axis=1)[:, :count], dtype=np.float64)
    values -= np.mean(values, axis=1, keepdims=True)
    scatter = np.std(values, axis=1, keepdims=True)
    return values / np.where(scatter > 0.0, scatter, 1.0)


def _density(covariance: Floats, size: int) -> Floats:
    """Return the power of noise over the frequencies of so many samples, nowhere as little as zero."""
    circular = np.zeros(size)
    circular[: len(covariance)] = covariance
    circular[size - len(covariance) + 1 :] = covariance[:0:-1]
    density = np.asarray(fft.rfft(circular).real)
    return np.maximum(density, _LEAST_DENSITY * float(np.max(density)))


def _offset(covariance: Floats, piece: Floats, pieces: Sequence[Floats] = ()) -> float:
    """Return the standard deviation of the mean of a piece that its autocovariance does not hold: that of
    noise whose density rises below the lowest frequency of the piece, as all `pieces` of that noise tell."""
    beside = [each for each in pieces if each is not piece]
    slow = slow_noise(piece, beside=beside) if covariance[0] > 0.0 else None
    if slow is None:
        return 0.0
    standard = min(slow.standard, _MOST_OF_RMS * math.sqrt(float(covariance[0])))
    lags, count = np.arange(1, len(covariance)), len(piece)
    held = (covariance[0] + 2.0 * float(np.sum((1.0 - lags / count) * covariance[1:]))) / count
    beyond = standard**2 - held
    return math.sqrt(beyond) if beyond > _CLEARLY_SLOWER * held else 0.0


def without_a_line(piece: Floats) -> Floats:
    """Return samples, shape (n,), about their least-squares line."""
    places = np.linspace(-1.0, 1.0, len(piece))
    level = float(np.mean(piece))
    slope = float(np.sum(places * (piece - level)) / np.sum(places**2))
    return np.asarray(piece - level - slope * places)


def _autocovariance(piece: Floats) -> Floats:
    left = without_a_line(piece)
    if float(np.std(left)) <= _ROUNDING * float(np.max(np.abs(piece))):
        return np.zeros(1)
    lags = max(1, len(piece) // _LAGS)
    size = next_fast_length(2 * len(piece))
    power = np.abs(fft.rfft(left, size)) ** 2
    found = fft.irfft(power, size)[:lags] / max(1, len(piece) - 2)
    taper = 1.0 - np.arange(lags) / lags
    # the spectrum at zero, which the offset enters with the sum of the tapers
    slowest = max(0.0, 2.0 * float(np.sum(found * taper)) - float(found[0]))
    slowest /= 1.0 - 2.0 * (2.0 * float(np.sum(taper)) - 1.0) / len(piece)
    return np.asarray((found + 2.0 * slowest / len(piece)) * taper, dtype=np.float64)
