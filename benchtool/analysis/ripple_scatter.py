"""By how much the numbers of a ripple differ from period to period, and so from record to record."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.repeated_steps import RepeatedSteps, noise_beside, repeated_steps
from benchtool.analysis.scatter import (
    MeanError,
    at_lowest_frequencies,
    error_of_root,
    error_of_series,
    neighbours_alike,
    scatter_of_largest,
    tail_index,
)
from benchtool.analysis.slow_lines import slow_lines
from benchtool.analysis.spectra.amplitude_trend import amplitude_trend

Floats = NDArray[np.float64]

FEWEST_PERIODS = 3
"""Fewest periods whose scatter is used."""

LOW_PERCENT, HIGH_PERCENT = 0.5, 99.5
"""Percentiles between which single spikes do not count."""

_CORRELATED = 2.0  # periods that count as one, from which a tail is made of stretches of them
_PARTS, _WHOLE_OVER_PARTS = 8, 1.5  # the whole reaches further into the tail than a part, and scatters more
_SAMPLES_OF_TAIL = 1 << 17
_ALIKE = 3.0  # standard deviations of a correlation
_NEAR = 0.25  # per cent to either side, for the density there


@dataclass(frozen=True)
class Periods:
    """What repeats in a record: the rows at which it begins, shape (periods + 1,), the first 0, the last the
    row after the last; `name` says what it is. `per_revolution` of them make one of the rotor, 1 where that
    is not known."""

    rows: NDArray[np.int64]
    name: str = "electrical periods"
    per_revolution: int = 1

    def __len__(self) -> int:
        return len(self.rows) - 1

    def places(self, rows: Floats) -> Floats:
        """Return how far through all of them rows, shape (n,), are, from 0 to 1."""
        return np.asarray(np.interp(rows, self.rows, np.arange(len(self.rows)) / len(self)))


@dataclass(frozen=True)
class Scatter:
    """Uncertainties of mean, rms and percentile range, and the standard deviation of a peak-to-peak.

    `incomplete_mean` and `incomplete_rms` are what the part of a period at the record's end moves, `steps`
    the errors of a converter's steps that repeat.
    """

    periods: int
    repeated: str
    mean: MeanError
    rms: MeanError
    percentile_range: MeanError
    peak_to_peak: float
    mean_peak_to_peak: float
    incomplete_mean: float
    incomplete_rms: float
    steps: RepeatedSteps | None


def percentile_range(samples: NDArray[np.float64]) -> float:
    """Return 99.5th minus the 0.5th percentile of samples, shape (n,), which single spikes do not affect."""
    low, high = np.percentile(samples, (LOW_PERCENT, HIGH_PERCENT))
    return float(high - low)


def scatter_of_periods(
    samples: Floats, mean: float, rms: float, repeats: Periods, step: float = 0.0, *, percentiles: bool = True
) -> Scatter | None:
    """Return the scatter of the numbers of whole periods of samples, shape (n,), which have this mean and
    rms; None where there are too few."""
    rows, count = repeats.rows, len(repeats)
    if count < FEWEST_PERIODS or np.min(np.diff(rows)) < 1:
        return None
    within, begin, counts = samples[: rows[-1]], rows[:-1], np.diff(rows)
    of_mean = _slowly(within, repeats)
    square = np.square(within - mean)
    of_square = _slowly(square, repeats)
    squares = np.add.reduceat(square, begin) / counts
    spans = np.maximum.reduceat(within, begin) - np.minimum.reduceat(within, begin)
    # edges that repeat leave no deviations, and a slope that falls beside its place no second differences
    tail = min(tail_index(_deviations(within, begin, counts)), tail_index(np.diff(within, 2)))
    return Scatter(
        periods=count,
        repeated=repeats.name,
        mean=of_mean.error,
        rms=error_of_root(squares, math.sqrt(max(0.0, of_square.mean)), of_square.error),
        percentile_range=_percentile_scatter(within, repeats)
        if percentiles
        else MeanError(math.nan, math.nan),
        peak_to_peak=_extremes(within, of_mean.rest, begin, tail),
        mean_peak_to_peak=float(np.mean(spans)),
        # the record ends within a period: what that part moves is no scatter, but it is not known either
        incomplete_mean=of_mean.mean - mean,
        incomplete_rms=math.sqrt(max(0.0, of_square.mean)) - rms,
        steps=_repeated_steps(within, rows, step) if percentiles and step > 0.0 else None,
    )


def _extremes(samples: Floats, rest: Floats, begin: NDArray[np.int64], tail: float) -> float:
    """Return the standard deviation of the peak-to-peak over records, by the extremes of each period of
    samples, shape (n,), without their slow lines, `rest`, unless those are not all that is slow: then they
    meet by chance."""
    largest, least = np.maximum.reduceat(rest, begin), np.minimum.reduceat(rest, begin)
    if rest is not samples and max(neighbours_alike(largest), neighbours_alike(least)) > _ALIKE:
        return _extremes(samples, samples, begin, tail)
    # what makes both extremes larger together scatters as their difference does
    return max(
        math.hypot(scatter_of_largest(largest, tail), scatter_of_largest(-least, tail)),
        scatter_of_largest(largest - least, tail),
    )


@dataclass(frozen=True)
class _Slowly:
    """Mean of a series over whole periods and whole cycles of its slow lines, its error by the `rest`, shape
    (n,), which is without them."""

    rest: Floats
    mean: float
    error: MeanError


def _slowly(series: Floats, repeats: Periods) -> _Slowly:
    """Return the mean of a series, shape (n,), the rows of whole periods, and its error by what is neither a
    slow line in it nor a course of few constants, such as a drift."""
    begin, counts, periods = repeats.rows[:-1], np.diff(repeats.rows), len(repeats)
    place = repeats.places(np.arange(0.5, len(series)))
    lines = slow_lines(series, place, periods, repeats.per_revolution)
    rest = series if lines is None else series - lines.at(place)
    means = np.add.reduceat(rest, begin) / counts
    mean = float(np.average(means, weights=counts)) if lines is None else lines.mean
    middle, size = float(np.mean(means)), float(np.max(np.abs(means)))
    trend = amplitude_trend(1.0 + (means - middle) / size, 0) if size > 0.0 else None
    if trend is not None:
        return _Slowly(rest, mean, _times(size, error_of_series(trend.rest), trend.apart))
    return _Slowly(rest, mean, at_lowest_frequencies(rest, error_of_series(means), periods))


def _times(size: float, error: MeanError, deviation: float) -> MeanError:
    return MeanError(size * math.hypot(error.standard, deviation), error.dof)


def _deviations(samples: Floats, begin: NDArray[np.int64], counts: NDArray[np.int64]) -> Floats:
    """Return deviations of samples from the mean of all periods at the same place in them; of a long record,
    those of its first periods."""
    taken = min(len(begin), max(FEWEST_PERIODS, _SAMPLES_OF_TAIL // int(np.max(counts)) + 1))
    length = int(np.min(counts))
    rows = begin[:taken, np.newaxis] + np.arange(length)
    table = samples[np.minimum(rows, len(samples) - 1)]
    return np.asarray(table - np.mean(table, axis=0)).ravel()


def _percentile_scatter(samples: Floats, repeats: Periods) -> MeanError:
    """Return the standard uncertainty of the percentile range, by what each period contributes to it.

    A percentile moves by the share of samples beyond it, more than expected, over the density there (Bahadur,
    Ann. Math. Statist. 37 (1966)); the density is that between percentiles a little to either side. Where
    neighbouring periods are correlated, how the ranges of parts of the record scatter is added. What it moves
    by from sample to sample is a series as the samples are, with noise that is too slow for the record.
    """
    at = (
        LOW_PERCENT - _NEAR,
        LOW_PERCENT,
        LOW_PERCENT + _NEAR,
        HIGH_PERCENT - _NEAR,
        HIGH_PERCENT,
        HIGH_PERCENT + _NEAR,
    )
    below, low, above_low, below_high, high, above = np.percentile(samples, at)
    per_share = 100.0 / (2.0 * _NEAR)
    is_low, is_high = samples < low, samples > high
    moved = per_share * ((above_low - below) * is_low + (above - below_high) * is_high)
    slowly, begin = _slowly(moved, repeats), repeats.rows[:-1]
    incomplete = slowly.mean - float(np.mean(moved))
    linear = MeanError(math.hypot(slowly.error.standard, incomplete), slowly.error.dof)
    of_few = max(_of_few(is_low, begin), _of_few(is_high, begin))
    linear = MeanError(of_few * linear.standard, linear.dof)
    if len(begin) < _CORRELATED * (linear.dof + 1.0) or len(begin) < 2 * _PARTS:
        return linear
    # few stretches make the tail, and with it the density there: those of parts say how much it varies
    parts = np.array([percentile_range(samples[rows]) for rows in _parts(begin, len(samples))])
    of_parts = _WHOLE_OVER_PARTS * float(np.std(parts, ddof=1)) / math.sqrt(_PARTS)
    return MeanError(math.hypot(linear.standard, of_parts), _PARTS - 1.0)


def _of_few(beyond: NDArray[np.bool_], begin: NDArray[np.int64]) -> float:
    """Return by how much more a percentile scatters where the samples beyond it are of few of the periods.

    Then the density there is that of these few. They count as the n = (sum s)^2 / sum s^2 that their shares s
    make; of periods alike it is about half of them.
    """
    shares = np.add.reduceat(beyond, begin, dtype=np.float64)
    squares = float(np.sum(shares**2))
    if not squares > 0.0:
        return 1.0
    concentrated = squares / float(np.sum(shares)) ** 2 - 2.0 / len(begin)
    return math.sqrt(1.0 + 2.0 * max(0.0, concentrated))


def _parts(begin: NDArray[np.int64], count: int) -> Iterator[slice]:
    """Return the rows of equally many whole periods each."""
    edges = [int(each[0]) for each in np.array_split(begin, _PARTS)]
    return (slice(first, last) for first, last in itertools.pairwise([*edges, count]))


def _repeated_steps(samples: Floats, begins: NDArray[np.int64], step: float) -> RepeatedSteps | None:
    """Return the errors of a converter's steps that are the same in every period; None where noise hides
    them."""
    periods = len(begins) - 1
    points = round((begins[-1] - begins[0]) / periods)
    at = begins[:-1, np.newaxis] + np.diff(begins)[:, np.newaxis] * (np.arange(points) / points)
    table = np.interp(at.ravel(), np.arange(len(samples)), samples).reshape(at.shape)
    phasors = fft.rfft(np.mean(table, axis=0))[1:] * (2.0 / points)
    if points % 2 == 0:
        phasors[-1] *= 0.5
    # periods begin within a sample: what the slope makes of that is no noise
    number = np.arange(periods + 1)
    within2 = float(np.var(begins - Polynomial.fit(number, begins, min(2, periods))(number)))
    slope = phasors * np.arange(1, len(phasors) + 1) * (2.0 * np.pi / points)
    left = float(np.mean(np.var(table, axis=0, ddof=1))) - within2 * float(np.sum(np.abs(slope) ** 2))
    # nor are periods that the track does not follow closely, which leave neighbouring samples alike
    noise2 = min(left, float(np.mean(np.diff(samples, 2) ** 2)) / 6.0)
    mean, covered = float(np.mean(table)), float(begins[-1] - begins[0])
    return repeated_steps(mean, phasors, step, noise_beside(noise2, step), covered, periods)
