"""By how much the numbers of a ripple differ from period to period, and so from record to record."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps, steps_of_periods
from benchtool.analysis.spectra.amplitude_trend import amplitude_trend
from benchtool.analysis.statistics.neighbours import neighbours_alike
from benchtool.analysis.statistics.scatter import (
    FEWEST_EXTREMES,
    MeanError,
    at_lowest_frequencies,
    error_of_root,
    error_of_series,
)
from benchtool.analysis.torque.ripple_extremes import FEWEST_PERIODS, Tails, extremes_of_ripple
from benchtool.analysis.torque.slow_lines import SlowLines, slow_lines

Floats = NDArray[np.float64]

LOW_PERCENT, HIGH_PERCENT = 0.5, 99.5
"""Percentiles between which single spikes do not count."""

_CORRELATED = 2.0  # periods that count as one, from which a tail is made of stretches of them
_OVERLAPPING = 2.0  # periods in a window, which count as one where each is another
_PARTS, _WHOLE_OVER_PARTS = 8, 1.27  # the whole reaches further into the tail than a part, and scatters more
_ALIKE = 3.0  # standard deviations of a correlation
_NORMAL = np.array([NormalDist().inv_cdf((i + 0.5) / 32) for i in range(32)])  # equally probable
_OF_LAST = 16  # one in so many
_PLACES, _BEGINS = 2048, 16  # in the record, and of it in the cycles of slow lines


@dataclass(frozen=True)
class Periods:
    """What repeats in a record: the rows at which it begins, shape (periods + 1,), the first 0, the last the
    row after the last; `name` says what it is. `per_revolution` of them make one of the rotor, 1 where that
    is not known. `marks`, of the same shape, are the sample numbers up to which a row is before, if they are
    known."""

    rows: NDArray[np.int64]
    name: str = "electrical periods"
    per_revolution: int = 1
    marks: Floats | None = None

    def __len__(self) -> int:
        return len(self.rows) - 1

    @property
    def edges(self) -> Floats:
        """The marks, or the rows where they are not known."""
        return self.rows.astype(np.float64) if self.marks is None else self.marks

    def means(self, series: Floats) -> Floats:
        """Return the means of a series, shape (n,), over each period, from mark to mark: of the row that a
        mark parts both have their share, as what the rounding to rows brings to one it takes from the
        next."""
        sums = np.add.reduceat(series[: self.rows[-1]], self.rows[:-1])
        parted = (self.rows - self.edges) * series[np.maximum(self.rows - 1, 0)]
        return np.asarray((sums - np.diff(parted)) / np.diff(self.edges))

    def places(self, rows: Floats) -> Floats:
        """Return how far through all of them rows, shape (n,), are, from 0 to 1; behind them it is more, at
        the pace of the last."""
        within = np.interp(rows, self.rows, np.arange(len(self.rows)) / len(self))
        last = float(self.rows[-1] - self.rows[-2])
        return np.asarray(within + np.maximum(0.0, rows - self.rows[-1]) / (last * len(self)))


@dataclass(frozen=True)
class Scatter:
    """Uncertainties of mean, rms and percentile range, and the standard deviation of a peak-to-peak.

    That of the percentile range is None of fewer than four periods, in which it is an extreme as well.
    `whole_mean` and `whole_rms` are the mean and rms without what incomplete periods and cycles make of them,
    `steps` the errors of a converter's steps that repeat.
    """

    periods: int
    repeated: str
    mean: MeanError
    rms: MeanError
    percentile_range: MeanError | None
    peak_to_peak: float
    mean_peak_to_peak: float
    whole_mean: float
    whole_rms: float
    steps: RepeatedSteps | None


def percentile_range(samples: NDArray[np.float64]) -> float:
    """Return 99.5th minus the 0.5th percentile of samples, shape (n,), which single spikes do not affect."""
    low, high = np.percentile(samples, (LOW_PERCENT, HIGH_PERCENT))
    return float(high - low)


def scatter_of_periods(
    samples: Floats, repeats: Periods, step: float = 0.0, *, percentiles: bool = True
) -> Scatter | None:
    """Return the scatter of the numbers of samples, shape (n,), over whole periods; None where there are too
    few."""
    rows, count = repeats.rows, len(repeats)
    if count < FEWEST_PERIODS or np.min(np.diff(rows)) < 1:
        return None
    within, begin, counts = samples[: rows[-1]], rows[:-1], np.diff(rows)
    of_mean = _slowly(samples, repeats, may_fall=True)
    rest = within if of_mean.left is samples else of_mean.left[: rows[-1]]
    # what lines and the rest have in common is nothing over whole cycles of both
    square = np.square((of_mean.left if of_mean.of_lines else samples) - of_mean.mean)
    of_square = _slowly(square, repeats, may_fall=True)
    squares = repeats.means(square)
    rms = math.sqrt(max(0.0, of_square.mean + of_mean.of_lines))
    # noise as that of the mean moves an amplitude sqrt(2) times as much
    of_lines = 2.0 * math.sqrt(of_mean.of_lines) * of_mean.error.standard if of_mean.of_lines else 0.0
    error_of_square = MeanError(math.hypot(of_square.error.standard, of_lines), of_square.error.dof)
    spans = np.maximum.reduceat(within, begin) - np.minimum.reduceat(within, begin)
    tails = Tails.of(within, begin, counts)
    return Scatter(
        periods=count,
        repeated=repeats.name,
        mean=of_mean.error,
        rms=error_of_root(squares, rms, error_of_square),
        percentile_range=_percentile_scatter(within, repeats, of_mean)
        if percentiles and count >= FEWEST_EXTREMES
        else None,
        peak_to_peak=extremes_of_ripple(within, rest, begin, tails, step),
        mean_peak_to_peak=float(np.mean(spans)),
        whole_mean=of_mean.mean,
        whole_rms=rms,
        steps=steps_of_periods(within, rows, repeats.per_revolution, step)
        if percentiles and step > 0.0
        else None,
    )


@dataclass(frozen=True)
class _Slowly:
    """Mean of a series without what its incomplete period and the incomplete cycles of its slow lines make of
    it, and its error by what is `left` without these `lines`, shape (n,), and without the `course` of few
    constants that the means of the periods have besides, shape (periods,), if they have one."""

    left: Floats
    mean: float
    error: MeanError
    lines: SlowLines | None
    course: Floats | None

    @property
    def of_lines(self) -> float:
        """Mean square of the lines, 0 where they are not told from each other: then they are another
        course together."""
        return self.lines.mean_square if self.lines is not None and self.lines.are_apart else 0.0


def _slowly(series: Floats, repeats: Periods, *, pooled: bool = True, may_fall: bool = False) -> _Slowly:
    """Return the mean of a series, shape (n,), and its error by what is neither a slow line in it nor a
    course of few constants, such as a drift; of few periods `pooled` with its density."""
    rows, periods = repeats.rows, len(repeats)
    place = repeats.places(np.arange(0.5, len(series)))
    lines = slow_lines(series[: rows[-1]], place[: rows[-1]], periods, repeats.per_revolution)
    left = series if lines is None else series - lines.at(place)
    incomplete, not_repeated = _of_incomplete(left, repeats)
    of_cycles = 0.0 if lines is None else lines.mean_at(place)
    mean, rest = float(np.mean(series)) - of_cycles - incomplete, left[: rows[-1]]
    means = repeats.means(left)
    middle, size = float(np.mean(means)), float(np.max(np.abs(means)))
    trend = amplitude_trend(1.0 + (means - middle) / size) if size > 0.0 else None
    if trend is not None:
        error = _times(size, error_of_series(trend.rest), trend.apart)
    else:
        length = float(repeats.edges[-1])
        by_parts = error_of_series(means)
        error = at_lowest_frequencies(rest, by_parts, periods, length, pooled=pooled, may_fall=may_fall)
    of_mean = 1.0 if lines is None else lines.of_mean
    error = MeanError(math.hypot(of_mean * error.standard, not_repeated), error.dof)
    course = None if trend is None else means - middle - size * trend.rest
    return _Slowly(left, mean, error, lines, course)


def _of_incomplete(series: Floats, repeats: Periods) -> tuple[float, float]:
    """Return by how much the incomplete period behind the whole ones moves the mean of a series, shape (n,),
    and how much that differs from period to period: as much of each whole one has another mean than all of
    it, but for a drift.

    Where the speed drifts, the whole periods' mean over time is not that over angle either: by parts, they
    differ by the mean of the ripple's integral times the change of the period.
    """
    edges = repeats.edges
    begin, counts = edges[:-1], np.diff(edges)
    over = len(series) - float(edges[-1])
    parts = np.minimum(over * counts / counts[-1], counts)
    if not over > 0.0:
        return 0.0, 0.0
    number = np.arange(len(series) + 1)
    sums = np.concatenate([[0.0], np.cumsum(series - np.mean(series))])
    before, within, after = (np.interp(each, number, sums) for each in (begin, begin + parts, edges[1:]))
    of_parts = (within - before) / parts
    of_whole = (after - before) / counts
    drift = float(of_whole[-1] - of_whole[0]) / float(begin[-1] - begin[0])
    apart = of_parts - of_whole + drift * 0.5 * (counts - parts)
    differs = float(np.std(apart, ddof=1))
    if neighbours_alike(apart) > _ALIKE:  # the last ones are more like it, as where a drift is not followed
        apart = apart[-max(FEWEST_PERIODS, len(apart) // _OF_LAST) :]
        # they go on to change as they do
        differs = max(float(np.std(apart, ddof=1)), abs(float(apart[-1] - apart[0])))
    rows, whole = repeats.rows, np.diff(repeats.rows)
    integrals = sums[1 : rows[-1] + 1] - np.repeat(sums[rows[:-1]], whole)
    integral = float(np.mean(np.add.reduceat(integrals, rows[:-1]) / whole**2))
    of_speed = -integral * _growth(whole)
    moved = (float(np.mean(apart)) * over + of_speed) / len(series)
    return moved, differs * over / len(series)


def _growth(counts: NDArray[np.int64]) -> float:
    """Return by how many rows periods grow over the record, by a straight line; 0 where whole rows alone may
    make it, each count being off by the difference of two roundings."""
    slope = float(np.polyfit(np.arange(len(counts)), counts, 1)[0])
    growth = slope * (len(counts) - 1)
    of_rows = math.sqrt(2.0 / len(counts))  # sqrt(1/6 x 12 / n)
    return growth if abs(growth) > 2.0 * of_rows else 0.0


def _times(size: float, error: MeanError, deviation: float) -> MeanError:
    return MeanError(size * math.hypot(error.standard, deviation), error.dof)


def _percentile_scatter(samples: Floats, repeats: Periods, of_mean: _Slowly) -> MeanError:
    """Return the standard uncertainty of the percentile range of samples, shape (n,), by what each period
    contributes to it.

    A percentile moves by the share of samples beyond it, more than expected, over the density there (Bahadur,
    Ann. Math. Statist. 37 (1966)), within the shares that other records have. Where the size of the ripple
    differs by more than that, and its periods are correlated or few, how the ranges of parts of the record
    scatter is added. What it moves by from sample to sample is a series as the samples are, with noise that
    is too slow for the record. How many samples slow lines and a course bring beyond is expected: by the
    distribution of the rest without them. What is not, is where in a cycle the record begins and ends.
    """
    beyond, begin = _Beyond.of(samples, repeats), repeats.rows[:-1]
    moved, of_cycles = beyond.moved(samples), 0.0
    lines = of_mean.lines
    if lines is not None and not lines.are_apart:
        lines = None
    rest = samples if lines is None else of_mean.left[: len(samples)]
    if of_mean.course is not None:
        middle = 0.5 * (begin + repeats.rows[1:])
        rest = rest - np.interp(np.arange(0.5, len(samples)), middle, of_mean.course)
    if rest is not samples:
        order = np.sort(rest)
        moved -= beyond.expected(order, samples - rest)
    if lines is not None:
        place = np.linspace(0.0, 1.0, _PLACES)
        begins = np.arange(_BEGINS) * (math.sqrt(5.0) - 1.0) / 2.0
        shifted = [float(np.mean(beyond.expected(order, lines.at(place + each)))) for each in begins]
        of_cycles = float(np.std(shifted, ddof=1))
    of_few = max(_of_few(samples < beyond.low, begin), _of_few(samples > beyond.high, begin))
    # of how few periods have what is beyond, their scatter alone tells
    slowly = _slowly(moved, repeats, pooled=not of_few > 1.0)
    incomplete = slowly.mean - float(np.mean(moved))
    linear = MeanError(math.hypot(slowly.error.standard, incomplete, of_cycles), slowly.error.dof)
    linear = MeanError(of_few * linear.standard, linear.dof)
    # of most periods no sample is beyond: how long their ripple remembers shows in its size
    sizes = _sizes(rest, repeats)
    of_size = error_of_series(sizes)
    is_of_size = not (beyond.high - beyond.low) * of_size.standard < linear.standard * float(np.mean(sizes))
    independent = linear.dof + 1.0
    if is_of_size:
        independent = min(independent, _OVERLAPPING * (of_size.dof + 1.0))
    is_of_stretches = len(begin) >= _CORRELATED * independent
    if not (is_of_size if len(begin) < 2 * _PARTS else is_of_stretches):
        return linear
    # few stretches make the tail, and with it the density there: those of parts say how much it varies
    count = min(_PARTS, len(begin))
    parts = np.array([percentile_range(rest[rows]) for rows in _parts(begin, len(samples), count)])
    of_parts = _WHOLE_OVER_PARTS * float(np.std(parts, ddof=1)) / math.sqrt(count)
    return MeanError(math.hypot(linear.standard, students_deviation(count - 1.0) * of_parts), count - 1.0)


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

    def expected(self, order: Floats, lines: Floats) -> Floats:
        """Return what samples are expected to move at these values of slow lines, shape (n,), with others of
        the same distribution as `order`, sorted, shape (m,), beside them."""
        low = np.searchsorted(order, self.low - lines) / len(order)
        high = 1.0 - np.searchsorted(order, self.high - lines, side="right") / len(order)
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
    deviation = error.standard / students_deviation(error.dof) if math.isfinite(error.standard) else share
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
