"""Means of a series over what repeats, and their error by what is neither a slow line nor a course in it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.periods import rows_of_marks
from benchtool.analysis.phase.period_marks import PeriodMarks
from benchtool.analysis.spectra.amplitude_trend import amplitude_trend
from benchtool.analysis.statistics.neighbours import neighbours_alike
from benchtool.analysis.statistics.scatter import MeanError, at_lowest_frequencies, error_of_series
from benchtool.analysis.torque.fitted_lines import FittedLines, lines_between_harmonics, slow_lines

Floats = NDArray[np.float64]

FEWEST_PERIODS = 3
"""Fewest periods whose scatter is used."""

_FEWEST_REVOLUTIONS = 8
_APART_IN_TIME = 1e-4  # of the record, by which periods are off even ones where they differ in length
_ALIKE = 3.0  # standard deviations of a correlation
_CLEARLY_MORE = 1.5  # times a standard uncertainty
_ROWS_BEHIND = 1.0  # one period, and the row that may be begun with the last
_OF_A_ROW = 0.5  # rounding of the rows behind the last mark, or whole rows that were left out there
_OF_LAST = 16  # one in so many


@dataclass(frozen=True)
class Periods:
    """What repeats in a record: the rows at which it begins, shape (periods + 1,), the first 0, the last the
    row after the last; `name` says what it is. `per_revolution` of them make one of the rotor, 1 where that
    is not known. `marks` tell, if they are known, where between rows each begins."""

    rows: NDArray[np.int64]
    name: str = "electrical periods"
    per_revolution: int = 1
    marks: PeriodMarks | None = None

    @classmethod
    def of(cls, marks: PeriodMarks, per_revolution: int = 1, name: str = "electrical periods") -> Periods:
        """Return those that begin at marks."""
        return cls(rows_of_marks(marks.numbers), name, per_revolution, marks)

    @property
    def tell_scatter(self) -> bool:
        """Whether there are enough of them, with a row in each."""
        return len(self) >= FEWEST_PERIODS and int(np.min(np.diff(self.rows))) >= 1

    def __len__(self) -> int:
        return len(self.rows) - 1

    @property
    def edges(self) -> Floats:
        """The marks, or the rows where they are not known."""
        return self.rows.astype(np.float64) if self.marks is None else self.marks.numbers

    @property
    def turns(self) -> Floats:
        """Where the rows of all periods are, from 0 to their number, shape (n,)."""
        return np.asarray(np.interp(np.arange(self.rows[-1]), self.edges, np.arange(len(self) + 1.0)))

    @cached_property
    def revolutions(self) -> Periods | None:
        """The whole revolutions that they make; None of few, or where each of them is one."""
        each, marks = self.per_revolution, self.marks
        whole = len(self) // each
        if each == 1 or marks is None or whole < _FEWEST_REVOLUTIONS:
            return None
        numbers, behind = marks.numbers[: whole * each + 1 : each], len(self) - whole * each
        as_far = None
        if marks.as_far is not None:
            stops = np.arange(0, whole * each, each) + behind
            of_whole = marks.numbers[stops] - numbers[:-1] + marks.as_far[stops]
            as_far = np.append(of_whole, marks.numbers[-1] - numbers[-1] + marks.as_far[-1])
        return Periods(self.rows[: whole * each + 1 : each], "revolutions", 1, PeriodMarks(numbers, as_far))

    def told(self, series: Floats) -> Floats:
        """Return a series, shape (n,), without what is more than a period behind the last mark, where nothing
        tells what repeats: the whole periods alone."""
        last, edges = int(self.rows[-1]), self.edges
        behind = len(series) - float(edges[-1]) - float(edges[-1] - edges[-2])
        return series[:last] if behind > _ROWS_BEHIND else series

    def means(self, series: Floats) -> Floats:
        """Return the means of a series, shape (n,), over each period, from mark to mark: of the row that a
        mark parts both have their share, as what the rounding to rows brings to one it takes from the
        next."""
        sums = np.add.reduceat(series[: self.rows[-1]], self.rows[:-1])
        parted = (self.rows - self.edges) * series[np.maximum(self.rows - 1, 0)]
        return np.asarray((sums - np.diff(parted)) / np.diff(self.edges))

    def parts(self, count: int) -> tuple[Floats, float]:
        """Return in how many rows each turns as far as so many rows do behind the last, shape (periods,), and
        how many those are: by the pace of the last one where nothing tells it."""
        counts = np.diff(self.edges)
        behind = count - float(self.edges[-1])
        as_far = None if self.marks is None else self.marks.as_far
        if as_far is not None and behind > as_far[-1] - _OF_A_ROW and as_far[-1] < counts[-1]:
            return np.minimum(as_far[:-1], counts), float(as_far[-1])
        # one that ends between the last two rows is among those behind, and makes nothing of the mean
        over = math.fmod(behind, float(counts[-1]))
        return np.minimum(over * counts / counts[-1], counts), over

    def places(self, count: int) -> Floats:
        """Return how far through all of them so many rows are, from 0 to 1, shape (count,), or their middles
        where no marks are known; behind them it is more, at the pace of the last."""
        if count <= self.rows[-1]:
            return self._places[:count]
        edges, first = self.edges, 0.5 if self.marks is None else 0.0
        behind = np.arange(self.rows[-1] + first, count) - edges[-1]
        last = float(edges[-1] - edges[-2])
        return np.concatenate([self._places, 1.0 + behind / (last * len(self))])

    @cached_property
    def _places(self) -> Floats:
        if self.marks is not None:
            return self.turns / len(self)
        rows, periods = np.arange(0.5, self.rows[-1]), np.arange(len(self.rows))
        return np.asarray(np.interp(rows, self.rows, periods / len(self)))


@dataclass(frozen=True)
class Course:
    """Course of few constants over a record, from 0 to 1: `size` times a curve. A sinusoid of so many
    `cycles` goes on beyond it, as it does in other records from another place on."""

    curve: Callable[[Floats], Floats]
    size: float
    cycles: float

    def at(self, place: Floats, later: float = 0.0) -> Floats:
        """Return it at places, shape (n,), in a record that begins a share of one later."""
        return self.size * self.curve(place + later if self.cycles else place)


@dataclass(frozen=True)
class MeanOverPeriods:
    """Mean of a series without what its incomplete period and the incomplete cycles of its slow lines make of
    it, and its error by what is `left` without these `lines`, shape (n,), and without the `course` of few
    constants that the means of the periods have besides, if they have one; these means deviate from both by
    the rms `deviation`."""

    left: Floats
    mean: float
    error: MeanError
    lines: FittedLines | None
    course: Course | None
    deviation: float = 0.0

    @property
    def of_lines(self) -> float:
        """Mean square of the lines, 0 where they are not told from each other: then they are another
        course together."""
        return self.lines.mean_square if self.lines is not None and self.lines.are_apart else 0.0

    @property
    def of_slow_noise(self) -> float:
        """Standard deviation of the mean square of what the means deviate by, if its memory is exponential:
        over a time T noise of the autocorrelation R(t) has a mean of the variance 2/T times the integral of
        R, and a mean square of the variance 4/T times that of R^2."""
        return self.deviation * self.error.standard

    @property
    def is_steady(self) -> bool:
        """Whether there is neither a line that is told nor a course."""
        return not self.of_lines and self.course is None

    def slowly(self, place: Floats, later: float = 0.0) -> Floats:
        """Return the sum of lines, which are told from each other, and course at places, shape (n,), from 0
        to 1, in a record that begins a share of one later."""
        found: Floats = np.zeros(len(place))
        if self.lines is not None and self.lines.are_apart:
            found += self.lines.at(place + later)
        if self.course is not None:
            found += self.course.at(place, later)
        return found


def mean_over_periods(
    series: Floats,
    repeats: Periods,
    *,
    pooled: bool = True,
    may_fall: bool = False,
    reference: Floats | None = None,
    by_revolutions: bool = False,
) -> MeanOverPeriods:
    """Return the mean of a series, shape (n,), and its error by what is neither a slow line in it nor a
    course of few constants, such as a drift; of few periods `pooled` with its density, which a `reference`
    that it follows tells too. Where orders of a revolution stand out it is over whole ones, of few not, if
    asked for `by_revolutions`. Rows behind periods that are told count by the course alone."""
    last, place = int(repeats.rows[-1]), repeats.places(len(series))
    lines = slow_lines(series[:last], place[:last], len(repeats), repeats.per_revolution)
    left = series if lines is None else series - lines.at(place)
    followed = None if reference is None else reference[:last]
    if followed is not None and lines is not None:  # which are its lines too
        own = slow_lines(followed, place[:last], len(repeats), repeats.per_revolution)
        followed = followed if own is None else followed - own.at(place[:last])
    beside = _BesideLines(series, repeats, place, left, lines, followed, pooled, may_fall)
    over_periods = beside.mean(None)
    between = lines_between_harmonics(left[:last], place[:last], len(repeats), repeats.per_revolution)
    if between is not None:
        without = beside.mean(between)
        # sidebands of a speed that swings look like lines, and are known better by where the rotor is
        if not _CLEARLY_MORE * over_periods.error.standard < without.error.standard:
            over_periods = without
    mean, error = over_periods.mean, over_periods.error
    turns = repeats.revolutions if by_revolutions and lines is not None and lines.are_of_revolution else None
    if turns is None:
        return over_periods
    # the speed swings with such lines, and whole revolutions have the time of all that it does
    over_turns = mean_over_periods(series, turns, pooled=pooled, may_fall=may_fall, reference=reference)
    # what is slow beside is told by many periods, and by few revolutions not
    of_turns, apart = over_turns.error.standard, over_turns.mean - mean
    if not math.isfinite(of_turns) or of_turns > math.hypot(error.standard, apart):
        return over_periods
    return replace(over_periods, mean=over_turns.mean, error=over_turns.error)


@dataclass(frozen=True)
class _BesideLines:
    """A series at places, shape (n,), of which slow lines leave so much; what it follows, shape (rows,), has
    its noise as well."""

    series: Floats
    repeats: Periods
    place: Floats
    left: Floats
    lines: FittedLines | None
    followed: Floats | None
    pooled: bool
    may_fall: bool

    def mean(self, between: FittedLines | None) -> MeanOverPeriods:
        """Return its mean, without lines between the harmonics as well."""
        series, repeats, place = self.series, self.repeats, self.place
        last, told = int(repeats.rows[-1]), len(repeats.told(series))
        alike = self.left if between is None else self.left - between.at(place)
        of_cycles, of_mean = 0.0, 1.0
        for each in filter(None, (self.lines, between)):
            of_cycles += each.mean_at(place[:told])
            of_mean *= each.of_mean
        rest, means = alike[:last], repeats.means(alike)
        middle, size = float(np.mean(means)), float(np.max(np.abs(means)))
        found = _course((means - middle) / size, repeats) if size > 0.0 else None
        if found is not None:
            error = replace(found.error, standard=size * found.error.standard)
            deviation = size * found.deviation
        else:
            deviation = float(np.std(means))
            by_parts = error_of_series(means)
            error = at_lowest_frequencies(
                rest,
                by_parts,
                repeats.edges,
                reference=self.followed,
                pooled=self.pooled,
                may_fall=self.may_fall,
            )
        course = None if found is None else replace(found.course, size=size)
        slowly = np.zeros(len(series)) if course is None else course.at(place)
        incomplete, not_repeated = _of_incomplete((alike - slowly)[:told], repeats)
        error = replace(error, standard=math.hypot(of_mean * error.standard, not_repeated))
        mean = float(np.mean(series[:told] - slowly[:told]) + np.mean(slowly)) - of_cycles - incomplete
        return MeanOverPeriods(self.left, mean, error, self.lines, course, deviation)


@dataclass(frozen=True)
class _Found:
    """A course of means, the error of their mean by what it leaves, and the rms of that."""

    course: Course
    error: MeanError
    deviation: float


def _course(means: Floats, repeats: Periods) -> _Found | None:
    """Return the course of the means of periods, shape (periods,), over these or, where they differ in
    length, over time, whichever leaves less; None if there is none."""
    even, edges = np.linspace(0.0, 1.0, len(means) + 1), repeats.edges / repeats.edges[-1]
    trend = amplitude_trend(1.0 + means)
    in_time = amplitude_trend(1.0 + means, edges=edges) if np.ptp(edges - even) > _APART_IN_TIME else None
    if trend is not None and (in_time is None or np.std(trend.rest) <= np.std(in_time.rest)):
        error = error_of_series(trend.rest)
        error = replace(error, standard=math.hypot(error.standard, trend.apart))
        return _Found(Course(trend.curve, 1.0, trend.cycles), error, float(np.std(trend.rest)))
    if in_time is None:
        return None
    curve, lengths = in_time.curve, np.diff(edges)
    # behind the last one at its pace, as places are
    places, times = np.append(even, 2.0), np.append(edges, 1.0 + len(means) * lengths[-1])
    error = error_of_series(in_time.rest)
    # in the mean over time long periods count more
    alone = math.sqrt(len(means) * float(lengths @ lengths)) * error.standard
    apart = float(lengths @ in_time.over_periods) - in_time.level if in_time.cycles else 0.0
    error = replace(error, standard=math.hypot(alone, apart))
    course = Course(lambda place: curve(np.interp(place, places, times)), 1.0, in_time.cycles)
    return _Found(course, error, float(np.std(in_time.rest)))


def _of_incomplete(series: Floats, repeats: Periods) -> tuple[float, float]:
    """Return by how much the incomplete period behind the whole ones moves the mean of a series, shape (n,),
    and how much that differs from period to period: as much of each whole one has another mean than all of
    it, but for a drift.

    Where the speed drifts, the whole periods' mean over time is not that over angle either: by parts, they
    differ by the mean of the ripple's integral times the change of the period.
    """
    edges = repeats.edges
    begin, counts = edges[:-1], np.diff(edges)
    parts, over = repeats.parts(len(series))
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
    place = (np.arange(1, rows[-1] + 1) - np.repeat(rows[:-1], whole)) / np.repeat(whole, whole)
    # of what repeats, without the mean of each period
    from_begin, to_end = (np.repeat(sums[each], whole) for each in (rows[:-1], rows[1:]))
    integrals = sums[1 : rows[-1] + 1] - from_begin - place * (to_end - from_begin)
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
