"""Noise of single lines of a spectrum, by the pairs of bins at equal distances around each."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum
from benchtool.analysis.distributions import fisher_above, median_of_exponentials, students_deviation
from benchtool.analysis.noise.noise import bins_around, harmonic_noise
from benchtool.analysis.noise.noise_by_slope import noise_by_slope
from benchtool.analysis.statistics.medians import medians
from benchtool.analysis.statistics.scatter import MeanError
from benchtool.analysis.uncertainty import Contribution

PAIRS = 8
"""Pairs of bins around a line that its noise is read off."""
_NEAREST = 3
_OF_NEAREST, _RISES, _RISES_MOST = 1.3, 2.0, 4.0
_OF_ONE_PAIR = 3.0  # a distribution of two degrees of freedom has no deviation: 2 u then hold 97 %
_CLEARLY = 6.0  # a ratio of variances, of 16 degrees of freedom each: by chance once in two thousand
_MATTERS = 1e-3  # of an amplitude that moves
_FIRST, _RISEN, _MORE = 2.0, 1.9, 2.0  # times the noise around: by chance one in seven, in ten, in twenty
_LESS = 0.25  # likewise, one in a hundred
_DOF_OF_MEDIAN = 10.0  # of the median of eight squares; of that of many it is their number
_FEWEST_AROUND = 9  # periods, of which two orders to both sides hold twenty bins
_RARELY, _VERY_RARELY = 0.1, 1e-4  # by chance, of a ratio of variances


@dataclass(frozen=True)
class LineNoise:
    """Effect of noise and leakage on lines of a spectrum, all of shape (lines,).

    `in_phase` is the standard uncertainty of a line's amplitude, `quadrature` that of amplitude times phase,
    each of `dof` degrees of freedom; nan where too few bins are near. `lost` is what a line's own wander of
    phase has moved into the bins beside it, 0 where that may be noise. `wanders` tells where the amplitude
    moves by a thousandth and by more than noise moves it.
    """

    in_phase: NDArray[np.float64]
    quadrature: NDArray[np.float64]
    dof: NDArray[np.float64]
    lost: NDArray[np.float64]
    wanders: NDArray[np.bool_]

    @property
    def experimental(self) -> NDArray[np.float64]:
        """`in_phase` without what is added because it is of few degrees of freedom."""
        return np.asarray(self.in_phase / [_of_few(round(0.5 * each)) for each in self.dof])


@dataclass(frozen=True)
class NoiseAround:
    """Power of one component of the noise around lines, nan where it is not known, by `dof` degrees of
    freedom, both of shape (lines,)."""

    power: NDArray[np.float64]
    dof: NDArray[np.float64]

    def of(self, lines: NDArray[np.bool_]) -> NoiseAround:
        """Return that of some of the lines."""
        return NoiseAround(self.power[lines], self.dof[lines])

    def of_sum(self, weights: NDArray[np.float64]) -> NoiseAround:
        """Return that of a weighted sum of the lines, weights of shape (lines,)."""
        counted = np.where(weights != 0.0, weights**2 * self.power, 0.0)
        total = float(np.sum(counted))
        # neighbours share their bins, and tell no more together
        dof = float(counted @ self.dof) / total if total > 0.0 else 0.0
        return NoiseAround(np.array([total]), np.array([dof]))

    def with_pairs(self, power: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the noise power at lines and its degrees of freedom, shape (lines,), by eight pairs beside
        each, shape (lines, pairs): pooled with this where it differs by no more than chance from all of them,
        from those next to the line, and from the first."""
        first, nearest, middle = power[:, 0], np.mean(power[:, :_NEAREST], axis=1), _by_median(power)
        alike = (
            (first < _FIRST * self.power)
            & (nearest < _RISEN * self.power)
            & (middle < _MORE * self.power)
            & (middle > _LESS * self.power)
        )
        dof = _DOF_OF_MEDIAN + self.dof
        both = (_DOF_OF_MEDIAN * middle + self.dof * self.power) / dof
        return np.where(alike, both, noise_at_lines(power)), np.where(alike, dof, 2.0 * PAIRS)

    def with_few_pairs(self, power: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the same by fewer pairs than eight, shape (lines, pairs): pooled with this where neither the
        first nor all of them have more than chance would give them, and all not far less."""
        own = 2.0 * power.shape[1]
        found, dof = noise_at_lines(power), np.full(len(power), own)
        for line, (around, of_around) in enumerate(zip(self.power, self.dof, strict=True)):
            if not around > 0.0:
                continue
            mean = float(np.mean(power[line]))
            by_chance = fisher_above(own, of_around, mean / around)
            first = fisher_above(2.0, of_around, float(power[line, 0]) / around)
            if min(by_chance, first) > _RARELY and by_chance < 1.0 - _VERY_RARELY:
                dof[line] = own + of_around
                both = (own * mean + of_around * around) / dof[line]
                found[line] = both * _of_few(round(0.5 * dof[line])) ** 2
        return found, dof


@dataclass(frozen=True)
class NoiseOfPairs:
    """Standard uncertainty of one component, and its degrees of freedom, both of shape (lines,)."""

    standard: NDArray[np.float64]
    dof: NDArray[np.float64]


def contribution_of_noise(name: str, standard: float, dof: float) -> Contribution:
    """Return the line of a budget for noise by pairs of bins: that of few pairs has Student's deviation."""
    return Contribution(name, "A", float(standard), float(dof), of_student=bool(dof < 2.0 * PAIRS))


def line_noise(spectrum: CoherentSpectrum, lines: NDArray[np.int64]) -> LineNoise:
    """Return the noise of lines, in bins of shape (lines,), from the pairs of bins at equal distances around
    each.

    The lower bin of a pair, conjugated, and the upper one, both turned to the line's phase, add up to what
    changes the amplitude of the line and subtract to what changes its phase, as sidebands do. So noise that
    is coloured, or shares its phase with the line, and leakage from interharmonics are seen as they act on
    the line. Of the pairs without a harmonic the nearest three count by their mean square, with what few of
    them add and where the noise rises towards the line (`noise_at_lines`), the nearest eight by their median,
    which lines do not disturb, and the larger of both is taken. Where that differs by no more than chance
    from the noise between the harmonics to both sides, which many bins tell, both are estimates of the same.
    """
    periods, bins = spectrum.periods, spectrum.phasor
    offsets = np.arange(1, 2 * PAIRS + 1)
    upper, lower = lines[:, np.newaxis] + offsets, lines[:, np.newaxis] - offsets
    inside = (upper < len(bins)) & (lower > 0) & (upper % periods != 0) & (lower % periods != 0)
    inside &= np.cumsum(inside, axis=1) <= PAIRS
    towards = np.exp(-1j * np.angle(bins[lines]))[:, np.newaxis]
    above = bins[np.where(inside, upper, 0)] * towards
    below = np.conj(bins[np.where(inside, lower, 0)] * towards)
    together, apart = above + below, above - below
    of_amplitude, of_phase = (
        np.sum(np.where(inside, np.abs(each) ** 2, 0.0), axis=1) for each in (together, apart)
    )
    around = noise_around(spectrum, lines)
    in_phase, quadrature = (noise_of_pairs(each, inside, around) for each in (together, apart))
    return LineNoise(
        in_phase.standard,
        quadrature.standard,
        np.minimum(in_phase.dof, quadrature.dof),
        _lost(of_amplitude, of_phase, spectrum.amplitude[lines]),
        of_amplitude > np.maximum(_CLEARLY * of_phase, (_MATTERS * spectrum.amplitude[lines]) ** 2),
    )


def noise_around(spectrum: CoherentSpectrum, lines: NDArray[np.int64]) -> NoiseAround:
    """Return the noise by the bins between harmonics to both sides of lines, shape (lines,); nan where these
    are few, or a line is no harmonic."""
    periods = spectrum.periods
    found, dof = np.full(len(lines), np.nan), np.zeros(len(lines))
    are_harmonics = (lines % periods == 0) & (lines > 0)
    if not np.any(are_harmonics):
        return NoiseAround(found, dof)
    order = lines[are_harmonics] // periods
    if periods >= _FEWEST_AROUND:
        found[are_harmonics] = harmonic_noise(spectrum, int(np.max(order)))[order - 1] ** 2
        dof[are_harmonics] = bins_around(spectrum)
    else:
        power, of_power = noise_by_slope(spectrum, int(np.max(order)))
        found[are_harmonics], dof[are_harmonics] = power[order - 1], of_power[order - 1]
    return NoiseAround(found, dof)


def hann_quadrature(spectrum: CoherentSpectrum) -> MeanError:
    """Return the noise of the amplitude times phase of the fundamental under a Hann window, from the pairs of
    bins around it; nan where there are fewer than three.

    What leaks from a decaying dc or a line far away is in the bins of the rectangular window, and hardly in
    these, as it is hardly in a fit with such a window. A bin is X_b - (X_(b-1) + X_(b+1)) / 2, of 3/2 of the
    power of the noise, and neighbours are correlated by 2/3: about two of them count as one.
    """
    periods, bins = spectrum.periods, spectrum.phasor
    window = bins.copy()
    window[1:-1] -= 0.5 * (bins[2:] + bins[:-2])
    offsets = np.arange(2, min(2 * PAIRS, periods - 1))
    offsets = offsets[periods + offsets < len(bins) - 1][:PAIRS]
    if len(offsets) < _NEAREST:
        return MeanError(math.nan, 1.0)
    towards = np.exp(-1j * np.angle(bins[periods]))
    apart = window[periods + offsets] * towards - np.conj(window[periods - offsets] * towards)
    found = noise_of_pairs(apart[np.newaxis, :] / math.sqrt(1.5), np.ones((1, len(offsets)), dtype=np.bool_))
    return MeanError(float(found.standard[0]), float(len(offsets)))


def _lost(
    of_amplitude: NDArray[np.float64], of_phase: NDArray[np.float64], amplitude: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return half of the phase's variance times the amplitude: sidebands in quadrature, less those of noise,
    by the power of those that move the amplitude and of those that move the phase."""
    excess = np.where(of_phase > _CLEARLY * of_amplitude, of_phase - of_amplitude, 0.0)
    variance = np.divide(excess, 2.0 * amplitude**2, out=np.zeros_like(excess), where=amplitude > 0.0)
    return np.asarray(amplitude * np.minimum(1.0, 0.5 * variance))


def experimental_noise_of_pairs(
    sums: NDArray[np.complex128], inside: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Return the experimental standard deviation of one component, as `noise_of_pairs` but without what is
    added because it is of few degrees of freedom, two of each pair."""
    of_few = np.array([_of_few(int(each)) for each in np.count_nonzero(inside, axis=1)])
    return np.asarray(noise_of_pairs(sums, inside).standard / of_few)


def _of_few(pairs: int) -> float:
    """Return by what the standard uncertainty of noise exceeds its experimental deviation."""
    if pairs == 1:
        return _OF_ONE_PAIR
    return students_deviation(2.0 * pairs) if 1 < pairs < PAIRS else 1.0


def noise_of_pairs(
    sums: NDArray[np.complex128],
    inside: NDArray[np.bool_],
    around: NoiseAround | None = None,
) -> NoiseOfPairs:
    """Return the noise of one component, from sums of pairs, shape (lines, pairs), and the noise `around`
    them, where it is known."""
    square, counts = 0.25 * (sums.real**2 + sums.imag**2), np.count_nonzero(inside, axis=1)
    found, dof = np.full(len(square), np.nan), 2.0 * np.maximum(counts, 1.0)
    for count in np.unique(counts[counts > 0]):
        rows = counts == count
        own = square[rows][inside[rows]].reshape(-1, count)
        if around is None:
            found[rows] = noise_at_lines(own)
        elif count < PAIRS:
            found[rows], dof[rows] = around.of(rows).with_few_pairs(own)
        else:
            found[rows], dof[rows] = around.of(rows).with_pairs(own)
    return NoiseOfPairs(np.sqrt(found), dof)


def noise_at_lines(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the noise power at lines, shape (lines,), by that of pairs around each, the nearest first, shape
    (lines, pairs).

    Where the nearest have more than the median of all, and more than twice that of those beyond, the noise
    rises towards the line, and goes on to rise by as much again. The nearest are few: their mean counts as
    Student's distribution would have it, less what is gained where the median is the larger.
    """
    pairs = power.shape[1]
    middle, nearest = _by_median(power), np.mean(power[:, :_NEAREST], axis=1)
    if pairs < PAIRS:
        larger = nearest if pairs == 1 else np.maximum(nearest, middle)
        return np.asarray(larger * _of_few(pairs) ** 2)
    beyond = _by_median(power[:, _NEAREST:])
    rise = np.divide(nearest, beyond, out=np.ones_like(nearest), where=beyond > 0.0)
    risen = nearest * _OF_NEAREST * np.clip(rise / _RISES, 1.0, _RISES_MOST)
    return np.where(nearest <= middle, middle, risen)


def _by_median(power: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the mean of exponentially distributed powers, shape (lines, pairs), by their median."""
    return np.asarray(medians(power) / median_of_exponentials(power.shape[1]))
