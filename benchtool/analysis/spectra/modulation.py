"""What modulates the lines of a spectrum alike: sidebands that they share, and an amplitude that wanders."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples, CoherentSpectrum
from benchtool.analysis.noise.noise_of_lines import PAIRS, noise_around, noise_of_pairs
from benchtool.analysis.phase.wander import wander
from benchtool.analysis.quantisation.swept_steps import relative_error
from benchtool.analysis.spectra.amplitude_trend import AmplitudeTrend, amplitude_trend
from benchtool.analysis.statistics.neighbours import neighbours_alike
from benchtool.analysis.statistics.scatter import (
    MeanError,
    error_of_periods,
    error_of_series,
    is_memory_untold,
)

Floats = NDArray[np.float64]

CORRELATED = 1.5
"""Periods that count as one, from which neighbours are taken for correlated."""

_ALIKE = 0.6  # correlation of the sidebands of two lines: of eight pairs of noise, by chance once in twenty
_FEWEST_PAIRS, _WOULD_SHOW = 4, 0.5
_FEWEST_OF_JITTER, _CLEARLY_STEEPER = 8, 6.0  # periods, and samples of each; standard deviations of a slope
_IN_ORDER = 0.3  # rows, standard deviation: of samples that are anywhere in their row, and so in their order
_STANDS_OUT, _WANDERS = 4.0, 2  # standard deviations of the bins of a mean; bins of a phase that wanders
_ROUNDS = 3
_FOLLOWS, _FEWEST_THAT_FOLLOW = 4.0, 4  # standard deviations of a correlation; periods
_ROUNDING = 1e-12  # of the amplitude
_OF_STEPS = 2.0  # times the rms of what steps make of an amplitude
_LEAST = 0.3  # of an amplitude, relative to its mean: dividing by less makes much of noise


def noise_of_sum(spectrum: CoherentSpectrum, weights: Floats) -> MeanError:
    """Return the noise of a weighted sum of the amplitudes of harmonics 1, 2 ..., weights of shape (orders,),
    by the pairs of bins of `line_noise` around all of them at once; nan where no pair is around each.

    What modulates all harmonics alike is in the same pair around each, and adds or cancels as in the sum.
    """
    sidebands = _sidebands(spectrum, len(weights))
    told = weights[: len(sidebands)]
    if not sidebands.size or not np.any(told):
        return MeanError(math.nan, 1.0)
    # of harmonics at the edge of the band, beside which no bins are, the noise is as that of the others
    of_all = float(np.linalg.norm(weights) / np.linalg.norm(told))
    together = of_all * np.sum(told[:, np.newaxis] * sidebands, axis=0)[np.newaxis, :]
    around = noise_around(spectrum, spectrum.periods * np.arange(1, len(weights) + 1)).of_sum(weights)
    found = noise_of_pairs(together, np.ones_like(together, dtype=np.bool_), around)
    return MeanError(float(found.standard[0]), float(found.dof[0]))


def is_modulated_alike(spectrum: CoherentSpectrum, weights: Floats) -> NDArray[np.bool_]:
    """Return whether weighted sums of harmonics 1, 2 ..., weights of shape (sums, orders), have the sidebands
    of the fundamental, as where one cause moves the amplitude of both; shape (sums,)."""
    sidebands = _sidebands(spectrum, weights.shape[1])
    told, pairs = sidebands.shape
    if pairs < _FEWEST_PAIRS or not told:
        return np.zeros(len(weights), dtype=np.bool_)
    of_sums, of_first = weights[:, :told] @ sidebands, sidebands[0]
    product = np.real(of_sums @ np.conj(of_first))
    size = np.sqrt(np.sum(np.abs(of_sums) ** 2, axis=1) * np.sum(np.abs(of_first) ** 2))
    return np.asarray(product > _ALIKE * size)


def amplitude_changes(amplitude: Floats, trend: AmplitudeTrend | None, step: float) -> bool:
    """Return whether amplitudes of periods, shape (periods,), follow a `trend` or each other, and differ by
    more than rounding and the `step` of a converter make them, which turns against the periods, too."""
    mean = float(np.mean(amplitude))
    of_steps = _OF_STEPS * float(relative_error(mean / step)) if step > 0.0 else 0.0
    if float(np.std(amplitude)) <= max(of_steps, _ROUNDING) * mean:
        return False
    is_told = len(amplitude) > _FEWEST_THAT_FOLLOW
    return trend is not None or (is_told and neighbours_alike(amplitude) > _FOLLOWS)


def harmonics_tell(spectrum: CoherentSpectrum, orders: int) -> bool:
    """Return whether harmonics 2 to `orders`, each by its amplitude, have the sidebands of the fundamental,
    or would show them if they had: else nothing tells a modulation from a line beside the fundamental."""
    sidebands = _sidebands(spectrum, orders)
    if not sidebands.size:
        return False
    amplitude = spectrum.amplitude[spectrum.periods :: spectrum.periods][: len(sidebands)]
    found, of_first = amplitude[1:] @ sidebands[1:], sidebands[0]
    expected = float(np.sum(amplitude[1:] ** 2)) / float(amplitude[0]) * of_first
    size, most = float(np.linalg.norm(found)), float(np.linalg.norm(expected))
    alike = float(np.real(found @ np.conj(of_first))) > _ALIKE * size * float(np.linalg.norm(of_first))
    return alike or size < _WOULD_SHOW * most


def _sidebands(spectrum: CoherentSpectrum, orders: int) -> NDArray[np.complex128]:
    """Return what pairs of bins around harmonics 1, 2 ... do to their amplitudes, shape (at most orders,
    pairs): of those that have all pairs within the band."""
    periods, bins = spectrum.periods, spectrum.phasor
    offsets = np.arange(1, min(PAIRS, periods - 1) + 1)
    told = max(0, min(orders, (len(bins) - 1 - len(offsets)) // periods))
    lines = periods * np.arange(1, told + 1)
    towards = np.exp(-1j * np.angle(bins[lines]))[:, np.newaxis]
    above = bins[lines[:, np.newaxis] + offsets] * towards
    below = np.conj(bins[lines[:, np.newaxis] - offsets] * towards)
    return np.asarray(above + below)


def phase_noise_rad(coherent: CoherentSamples, *, is_followed: bool = False) -> float:
    """Return the standard deviation of the phase from sample to sample, by how much more a signal scatters
    over the periods where it is steep; 0 where chance may do so.

    Samples whose times jitter by x, as a phase, have the variance x^2 (dw/dphase)^2 beside that of the noise.
    It is in all bins alike, and takes x^2 k^2 / 2 off harmonic k. So it is no more than is beside the
    fundamental, and leaves samples in their order: what scatters so else moves no phase, as the current that
    makes no torque. Where the phase of each period `is_followed`, what is slow of jitter has gone with that.
    """
    table = coherent.values.reshape(coherent.periods, -1)
    places = table.shape[1]
    if len(table) < _FEWEST_OF_JITTER or places < _FEWEST_OF_JITTER:
        return 0.0
    scatter2 = np.var(table, axis=0, ddof=1)
    bins = fft.rfft(np.mean(table, axis=0))
    bins[-1] = 0.0
    # noise of the mean is steep as well
    bins[np.abs(bins) ** 2 < _STANDS_OUT**2 * places * float(np.mean(scatter2)) / len(table)] = 0.0
    steep2 = fft.irfft(1j * np.arange(len(bins)) * bins, places) ** 2
    about = steep2 - np.mean(steep2)
    size = float(about @ about)
    if not size > 0.0:
        return 0.0
    slope = float(about @ scatter2) / size
    left = scatter2 - np.mean(scatter2) - slope * about
    chance = math.sqrt(float(left @ left) / (places - 2.0) / size)
    if not slope > _CLEARLY_STEEPER * chance:
        return 0.0
    beside = math.inf if is_followed else _beside_fundamental2(coherent) / float(np.mean(steep2))
    row_rad = 2.0 * math.pi * coherent.periods / coherent.samples
    return min(math.sqrt(min(slope, beside)), _IN_ORDER * row_rad)


def _beside_fundamental2(coherent: CoherentSamples) -> float:
    """Return the variance that a signal has of noise at most, if it is in all bins as beside the
    fundamental."""
    periods, count = coherent.periods, len(coherent.values)
    bins = np.arange(periods // 2, min(periods + (periods + 1) // 2, (count + 1) // 2))
    bins = bins[(np.abs(bins - periods) > _WANDERS) & (bins > 0)]
    powers = np.abs(fft.rfft(coherent.values)[bins]) ** 2 / count
    return float(np.mean(powers)) * (1.0 + 2.0 / math.sqrt(len(bins)))


def wander_of_mean(amplitude: Floats, by_pairs: float, phase_rad: Floats | None = None) -> float:
    """Return the standard deviation of the mean of amplitudes, shape (periods,), one of each period, beyond
    that by the pairs of bins beside the line; 0 where neighbouring periods are not correlated.

    A memory of some periods is in few pairs of bins, and one of the whole record in none of them: then the
    series itself says more, or its density at the lowest frequencies, continued. In a short record it is
    not known (nan) where the amplitude wanders more than `phase_rad`, the phase of the same periods, does.
    """
    if phase_rad is not None and is_memory_untold(amplitude, float(np.mean(amplitude)) * phase_rad):
        return math.nan
    if len(amplitude) <= CORRELATED * (error_of_series(amplitude).dof + 1.0):
        return 0.0
    return math.sqrt(max(0.0, error_of_periods(amplitude, least=0).standard ** 2 - by_pairs**2))


@dataclass(frozen=True)
class SteadyAmplitude:
    """Samples whose amplitude is steady, with that over the time of the record, of which it had the `trend`,
    None if it had none."""

    samples: CoherentSamples
    trend: AmplitudeTrend | None = None


@dataclass(frozen=True)
class PeriodsInTime:
    """Where the periods of a record begin and end in time, from 0 to 1, `edges` of shape (periods + 1,);
    `before` and `after` are the shares of the record, relative to them, that are outside."""

    edges: Floats
    before: float
    after: float

    @classmethod
    def of(cls, coherent: CoherentSamples, turns: Floats, first_row: int) -> PeriodsInTime:
        """Return those of samples along `turns`, shape (rows,), which are periods from `first_row` on."""
        rows = np.arange(len(turns), dtype=np.float64)
        edges = (np.interp(np.arange(coherent.periods + 1), turns, rows) - first_row) / coherent.samples
        before, after = first_row / coherent.samples, (len(turns) - first_row) / coherent.samples - 1.0
        return cls(edges, before, after)

    def trend(self, amplitudes: Floats) -> AmplitudeTrend | None:
        """Return the trend of the amplitudes of the periods, shape (periods,), over the record."""
        return amplitude_trend(amplitudes, self.before, self.after, self.edges)


def with_steady_amplitude(
    coherent: CoherentSamples, amplitude: Floats, turns: Floats, first_row: int
) -> SteadyAmplitude:
    """Return samples with the amplitudes of their periods, shape (periods,), without the trend of these, and
    with the mean over time in place of that over periods; `turns`, shape (rows,), are periods from
    `first_row` on.

    A course of the amplitude has sidebands beside all harmonics, whose tails are in the other ones. And where
    speed and amplitude swing together, the periods with the greater amplitude may be the longer ones.
    """
    in_time = PeriodsInTime.of(coherent, turns, first_row)
    edges, trend = in_time.edges, in_time.trend(amplitude)
    if trend is None:
        factor = 1.0 + apart_in_time(amplitude, edges)
        return SteadyAmplitude(replace(coherent, values=factor * coherent.values))
    passed = np.interp(np.arange(len(coherent.values)) / coherent.per_period, np.arange(len(edges)), edges)
    found = SteadyAmplitude(coherent)
    for _ in range(_ROUNDS):
        course = 1.0 + trend.curve(passed)
        if not float(np.min(course)) > _LEAST:
            break
        found = SteadyAmplitude(
            replace(coherent, values=(1.0 + trend.level) / course * coherent.values), trend
        )
        # of a swing the amplitudes of periods are means, and a phasor is moved by a bend within its period
        left = wander(found.samples).amplitude
        closer = in_time.trend((1.0 + trend.over_periods) * left)
        if closer is None:
            break
        trend = closer
    return found


def apart_in_time(amplitude: Floats, edges: Floats) -> float:
    """Return by how much, relative to it, the mean over time of amplitudes, shape (periods,), is more than
    that over periods; `edges`, shape (periods + 1,), are where these begin and end in time.

    Where speed and amplitude swing together, the periods with the greater amplitude may be the longer ones.
    """
    mean = float(np.mean(amplitude))
    return float(np.average(amplitude, weights=np.diff(edges))) / mean - 1.0 if mean > 0.0 else 0.0
