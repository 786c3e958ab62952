"""A course of an amplitude that a curve of few constants explains: it is told from noise, and is none."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.statistics.neighbours import neighbours_alike
from benchtool.analysis.statistics.slow_swing import sinusoid_of, swing_basis

Floats = NDArray[np.float64]

FEWEST_PERIODS = 16
"""Of fewer amplitudes a trend is not told from chance."""

_LEFT = 0.03  # of the variance; of a random walk a parabola leaves a quarter
_LEFT_OF_TWO = 0.01  # where a sinusoid and a line explain it: of one walk in a thousand these leave as little
_LEAST_CYCLES = 1.0  # of a swing: the constant that a part of one is about is not known
_WITHOUT_DOUBT, _ALIKE = 3e-4, 3.0  # of the variance; standard deviations of a correlation
_RATE_STEP, _FINER_RATES = 1.25, 15
_RATES = _RATE_STEP ** np.arange(16.0)  # time constants in the record: one to thirty
_POINTS_PER_PERIOD = 8
_OF_TIME = 1.0 / (6.0 * math.sqrt(3.0))  # of a bend: a sixth at most between means over phases and time
_OF_EDGE = 0.8 / (4.0 * math.pi * math.sqrt(2.0))
"""Standard deviation over phases by which the amplitude of a period is off what a step in it has on average,
relative to the step: of twice the integral of cos^2 the part sin / (4 pi), less what the rounds find."""


@dataclass(frozen=True)
class AmplitudeTrend:
    """Course of an amplitude over a record, from 0 to 1, relative to the mean over its whole periods.

    `level` is the mean of the `curve` over the time of the record, or the constant that a swing is about, and
    `of_level` its standard uncertainty against the mean over periods; `apart` is by how much that mean is off
    it; `deviation` is that and how far a mean over phases is from one over time. `rest`, shape (periods,), is
    what the course, `over_periods`, leaves of the amplitudes, `growth` by how much it grows from the begin of
    the first period to the end of the last; a step is no growth. A sinusoid has so many `cycles`; `is_step`
    tells that it is one value before an edge, and another after it.
    """

    curve: Callable[[Floats], Floats]
    level: float
    of_level: float
    deviation: float
    apart: float
    rest: Floats
    over_periods: Floats
    growth: float
    cycles: float
    is_step: bool


def amplitude_trend(
    amplitudes: Floats, before: float = 0.0, after: float = 0.0, edges: Floats | None = None
) -> AmplitudeTrend | None:
    """Return the trend of amplitudes, shape (periods,); None if there is none.

    A line, a parabola, a step, an exponential, or one sinusoid about a constant or a line: the first that
    leaves less than three hundredths of the variance, the last less than one, which is far less than of an
    amplitude that wanders at random, and of that nothing but noise, whose neighbours are not alike. `before`
    and `after` are the shares of the record,
    relative to the periods, that are outside them; `edges`, shape (periods + 1,), are where the periods begin
    and end in time, from 0 to 1, by default evenly.
    """
    count = len(amplitudes)
    mean = float(np.mean(amplitudes))
    if count < FEWEST_PERIODS or not mean > 0.0:
        return None
    relative = amplitudes / mean - 1.0
    power = float(np.mean(relative**2))
    if not power > 0.0:
        return None
    numbers = np.arange(count + 1.0)
    edges, bent = (numbers / count, 1.0) if edges is None else (edges, 0.0)
    place = 0.5 * (edges[1:] + edges[:-1])
    for found in _curves(relative, edges, 0.5 * (1.0 + after - before)):
        curve, about, slopes = found.curve, found.about, found.slopes
        over_periods = curve(place) if found.mean is None else found.mean(edges[:-1], edges[1:])
        rest = relative - over_periods
        left = float(np.mean(rest**2)) / power
        if left > found.left or (left > _WITHOUT_DOUBT and neighbours_alike(rest) > _ALIKE):
            continue
        phases = (np.arange(_POINTS_PER_PERIOD * count) + 0.5) / (_POINTS_PER_PERIOD * count)
        points, whole = np.interp(count * phases, numbers, edges), (1.0 + before + after) * phases - before
        course = curve(points)
        level = float(np.mean(curve(whole))) if about is None else about
        if found.mean is not None:
            level = float(found.mean(-before, 1.0 + after))
        apart = float(np.mean(course)) - level
        begin, end = curve(np.array([0.0, 1.0]))
        height, growth = (float(end - begin), 0.0) if found.is_step else (0.0, float(end - begin))
        by_constants = np.mean(slopes(points), axis=0)
        by_constants -= np.mean(slopes(whole), axis=0) if about is None else np.eye(len(by_constants))[0]
        # the constants have the covariance (S^T S)^-1 of noise (JCGM 102:2011, 6.2.1.3)
        by_values = by_constants @ np.linalg.pinv(slopes(place))
        noise2 = float(rest @ rest) / max(1, count - len(by_constants))
        return AmplitudeTrend(
            curve=curve,
            level=level,
            of_level=math.hypot(math.sqrt(noise2 * float(by_values @ by_values)), _OF_EDGE * height / count),
            deviation=math.hypot(apart, bent * _OF_TIME * found.bend),
            apart=abs(apart),
            rest=rest,
            over_periods=over_periods,
            growth=growth,
            cycles=found.cycles,
            is_step=found.is_step,
        )
    return None


@dataclass(frozen=True)
class _Fitted:
    """A curve over a record, from 0 to 1, that may leave so much of the variance: the constant that it is
    `about`, if it is about one, its bend, its slopes by its constants, shape (places, constants), its cycles,
    if it is a sinusoid, and its mean from one place to another, where a point of each period is too few."""

    curve: Callable[[Floats], Floats]
    slopes: Callable[[Floats], Floats]
    about: float | None = None
    bend: float = 0.0
    cycles: float = 0.0
    left: float = _LEFT
    mean: Callable[[Floats | float, Floats | float], Floats] | None = None
    is_step: bool = False


def _curves(relative: Floats, edges: Floats, middle: float) -> Iterator[_Fitted]:
    """Yield curves over the record, about its `middle`, of amplitudes of periods between edges."""
    place = 0.5 * (edges[1:] + edges[:-1])
    for degree in (1, 2):
        line = np.polynomial.Polynomial.fit(place, relative, degree)
        bend = 0.5 * float(line.deriv(2)(0.0)) if degree == 2 else 0.0
        yield _Fitted(line, partial(_powers, degree), bend=abs(bend))
    step = _step(relative, edges)
    yield _Fitted(step, step.slopes, mean=step.mean, is_step=True)
    settling = _settling(relative, edges)
    yield _Fitted(settling, settling.slopes, mean=settling.mean)
    yield from _swing(relative, place)
    yield from _swing(relative, place, middle)


def _powers(degree: int, places: Floats) -> Floats:
    return np.asarray(np.vander(places, degree + 1, increasing=True))


@dataclass(frozen=True)
class _Step:
    """One value before an edge, another after it."""

    before: float
    after: float
    edge: float

    def __call__(self, places: Floats) -> Floats:
        return np.where(places < self.edge, self.before, self.after)

    def mean(self, begin: Floats | float, end: Floats | float) -> Floats:
        """Return the mean from one place to another."""
        share = np.clip((self.edge - begin) / (np.asarray(end) - begin), 0.0, 1.0)
        return np.asarray(self.after + share * (self.before - self.after))

    def slopes(self, places: Floats) -> Floats:
        return np.stack([places < self.edge, places >= self.edge], axis=1).astype(np.float64)


def _step(relative: Floats, edges: Floats) -> _Step:
    """Return the step that leaves least, within one of the two periods beside the best place between periods,
    which has what is in between."""
    count = len(relative)
    sums = np.cumsum(relative)[:-1]
    number = np.arange(1, count)
    first, last = sums / number, (np.sum(relative) - sums) / (count - number)
    at = 1 + int(np.argmax(first**2 * number + last**2 * (count - number)))
    found = []
    for period in (max(1, at - 1), min(at, count - 2)):
        before, after = float(np.mean(relative[:period])), float(np.mean(relative[period + 1 :]))
        share = (float(relative[period]) - after) / (before - after) if before != after else 0.0
        share = min(1.0, max(0.0, share))
        edge = share * float(edges[period + 1]) + (1.0 - share) * float(edges[period])
        found.append(_Step(before, after, edge))
    return min(found, key=lambda each: float(np.sum((relative - each.mean(edges[:-1], edges[1:])) ** 2)))


@dataclass(frozen=True)
class _Settling:
    """An exponential of a size and a rate to a final value: a machine that warms up, a decaying flux."""

    final: float
    size: float
    rate: float

    def __call__(self, places: Floats) -> Floats:
        return np.asarray(self.final + self.size * np.exp(-self.rate * places))

    def mean(self, begin: Floats | float, end: Floats | float) -> Floats:
        """Return the mean from one place to another."""
        return np.asarray(self.final + self.size * _mean_decay(self.rate, begin, end))

    def slopes(self, places: Floats) -> Floats:
        decay = np.exp(-self.rate * places)
        return np.stack([np.ones(len(places)), decay, -self.size * places * decay], axis=1)


def _settling(relative: Floats, edges: Floats) -> _Settling:
    """Return the exponential that leaves least of amplitudes of periods between edges, which are its means
    over these."""
    deviation, (begin, end) = relative - np.mean(relative), (edges[:-1], edges[1:])

    def best_of(rates: Floats) -> float:
        decays = _mean_decay(rates[:, np.newaxis], begin, end)
        decays -= np.mean(decays, axis=1, keepdims=True)
        return float(rates[np.argmax((decays @ deviation) ** 2 / np.sum(decays**2, axis=1))])

    rate = best_of(_RATES)
    for step in (_RATE_STEP, _RATE_STEP ** (2.0 / _FINER_RATES)):
        rate = best_of(rate * np.geomspace(1.0 / step, step, _FINER_RATES))
    columns = np.stack([np.ones(len(relative)), _mean_decay(rate, begin, end)], axis=1)
    final, size = np.linalg.lstsq(columns, relative, rcond=None)[0].tolist()
    return _Settling(final, size, rate)


def _mean_decay(rate: Floats | float, begin: Floats | float, end: Floats | float) -> Floats:
    """Return the mean of a decay of this rate from one place to another."""
    passes = rate * (np.asarray(end) - begin)
    return np.asarray(np.exp(-rate * np.asarray(begin)) * -np.expm1(-passes) / passes)


def _swing(relative: Floats, place: Floats, middle: float | None = None) -> Iterator[_Fitted]:
    """Yield the sinusoid that leaves least, about a constant, or a line with that in its `middle`."""
    found = sinusoid_of(relative, place, _LEAST_CYCLES, middle)
    if found is None:
        return
    cycles, constants = found.cycles, found.constants

    def slopes(places: Floats) -> Floats:
        columns = swing_basis(places, cycles, middle)
        by_cycles = 2.0 * np.pi * places * (constants[2] * columns[:, 1] - constants[1] * columns[:, 2])
        return np.column_stack([columns, by_cycles])

    def curve(places: Floats) -> Floats:
        return np.asarray(swing_basis(places, cycles, middle) @ constants)

    about = float(constants[0])
    if middle is None:
        yield _Fitted(curve, slopes, about, cycles=cycles)
    else:  # in another record a swing goes on where it is, and a line begins again
        yield _Fitted(curve, slopes, about, left=_LEFT_OF_TWO)
