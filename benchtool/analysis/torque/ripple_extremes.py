"""By how much the peak-to-peak of a ripple differs from record to record, by the extremes of its periods."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.resampling import HALF_WIDTH, interpolate
from benchtool.analysis.spectra.amplitude_trend import amplitude_trend
from benchtool.analysis.statistics.excesses import FEWEST_EXTREMES, HeavyTail, scatter_of_largest
from benchtool.analysis.statistics.maxima import (
    ends_before_normal,
    is_no_heavier_than_normal,
    scatter_of_heap,
    scatter_of_largest_maximum,
    scatter_of_largest_normal,
)
from benchtool.analysis.statistics.neighbours import neighbours_alike
from benchtool.analysis.statistics.scatter import MeanError, error_of_periods, error_of_series
from benchtool.analysis.statistics.tail import tail_index
from benchtool.analysis.torque.means_of_periods import FEWEST_PERIODS
from benchtool.analysis.torque.slow_ripple import BEGINS, SlowRipple

Floats = NDArray[np.float64]

_SAMPLES_OF_TAIL = 1 << 17
_IS_NOISE = 1.3  # times the rms of white noise, up to which samples are it
_ALIKE, _TOGETHER, _FEW_EXTREMES = 3.0, 2.0, 20  # standard deviations of a correlation; periods
_PARTS_OF_PERIOD, _MOST_PARTS = 16, 4096
_FRACTIONS = np.arange(-8, 9) / 16.0  # of a row
_MEMORY, _FEWEST_SIZES = 2.0, 5.0  # periods that count as one; sizes in the record
_CLEARLY, _AGAIN = 0.5, 0.5  # times the other standard deviation; a correlation
_OF_A_CYCLE, _LEFT = 4, 0.03  # degree; of the variance, of which a random walk leaves an eighth


@dataclass(frozen=True)
class Tails:
    """Index of the tails of what differs from period to period, whether they are no heavier than normal, and
    the standard deviation of the largest of all samples of normal noise that differs from one to the next, 0
    where none shows: where a ripple leaves fewer near the largest, it is more. `above` and `below` are the
    tails of samples that are heavier than normal and independent; None where they are not both."""

    index: float
    is_light: bool
    of_normal: float
    above: HeavyTail | None = None
    below: HeavyTail | None = None

    @staticmethod
    def of(samples: Floats, begin: NDArray[np.int64], counts: NDArray[np.int64]) -> Tails:
        """Return those of samples, shape (n,), whose periods begin at rows and have counts, both of shape
        (periods,), unless deviations from the periods' mean or second differences show none."""
        # edges that repeat leave no deviations, and a slope that falls beside its place no second differences
        both = _deviations(samples, begin, counts), np.diff(samples, 2)
        index = min(map(tail_index, both))
        is_light = not index and any(map(is_no_heavier_than_normal, both))
        # of independent values second differences have six times the variance
        of_normal = scatter_of_largest_normal(both[1], len(samples)) / math.sqrt(6.0)
        about_mean, noise_rms = samples - np.mean(samples), float(np.std(both[1])) / math.sqrt(6.0)
        if float(np.std(samples)) < _IS_NOISE * noise_rms and ends_before_normal(about_mean):
            of_normal = 0.0
        is_heavy = not any(map(is_no_heavier_than_normal, both)) and not _is_clustered(both[0], len(begin))
        tails = (HeavyTail.above(both[0]), HeavyTail.above(-both[0])) if is_heavy else ()
        return Tails(index, is_light, of_normal, *tails)


