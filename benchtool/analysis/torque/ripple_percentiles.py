"""By how much the percentiles of a ripple differ from record to record."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import equally_likely, students_deviation
from benchtool.analysis.statistics.scatter import MeanError, error_of_periods, error_of_series
from benchtool.analysis.torque.means_of_periods import Periods, mean_over_periods
from benchtool.analysis.torque.slow_ripple import BEGINS, SlowRipple

Floats = NDArray[np.float64]

LOW_PERCENT, HIGH_PERCENT = 0.5, 99.5
"""Percentiles between which single spikes do not count."""

_CORRELATED = 2.0  # periods that count as one, from which a tail is made of stretches of them
_OVERLAPPING = 2.0  # periods in a window, which count as one where each is another
_PARTS, _WHOLE_OVER_PARTS = 8, 1.27  # the whole reaches further into the tail than a part, and scatters more
_NORMAL = np.array(equally_likely(32))
_PLACES = 2048  # in the record


def percentile_range(samples: NDArray[np.float64]) -> float:
    """Return 99.5th minus the 0.5th percentile of samples, shape (n,), which single spikes do not affect."""
    low, high = np.percentile(samples, (LOW_PERCENT, HIGH_PERCENT))
    return float(high - low)


def percentile_scatter(samples: Floats, slow: SlowRipple) -> MeanError:
    """Return the standard uncertainty of the percentile range of samples, shape (n,), by what each period
    contributes to it, and no less than where rows fall in the crests that are beyond: of few crests the same
    number of rows may be beyond in all, by chance."""
    error = _by_periods(samples, slow)
    return replace(error, standard=max(error.standard, _Beyond.of(samples, slow.repeats).of_rows(samples)))


def _by_periods(samples: Floats, slow: SlowRipple) -> MeanError:
    """Return that of samples, shape (n,), by what each period contributes.

    A percentile moves by the share of samples beyond it, more than expected, over the density there (Bahadur,
    Ann. Math. Statist. 37 (1966)), within the shares that other records have. Where the size of the ripple
    differs by more than that, and its periods are correlated or few, how the ranges of parts of the record
    scatter is added. What it moves by from sample to sample is a series as the samples are, with noise that
    is too slow for the record. How many samples slow lines and a course bring beyond, of the mean or of the
    size of the ripple as where two tones beat, is expected: by the distribution of the rest without them.
    What is not, is where in a cycle the record begins and ends.
    """
    repeats = slow.repeats
    beyond, begin = _Beyond.of(samples, repeats), repeats.rows[:-1]
    moved, of_cycles = beyond.moved(samples), 0.0
    rest = samples
    if not slow.is_steady:
        place = repeats.places(len(samples))
        rest, order = slow.without(samples, place)
        moved -= beyond.expected(order, slow, place)
        place = np.linspace(0.0, 1.0, _PLACES)
        shifted = [float(np.mean(beyond.expected(order, slow, place, each))) for each in BEGINS]
        of_cycles = float(np.std(shifted, ddof=1))
    of_few = max(_of_few(samples < beyond.low, begin), _of_few(samples > beyond.high, begin))
    # of how few periods have what is beyond, their scatter alone tells
    slowly = mean_over_periods(moved, repeats, pooled=not of_few > 1.0)
    incomplete = slowly.mean - float(np.mean(moved))
    of_linear = of_few * math.hypot(slowly.error.standard, incomplete, of_cycles)
    linear = replace(slowly.error, standard=of_linear)
    # of most periods no sample is beyond: how long their ripple remembers shows in its size
    sizes = _sizes(rest, repeats)
    of_size = error_of_series(sizes)
    is_of_size = not (beyond.high - beyond.low) * of_size.standard < linear.standard * float(np.mean(sizes))
    independent = linear.dof + 1.0
    if is_of_size:
        independent = min(independent, _OVERLAPPING * (of_size.dof + 1.0))
    is_of_stretches = len(begin) >= _CORRELATED * independent
    whole = percentile_range(rest)
    if not (is_of_size if len(begin) < 2 * _PARTS else is_of_stretches) or whole == 0.0:
        return linear
    # few stretches make the tail, and with it the density there: those of parts say how much it varies
    count = min(_PARTS, len(begin))
    parts = np.array([percentile_range(rest[rows]) for rows in _parts(begin, len(samples), count)])
    of_parts = _WHOLE_OVER_PARTS * float(np.std(parts, ddof=1)) / math.sqrt(count)
    of_parts *= (beyond.high - beyond.low) / whole
    of_parts = math.hypot(linear.standard, students_deviation(count - 1.0) * of_parts)
    if math.isfinite(of_size.standard):
        return MeanError(of_parts, count - 1.0)
    # a size that wanders as slowly as the record makes all of its parts larger or smaller
    by_size = (beyond.high - beyond.low) * error_of_periods(sizes).standard / float(np.mean(sizes))
    return MeanError(max(of_parts, by_size), count - 1.0)  # nan of too few


def _sizes(samples: Floats, repeats: Periods) -> Floats:
    """Return the rms of the ripple about its mean, shape (periods - 1,), under a Hann window over every two
    neighbouring periods: by each alone it would differ as well by how far the marks are from its beginning,
    which wanders where the phase of a drifting speed is not followed."""
    begin, counts = repeats.rows[:-1], np.diff(repeats.rows)
    place = (np.arange(len(samples)) - np.repeat(begin, counts) + 0.5) / np.repeat(counts, counts)
    rises, deviation = np.sin(0.5 * np.pi * place) ** 2, samples - np.mean(samples)

    def windowed(values: Floats) -> Floats:
        up, all_of_it = (np.add.reduceat(each, begin) / counts for each in (values * rises, values))
        return np.asarray(up[:-1] + all_of_it[1:] - up[1:])

    square = windowed(deviation**2) - windowed(deviation) ** 2
    return np.asarray(np.sqrt(np.maximum(0.0, square)))


@dataclass(frozen=True)
class _Beyond:
    """Both percentiles, and by how much each moves for a share of samples beyond it."""

    low: float
    high: float
    of_low: float
    of_high: float

    @staticmethod
    def of(samples: Floats, repeats: Periods) -> _Beyond:
        low, high = np.percentile(samples, (LOW_PERCENT, HIGH_PERCENT))
        of_low = _per_share(samples, LOW_PERCENT / 100.0, repeats.means((samples < low).astype(float)))
        of_high = _per_share(samples, HIGH_PERCENT / 100.0, repeats.means((samples > high).astype(float)))
        return _Beyond(float(low), float(high), of_low, of_high)

    def moved(self, samples: Floats) -> Floats:
        """Return what each of samples, shape (n,), moves the range by, times n."""
        return np.asarray(self.of_low * (samples < self.low) + self.of_high * (samples > self.high))

    def of_rows(self, samples: Floats) -> float:
        """Return the standard deviation of the range of samples, shape (n,), by where rows fall in each of
        the crests that are beyond: how many of them are, is known to within a row at either end."""
        both = ((samples < self.low, self.of_low), (samples > self.high, self.of_high))
        crests = [(np.count_nonzero(np.diff(beyond, prepend=False) & beyond), of) for beyond, of in both]
        return math.sqrt(sum(of**2 * number / 6.0 for number, of in crests)) / len(samples)

    def expected(self, order: Floats, slow: SlowRipple, place: Floats, later: float = 0.0) -> Floats:
        """Return what samples are expected to move at places, shape (n,), of a record that begins a share of
        one later, where what is not slow has the same distribution as `order`, sorted, shape (m,)."""
        middle, size = slow.mean.mean + slow.mean.slowly(place, later), slow.size(place, later)
        from_low, to_high = (slow.mean.mean + (each - middle) / size for each in (self.low, self.high))
        low = np.searchsorted(order, from_low) / len(order)
        high = 1.0 - np.searchsorted(order, to_high, side="right") / len(order)
        return np.asarray(self.of_low * low + self.of_high * high)


def _per_share(samples: Floats, below: float, shares: Floats) -> float:
    """Return by how much a quantile of samples, shape (n,), the share `below` of which is below it, moves for
    the share beyond it, given that of each period, shape (periods,).

    It is the deviation of the quantiles at the shares that other records have, a Gamma distribution, over
    that of the shares (Maritz and Jarrett, J. Am. Stat. Assoc. 73 (1978) 194): where values are in heaps, as
    those that a converter makes, it is of how often a record ends in the next.
    """
    share = min(below, 1.0 - below)
    error = error_of_series(shares)
    deviation = error.experimental if math.isfinite(error.standard) else share
    deviation = min(max(deviation, 1.0 / len(samples)), share)

    def slope(deviation: float) -> float:
        # Wilson and Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684
        root = deviation / (3.0 * share)
        places = np.minimum(share * np.maximum(0.0, 1.0 - root**2 + root * _NORMAL) ** 3, 1.0)
        values = np.quantile(samples, places if below < 0.5 else 1.0 - places)
        return float(np.std(values) / np.std(places))

    # a heap that ends beyond this deviation in this record ends within it in others
    return max(slope(deviation), slope(2.0 * deviation))


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


def _parts(begin: NDArray[np.int64], end: int, count: int) -> Iterator[slice]:
    """Return the rows up to `end` in so many parts, of equally many whole periods each."""
    edges = [int(each[0]) for each in np.array_split(begin, count)]
    return (slice(first, last) for first, last in itertools.pairwise([*edges, end]))
