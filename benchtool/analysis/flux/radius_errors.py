"""Errors of means and of an rms over the revolutions of a flux, whose radius may grow or wander."""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.spectra.amplitude_trend import FEWEST_PERIODS, amplitude_trend
from benchtool.analysis.statistics.magnitudes import added_by_noise
from benchtool.analysis.statistics.scatter import (
    MeanError,
    at_lowest_frequencies,
    error_of_periods,
    error_of_series,
)

FINE: Final = 1e-5
"""Of the radius: a smaller step is the last digit of a number."""

_SLOW_SHARE = 0.03  # of a mean square, that the radius of whole revolutions makes up
_BY_CHANCE = 1.0  # standard deviation of a correlation: one that is taken for chance leaves far too little
_CLEARLY = 3.0  # standard deviations of a correlation
_DIFFER = 0.05  # by chance, of two variances
_FEWEST_VALUES = 10.0  # that do not depend on each other, of which an rms says something


def growth_within(circle: NDArray[np.complex128]) -> tuple[complex, complex]:
    """Return by how much order 1, shape (revolutions,), grows in each revolution on average, and the standard
    uncertainty of that along it. Of too few revolutions to tell a trend from chance both are half of what it
    seems to grow: it is as likely all of that as nothing."""
    count, size = len(circle), np.abs(circle)
    middle = complex(np.mean(circle))
    trend = amplitude_trend(size)
    if trend is not None:
        return middle * trend.growth / count, 0j
    if count >= FEWEST_PERIODS or count < 2:
        return 0j, 0j
    half = 0.5 * (size[-1] - size[0]) / (count - 1) * middle / abs(middle)
    return half, half


def error_of_mean(
    values: NDArray[np.float64], after: float, samples: NDArray[np.float64] | None = None
) -> MeanError:
    """Of the mean of values, shape (revolutions,), that of what a trend leaves of them, if they have one:
    `after` is the share of the record after the last revolution. Without one, where they are the means of
    `samples`, shape (n,), of what a control holds, the density of these tells it too."""
    trend = amplitude_trend(values, after=after)
    if trend is None:
        error = error_of_periods(values)
        return error if samples is None else _by_density(samples, error, len(values))
    mean, left = abs(float(np.mean(values))), error_of_series(trend.rest)
    return MeanError(mean * math.hypot(left.standard, trend.deviation), left.dof)


def _by_density(samples: NDArray[np.float64], by_parts: MeanError, count: int) -> MeanError:
    """Return the error of the mean of samples, shape (n,), of so many revolutions, by their means and by the
    density of the samples, unless that rises too steeply: the means then have been continued."""
    if not math.isfinite(by_parts.standard):
        return by_parts
    marks = np.linspace(0.0, len(samples), count + 1)
    error = at_lowest_frequencies(samples, by_parts, marks, pooled=True, may_fall=True)
    return error if math.isfinite(error.standard) else by_parts


def error_of_slow_rms(means: NDArray[np.float64], by_squares: MeanError, rms: float) -> tuple[MeanError, str]:
    """Of an rms to which a radius adds that keeps its value for some revolutions, and why there is none.

    By the correlation r of neighbours, less its bias (1 + 3 r) / n (Kendall, Biometrika 41 (1954) 403),
    (1 + r^2) / (1 - r^2) revolutions count as one of the mean square of a Gauss-Markov sequence. Its own
    correlations are small and often taken for chance.
    """
    count, deviation = len(means), means - np.mean(means)
    power = float(deviation @ deviation)
    share = power / (count * rms**2) if rms > 0.0 else 0.0
    if not share > 0.0 or not rms > FINE * abs(float(np.mean(means))):
        return by_squares, ""
    neighbours = float(deviation[1:] @ deviation[:-1]) / power
    if neighbours * math.sqrt(count) < _BY_CHANCE:
        return by_squares, ""
    memory = min(max(0.0, neighbours + (1.0 + 3.0 * neighbours) / count), 1.0 - 1.0 / count)
    # refused is by what the memory may be: of a long one those records in which it seems short read low
    longest = min(memory + _CLEARLY * math.sqrt((1.0 - neighbours**2) / count), 1.0 - 1.0 / count)
    fewest = count * (1.0 - longest) / (1.0 + longest)
    # few values may all be near each other, and make up far more of other records
    if not share * max(1.0, _FEWEST_VALUES / fewest) > _SLOW_SHARE:
        return by_squares, ""
    if fewest < _FEWEST_VALUES:
        return (
            by_squares,
            "the radius changes so slowly that the record holds few values of it: record longer",
        )
    values = count * (1.0 - memory**2) / (1.0 + memory**2)
    relative = share * math.sqrt(2.0 / values)
    slow = MeanError(0.5 * rms * relative * (1.0 + 2.0 * relative), max(1.0, values - 1.0))
    return (slow if slow.standard > by_squares.standard else by_squares), ""


def length_of_mean(
    points: NDArray[np.complex128],
    after: float,
    samples: NDArray[np.complex128] | None = None,
    steps: float = 0.0,
) -> tuple[float, float, MeanError]:
    """Return distance of the mean of points, shape (revolutions,), from zero, how much their scatter
    and `steps` of that standard uncertainty may add, and the error of the mean by scatter along its
    direction. Where the points are the means of `samples`, shape (n,), the density of these tells it too.
    """
    mean = complex(np.mean(points))
    length = abs(mean)
    towards = np.conj(mean) / length if length else 1.0
    turned, parts = points * towards, None if samples is None else samples * towards
    along = error_of_mean(turned.real, after, None if parts is None else parts.real)
    # a trend is relative to a mean, which is nothing across
    across = error_of_mean(length + turned.imag, after, None if parts is None else parts.imag)
    along, across = _pooled(along, across), _pooled(across, along)
    return length, added_by_noise(length, math.hypot(across.standard, steps)), along


def _pooled(one: MeanError, other: MeanError) -> MeanError:
    """Return the error of one component of a vector, by both where they differ by no more than chance: noise
    has no direction, and the scatter of few revolutions hardly tells it."""
    if not (one.standard > 0.0 and other.standard > 0.0 and math.isfinite(one.dof + other.dof)):
        return one
    if min(one.exceeds_by_chance(other), other.exceeds_by_chance(one)) < _DIFFER:
        return one
    return one.pooled(other)