def extremes_of_ripple(
    samples: Floats,
    rest: Floats,
    begin: NDArray[np.int64],
    tails: Tails,
    step: float = 0.0,
    slow: SlowRipple | None = None,
) -> float:
    """Return the standard deviation of the peak-to-peak over records, as `_by_extremes` of each period.

    A crest between two rows is missed by another part of it in each period, which comes back in every record
    and is no chance. Where the extremes of the curve between the samples clearly differ by less, and not as
    something that repeats, it is by these.
    """
    whole, without = (_extremes_of_periods(each, begin) for each in (samples, rest))
    if slow is None or not slow.swings:
        of_rest = _extremes_of_curve(rest, without, begin)
        is_less = step < _apart(of_rest) < _CLEARLY * _apart(without)
        if is_less and not any(map(_repeat, of_rest)):
            of_curve = of_rest if rest is samples else _extremes_of_curve(samples, whole, begin)
            # in other records by anything from none to twice as much (JCGM 100:2008, 4.3.7)
            missed = max(0.0, float(sum(map(np.max, of_curve))) - float(np.ptp(samples))) / math.sqrt(3.0)
            return math.hypot(_by_extremes(of_curve, of_rest, samples, rest, tails, step), missed)
    return _by_extremes(whole, without, samples, rest, tails, step, slow)


def _apart(extremes: tuple[Floats, Floats]) -> float:
    """Return by how much extremes of periods, each of shape (periods,), differ, both together."""
    return math.hypot(*(float(np.std(each)) for each in extremes))


def _by_extremes(
    whole: tuple[Floats, Floats],
    without: tuple[Floats, Floats],
    samples: Floats,
    rest: Floats,
    tails: Tails,
    step: float,
    slow: SlowRipple | None = None,
) -> float:
    """Return the standard deviation of the peak-to-peak over records, by the extremes of each period.

    They are those `without` slow lines, of `rest`, and without a course of few constants; where these are not
    all that is slow, they meet by chance, and those of the `whole` samples, shape (n,), count. Lines that are
    less than what the extremes differ by do not make the largest one of few.

    It is nan where the ripple itself grows or falls over the whole record, as in part of a beat: what it
    comes to is not told. Values in heaps that are no `step` of a converter, whose resolution is elsewhere,
    end in the next heap or not. Of a ripple that beats, by what is `slow` of it, those of its larger periods
    count as if all were of its largest size, and where its crests meet those of the beat is as in records
    that begin later.
    """
    moved = 0.0 if rest is samples else float(np.ptp(samples - rest))
    found = [
        [_about_course(each, moved > float(np.std(each))) for each in without],
        [_about_course(each) for each in whole],
    ]
    is_told = max(neighbours_alike(each.values) for each in found[0]) <= _ALIKE
    largest, least = found[0] if is_told else found[1]
    of_beat = 0.0
    if slow is not None and slow.swings:
        largest, least, of_beat = _in_beat(samples, slow)
    if _grows_throughout(np.add(*whole)):
        return math.nan
    # of periods in a slow line, as those of a revolution are, the extremes are heaps that all records have
    told, of_told = (without, rest) if is_told else (whole, samples)
    heaps = [scatter_of_heap(each, side * of_told) for each, side in zip(told, (1.0, -1.0), strict=True)]
    if any(heaps) and not step > 0.0:
        both = (of_heap or each.scatter(0.0) for of_heap, each in zip(heaps, (largest, least), strict=True))
        return math.hypot(*both)
    together = _grow_together(largest.values, least.values)
    if tails.is_light and not together and largest.is_plain and least.is_plain:
        both = (scatter_of_largest_maximum(each.values, tails.of_normal) for each in (largest, least))
        return max(of_beat, math.hypot(*both))
    apart = math.hypot(largest.scatter(tails.index), least.scatter(tails.index))
    if tails.above is not None and tails.below is not None and not together:
        signed = ((tails.above, largest.values), (tails.below, least.values))
        by_samples = math.hypot(*(tail.scatter_of_largest(each) for tail, each in signed))
        # few maxima tell too little at times, and samples nothing far beyond them: each is as likely
        apart = math.hypot(apart, by_samples) / math.sqrt(2.0) if by_samples else apart
    spans = largest.values + least.values
    of_size = error_of_series(spans)
    if together or len(largest.values) <= _FEW_EXTREMES:
        # what makes both extremes larger together scatters as their difference does
        apart = max(apart, _of_spans(spans, of_size, tails.index))
    # a size that wanders as slowly as the record makes all of its periods larger or smaller
    of_size = of_size if math.isfinite(of_size.standard) else error_of_periods(spans)
    if math.isfinite(of_size.standard):
        apart = math.hypot(apart, of_size.standard)
    return max(apart, of_beat)  # nan of too few


def _of_spans(spans: Floats, of_size: MeanError, tail: float) -> float:
    """Return the standard deviation of the largest of spans of periods, shape (periods,), whose mean has the
    error `of_size`: of sizes that their periods remember, and whose tails are no heavier than normal, by the
    largest of as many neighbours each as count as one."""
    counts = of_size.dof + 1.0
    is_memory = counts >= _FEWEST_SIZES and _MEMORY * counts < len(spans)
    if tail or not is_memory or not is_no_heavier_than_normal(spans - np.mean(spans)):
        return scatter_of_largest(spans, tail)
    begins = np.arange(0, len(spans), math.ceil(len(spans) / counts))
    return scatter_of_largest_maximum(np.maximum.reduceat(spans, begins))


def _in_beat(samples: Floats, slow: SlowRipple) -> tuple[_Maxima, _Maxima, float]:
    """Return the extremes of periods of samples, shape (n,), in those of their parts that have half the power
    of the largest at least, in its size, and the standard deviation of the peak-to-peak by where in its
    beat a record begins."""
    ends, place = slow.repeats.rows, slow.repeats.places(len(samples))
    begin = ends[:-1]
    rest = slow.without(samples, place)[0] - slow.mean.mean
    each = max(1, min(_PARTS_OF_PERIOD, _MOST_PARTS // len(begin), int(np.min(np.diff(ends)))))
    shares = np.arange(each) / each
    parts = (begin[:, np.newaxis] + np.diff(ends)[:, np.newaxis] * shares).astype(np.int64).ravel()
    at = 0.5 * (place[parts] + place[np.append(parts[1:], len(samples)) - 1])
    size = slow.size(at)
    top = float(np.max(size))
    # at the nodes noise is relatively larger
    is_kept = (size >= math.sqrt(0.5) * top).reshape(-1, each)
    extremes = [found.reshape(-1, each) for found in _extremes_of_periods(rest, parts)]
    rows = 2 * np.count_nonzero(is_kept, axis=1) > each
    largest, least = (top * np.max(np.where(is_kept, found, -np.inf), axis=1)[rows] for found in extremes)
    for part in range(each):
        kept = np.flatnonzero(is_kept[:, part])
        others = np.flatnonzero(~is_kept[:, part])
        for found in extremes:  # what is there in other records is as in the others
            found[others, part] = found[np.resize(kept, len(others)) if len(kept) else others, part]
    above, below = (found.ravel() for found in extremes)
    spans = []
    for later in BEGINS:
        mean, size = slow.mean.slowly(at, later), slow.size(at, later)
        spans.append(float(np.max(mean + size * above) + np.max(size * below - mean)))
    return _Maxima(largest), _Maxima(least), float(np.std(spans, ddof=1))


def _extremes_of_periods(samples: Floats, begin: NDArray[np.int64]) -> tuple[Floats, Floats]:
    return np.maximum.reduceat(samples, begin), -np.minimum.reduceat(samples, begin)


def _extremes_of_curve(
    samples: Floats, of_rows: tuple[Floats, Floats], begin: NDArray[np.int64]
) -> tuple[Floats, Floats]:
    """Return the extremes of periods of the band-limited curve through samples, shape (n,), a sixteenth of a
    row apart, but for the first and last rows: about each that a crest of the curve beside it may exceed the
    largest of its period from, `of_rows`, by an eighth of the usual bend (Taylor's theorem), and by as much
    again."""
    inner = np.arange(HALF_WIDTH, len(samples) - HALF_WIDTH - 1)
    period = np.searchsorted(begin, inner, side="right") - 1
    bend = 0.25 * float(np.sqrt(np.mean(np.diff(samples, 2) ** 2)) * math.sqrt(2.0))
    found = []
    for signed, extremes in zip((samples, -samples), of_rows, strict=True):
        near = signed[inner] >= extremes[period] - bend
        positions = (inner[near, np.newaxis] + _FRACTIONS).ravel()
        values = interpolate(signed, positions) if len(positions) else np.empty(0)
        largest = extremes.copy()
        np.maximum.at(largest, np.repeat(period[near], len(_FRACTIONS)), values)
        found.append(largest[_inner_periods(begin, len(samples))])
    return found[0], found[1]


def _inner_periods(begin: NDArray[np.int64], count: int) -> slice:
    """Return the periods throughout which the curve is known; all of them where these are few."""
    ends = np.append(begin[1:], count)
    first = int(np.searchsorted(begin, HALF_WIDTH))
    last = int(np.searchsorted(ends, count - HALF_WIDTH - 1, side="right"))
    return slice(first, last) if last - first >= FEWEST_EXTREMES else slice(None)


def _repeat(values: Floats) -> bool:
    """Return whether values, shape (n,), come again after some of them, as of a ripple that beats with the
    periods or repeats once in a revolution: by a correlation of more than a half."""
    deviation, count = values - np.mean(values), len(values)
    power = float(deviation @ deviation)
    covariance = np.correlate(deviation, deviation, "full")[count : count + count // 2]
    return power > 0.0 and float(np.max(covariance, initial=0.0)) > _AGAIN * power


def _grows_throughout(spans: Floats) -> bool:
    """Return whether a curve of less than a cycle, and no chance, explains spans of periods, shape
    (periods,)."""
    if len(spans) < FEWEST_PERIODS or neighbours_alike(spans) <= _ALIKE:
        return False
    number = np.arange(len(spans))
    rest = spans - Polynomial.fit(number, spans, _OF_A_CYCLE)(number)
    return bool(np.var(rest) < _LEFT * np.var(spans))


@dataclass(frozen=True)
class _Maxima:
    """Largest values of each period, shape (periods,), about their course, if they have one."""

    values: Floats
    has_course: bool = False

    @property
    def is_plain(self) -> bool:
        """Whether they are enough, and none is like its neighbours."""
        is_enough = len(self.values) >= FEWEST_EXTREMES
        return is_enough and not self.has_course and neighbours_alike(self.values) <= _TOGETHER

    def scatter(self, tail: float) -> float:
        """Return the standard deviation of the largest of all over records; on a course one of few is it."""
        of_largest = scatter_of_largest(self.values, tail)
        return max(of_largest, float(np.std(self.values, ddof=1))) if self.has_course else of_largest


def _about_course(values: Floats, has_course: bool = False) -> _Maxima:
    """Return values, shape (n,), about the course of few constants that explains how neighbours are alike, if
    one does; they may have had one already."""
    size = float(np.max(np.abs(values)))
    if len(values) < FEWEST_PERIODS or not size > 0.0 or neighbours_alike(values) <= _ALIKE:
        return _Maxima(values, has_course)
    middle = float(np.mean(values))
    trend = amplitude_trend(1.0 + (values - middle) / size)
    return _Maxima(values, has_course) if trend is None else _Maxima(middle + size * trend.rest, True)


def _grow_together(one: Floats, other: Floats) -> bool:
    """Return whether values of equal periods, shape (n,), are correlated by more than chance; n may be 0."""
    if not len(one) or not min(np.std(one), np.std(other)) > 0.0:
        return False
    return bool(math.sqrt(len(one)) * np.corrcoef(one, other)[0, 1] > _TOGETHER)


def _is_clustered(deviations: Floats, periods: int) -> bool:
    """Return whether the sizes of deviations, shape (n,), of so many periods are alike in neighbouring parts
    of a period, as of bursts or of slow noise."""
    length = max(1, len(deviations) // (periods * _PARTS_OF_PERIOD))
    size = np.abs(deviations[: len(deviations) // length * length]).reshape(-1, length).mean(axis=1)
    return len(size) <= FEWEST_PERIODS or neighbours_alike(size) > _ALIKE


def _deviations(samples: Floats, begin: NDArray[np.int64], counts: NDArray[np.int64]) -> Floats:
    """Return deviations of samples from the mean of all periods at the same place in them; of a long record,
    those of its first periods."""
    taken = min(len(begin), max(FEWEST_PERIODS, _SAMPLES_OF_TAIL // int(np.max(counts)) + 1))
    length = int(np.min(counts))
    rows = begin[:taken, np.newaxis] + np.arange(length)
    table = samples[np.minimum(rows, len(samples) - 1)]
    return np.asarray(table - np.mean(table, axis=0)).ravel()
