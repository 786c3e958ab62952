"""Uncertainty of the mean, the extremes and the rms of samples from where a signal has arrived.

There it has come near its level and is still on its way. That course is the same in every record and no
scatter: what is uncertain is the noise about it, the step of a converter, and in which row the samples begin.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import least_odds
from benchtool.analysis.quantisation.read_noise import noise_of_readings, without_far
from benchtool.analysis.quantisation.repeated_steps import noise_beside
from benchtool.analysis.statistics.clicks import KnownClicks, clicks_apart
from benchtool.analysis.statistics.excesses import scatter_of_largest
from benchtool.analysis.statistics.maxima import is_no_heavier_than_normal, scatter_of_largest_of_normal
from benchtool.analysis.statistics.scatter import error_of_record, error_of_series
from benchtool.analysis.statistics.tail import tail_index, tail_indices_of_heavy
from benchtool.analysis.steps.arrival import (
    away_from_level,
    left_in_course,
    noise_on_the_way,
    places_to_begin,
    row_at_rest,
    slopes_in_time,
)
from benchtool.analysis.steps.bursts import LOUD
from benchtool.analysis.steps.converter_levels import left_beside_a_line, left_on_a_course
from benchtool.analysis.steps.noisy_curve import NoisyCurve, left_of_steps
from benchtool.analysis.steps.passages import Instant
from benchtool.analysis.steps.slopes import Slope, are_along_a_line
from benchtool.analysis.steps.smoothing import Noise, UnevenNoise, without_a_line
from benchtool.analysis.steps.tails import Tail
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined_by_names

Floats = NDArray[np.float64]
Side = Callable[[Floats], Floats]
"""From where the greatest of values is looked for: as they are, from below, or by their magnitude."""

_FEWEST_SAMPLES = 20  # whose scatter says something
_FEWEST_MAXIMA = 4
_SEED, _DRAWS, _FEWEST_DRAWS = 20_261_123, 80, 20
_MOST_VALUES = 1 << 22  # of all draws together, 32 MiB
_FAR = 3.0  # standard deviations by which a value may be greater
_STEEPER = 2.0  # times the slope after an instant: that before it, where it is on no edge
_OF_TAIL, _OF_HEAVY_TAIL = 40, 10  # one sample in so many is of the tail, or of one known to be heavy
_LARGEST = 20  # deviations that tell whether both tails are alike
_OF_COURSE = 0.3  # at least, of what noise makes of its product: of few rows it is not told from noise
_OF_LEFT = 10  # draws of what noise leaves in a course, over which its square is averaged
_UNIFORM = 1.0 / math.sqrt(12.0)  # standard deviation over width
_OF_SQUARE = 1.0 / math.sqrt(80.0)  # rms of the square of a uniform error within a half to either side
_OF_SHAPE = 0.4  # of that, where noise hides the steps, whose distribution is not known
_ON_THE_WAY = "noise of the samples on their way"
_TIMES = "times of the samples, which scatter"


@dataclass(frozen=True)
class ArrivedSamples:
    """Of `samples` those from row `first` on, `values` of shape (n,), and their `course`, to which noise is
    added: the smooth curve while they are on their way, and their mean at rest, of which there are the last
    `at_rest`.

    `noise` is that about the course, but for that `on_the_way` where this is another than at rest; `step` is
    that of a converter, of whose errors `left` is the standard uncertainty of the mean, and which adds
    `added` to the mean square at rest. Of shape (n,) are
    `of_course`, the standard deviation of what noise has left in the course, `of_rest`, how much of the noise
    that leaves about it, and `of_times`, the standard deviation of each value because its time is not known.
    `course_errors`, shape (draws, n), is what noise may have left in it, 0 at rest.
    `rows`, shape (rows,), are those in which they may as well begin, moved by noise or not, and `shares` how
    likely each is. A few `clicks` of the record may be in any of its rows.
    """

    samples: Floats
    first: int
    course: Floats
    of_course: Floats
    course_errors: Floats
    of_rest: Floats
    of_times: Floats
    rows: NDArray[np.int64]
    is_moved_by_noise: bool
    shares: Floats
    at_rest: int
    noise: Noise
    step: float
    left: float
    added: float = 0.0
    on_the_way: UnevenNoise | None = None
    beside: tuple[Floats, ...] = ()
    clicks: KnownClicks | None = None

    @classmethod
    def of(
        cls,
        samples: Floats,
        curve: NoisyCurve,
        begin: Instant,
        band: float,
        noise: Noise,
        step: float,
        event: int = 0,
        drift: Slope | None = None,
        beside: tuple[Floats, ...] = (),
    ) -> ArrivedSamples:
        """Return those of samples, shape (n,), from the instant `begin` on, after an event in some row.

        They are at rest long after the smooth `curve` has entered a `band` about its last level for good. If
        these are enough, their noise stands for `noise`, that of samples at rest elsewhere; where a `drift`
        goes on in them, or none is certain before and they show one by themselves, they are about a line, and
        where the slowest tail of the answer goes on, about that.
        `step` is that of a converter, 0 without one.
        """
        end = len(samples)
        first = min(math.ceil(begin.place), end)
        course = curve.values[:end].copy()
        rest, drifts = row_at_rest(course, first, band, noise.rms, event), False
        if drift is not None:
            along = row_at_rest(course - drift.value * np.arange(end), first, band, noise.rms, event)
            if drift.goes_on_in(samples[along:]):
                rest, drifts = along, True
        else:
            drifts = are_along_a_line(samples[rest:])
        noise_alone, added = noise_beside(noise.rms**2, step), 0.0
        if end - rest < _FEWEST_SAMPLES:
            rest = end
        else:
            settled = samples[rest:]
            about = settled - without_a_line(settled) if drifts else None
            if about is None:
                about = Tail.of(away_from_level(course, first), band).goes_on_in(settled, rest)
            course[rest:] = np.mean(settled) if about is None else about
            elsewhere, noise = noise.rms, Noise.of(settled - course[rest:])
            if about is None:
                noise_alone = noise_of_readings(settled, step)
                added = max(0.0, float(np.var(without_far(settled, step))) - noise_alone**2)
            if not noise.rms < LOUD * elsewhere < LOUD**2 * noise.rms:
                beside = ()
            elif drifts:
                beside = tuple(without_a_line(each) for each in beside)
        on_the_way = noise_on_the_way(curve.uneven, noise, first, rest)
        rms: float | Floats = noise.rms
        if on_the_way is not None:
            rms = np.concatenate([on_the_way.rms, np.full(end - max(first, rest), noise.rms)])
        of_course = left_in_course(curve.errors[:, first:end], rms, begin)
        of_rest = np.ones(end - first) if curve.beside is None else np.minimum(curve.beside[first:end], 1.0)
        of_course[rest - first :], of_rest[rest - first :] = 0.0, 1.0
        course_errors = curve.errors[:_OF_LEFT, first:end].copy()
        course_errors[:, rest - first :] = 0.0
        of_times = np.zeros(end)
        of_times[:rest] = curve.time_scatter * slopes_in_time(curve.values[:end], curve.time_scatter)[:rest]
        places = np.clip(np.ceil(places_to_begin(begin)), 0, max(0, end - 1)).astype(np.int64)
        rows, counts = np.unique(places, return_counts=True)
        left = left_of_steps(noise_alone, step)
        if rest < end:
            left = max(left * left_on_a_course(course[rest:], step), left_beside_a_line(samples[rest:], step))
        return cls(
            samples=samples,
            first=first,
            course=course[first:],
            of_course=of_course,
            course_errors=course_errors,
            of_rest=of_rest,
            of_times=of_times[first:],
            rows=rows,
            is_moved_by_noise=len(begin.drawn) > 0 and not curve.is_on_levels,
            shares=counts / len(places),
            at_rest=end - rest,
            noise=noise,
            step=step,
            left=left,
            added=added,
            on_the_way=on_the_way,
            beside=beside,
        )

    @property
    def values(self) -> Floats:
        """Samples from the first row on, shape (n,)."""
        return self.samples[self.first :]

    @property
    def rms(self) -> float:
        """Root mean square of the values, without what the steps of a converter add to their scatter."""
        square = _rms(self.values) ** 2 - self.added * self.at_rest / len(self.values)
        return math.sqrt(max(0.0, square))

    def of_mean(self) -> Uncertainty | None:
        """Return the uncertainty of the mean."""
        of_times = float(np.sqrt(np.sum(self.of_times**2))) / len(self.values)
        noise = [self._of_mean(), *self._of_mean_on_the_way(), Contribution(_TIMES, "A", of_times)]
        return _combined(noise, self._of_rows(self.rows, lambda each: float(np.mean(each))), self.left)

    def of_greatest(self, side: Side = np.positive) -> Uncertainty | None:
        """Return the scatter of the greatest of the values, seen from a side, over records like this one."""
        name = "distribution of the extremes of such samples"
        noise = [
            Contribution(name, "A", self._scatter_of_greatest(side)),
            self._of_mean(),
            *self._of_mean_on_the_way(),
            Contribution(_TIMES, "A", self._of_greatest_in_time(side)),
        ]
        # noise that moves the instant moves the samples there as much, to the level that it is defined by
        rows = np.clip(self.rows, self.first - 1, self.first + 1) if self.is_moved_by_noise else self.rows
        begun = self._of_rows(rows, lambda each: float(np.max(side(each))))
        return _combined(noise, begun, _UNIFORM * self.step)

    def of_least(self) -> Uncertainty | None:
        """Return the scatter of the least value over records like this one."""
        return self.of_greatest(np.negative)

    def of_magnitude(self) -> Uncertainty | None:
        """Return the scatter of the greatest magnitude over records like this one."""
        return self.of_greatest(np.abs)

    def of_rms(self) -> Uncertainty | None:
        """Return the uncertainty of the root mean square."""
        rms = self.rms
        if not rms > 0.0:
            return _combined([], self._of_rows(self.rows, _rms), _UNIFORM * self.step)
        of_power = self._of_power(rms)
        noise = [
            of_power,
            Contribution(_ON_THE_WAY, "A", self._of_rms_on_the_way(rms)),
            Contribution(_TIMES, "A", self._of_times(rms)),
        ]
        if far := self._of_one_far(rms, of_power.standard):
            noise.append(Contribution("one sample far from the others, or none", "A", far))
        # steps that noise does not hide add a power of their own, and move all samples on one level together
        untold = max(_OF_SHAPE, self.left / (_UNIFORM * self.step)) if self.step else 0.0
        power = untold * _OF_SQUARE * self.step**2 / (2.0 * rms)
        steps = math.hypot(power, float(np.mean(self.values)) / rms * self.left)
        return _combined(noise, self._of_rows(self.rows, _rms), min(steps, _UNIFORM * self.step))

    def _of_mean(self) -> Contribution:
        if not self.at_rest:
            of_mean = 0.0 if self.on_the_way is not None else self.noise.of_mean(len(self.values))
            return Contribution("noise of the samples", "A", of_mean)
        name, settled = "scatter over parts of the samples, and their correlation", self._at_rest
        error = error_of_record(settled, self.beside)
        if math.isfinite(error.standard):
            return error.line(name, self._share)
        name = "scatter of the samples, too few of which are independent for that of a mean"
        return Contribution(name, "A", float(np.std(settled)))

    def _of_mean_on_the_way(self) -> list[Contribution]:
        """Return what noise makes of the mean that the samples at rest do not have."""
        if self.on_the_way is None:
            return []
        weights = np.full(len(self.on_the_way.levels), 1.0 / len(self.values))
        return [Contribution(_ON_THE_WAY, "A", self.on_the_way.of_sum(weights))]

    def _of_power(self, rms: float) -> Contribution:
        name = "scatter of their squares over parts of the samples"
        if not self.at_rest:
            square = 0.0 if self.on_the_way is not None else self.noise.of_mean_square(len(self.values))
            return Contribution(name, "A", square / (2.0 * rms))
        squares = (self._settled if self._is_level else self._at_rest) ** 2
        error = error_of_record(squares)
        standard = error.standard if math.isfinite(error.standard) else float(np.std(squares))
        return Contribution(name, "A", self._share * standard / (2.0 * rms), error.dof)

    def _of_rms_on_the_way(self, rms: float) -> float:
        """Return what noise makes of the root mean square by the course, without what the noise that is left
        in the course would make of it: with itself it is a power, and no product."""
        scale = rms * len(self.values)
        if self.on_the_way is not None:
            way = slice(len(self.values) - self.at_rest)
            power = self.on_the_way.of_sum_of_squares() / (2.0 * scale)
            return math.hypot(self._of_product(self.on_the_way.of_sum, way) / scale, power)
        # what moves the instant leaves the samples there at the level that it is defined by
        of_sum = self.noise.of_sum_after_first if self.is_moved_by_noise else self.noise.of_sum
        moving = slice(len(self.values) - (self.at_rest if self._is_level else 0))
        return self._of_product(of_sum, moving) / scale

    def _of_product(self, of_sum: Callable[[Floats], float], rows: slice) -> float:
        """Return the standard deviation of the sum of noise times the course in some rows."""
        product, of_noise = of_sum(self.course[rows]), self.course_errors[:, rows]
        left = float(np.mean([of_sum(each) ** 2 for each in of_noise])) if len(of_noise) else 0.0
        return max(_OF_COURSE * product, math.sqrt(max(0.0, product**2 - left)))

    def _scatter_of_greatest(self, side: Side) -> float:
        again = side(self._drawn_again)
        tops = np.argmax(again, axis=1)
        greatest = again[np.arange(len(again)), tops]
        course = side(self.course)
        deviations = side(self.values) - course
        # draws of heavy noise have nothing larger than the samples that they are made of
        larger = self._of_level(deviations, side) if self._is_heavy else 0.0
        # where the largest deviation would make it the greatest, as that mostly is
        open_to = course + np.max(deviations) + larger >= np.median(greatest)
        # of few rows those at rest draw enough others
        are_few = np.count_nonzero(open_to) * _FEWEST_SAMPLES <= self.at_rest
        is_level = self._is_heavy or (self.at_rest and not are_few)
        if self.on_the_way is not None:  # on no level, with noise of its own
            open_to[: len(self.on_the_way.levels)] = False
        if self._has_clicks_alone:
            open_to &= ~self._is_click
        on_a_level = self._of_level(deviations[open_to], side) if is_level else 0.0
        of_clicks = 0.0
        if self.clicks is not None:
            rest = side(self.values[~self._is_click])
            of_clicks = self.clicks.scatter_of_greatest(side, side(self.course), rest)
        return max(on_a_level, of_clicks, math.hypot(float(np.std(greatest)), _rms(self.of_course[tops])))

    def _of_level(self, deviations: Floats, side: Side) -> float:
        """Return the scatter of the largest of deviations, shape (n,), on one level."""
        if len(deviations) < _FEWEST_SAMPLES:
            return 0.0
        if self._is_heavy:
            tails = tail_indices_of_heavy(deviations, _OF_HEAVY_TAIL)
        else:
            tails = (tail_index(deviations, _OF_TAIL),)
        maxima = _maxima(deviations)
        scatter = scatter_of_largest(maxima, *tails)
        if self._is_heavy:
            alike = _alike(deviations)
            of_both = scatter_of_largest(_maxima(np.abs(deviations)), *tails)
            scatter = math.sqrt((1.0 - alike) * scatter**2 + alike * of_both**2)
        rest = slice(-self.at_rest, None)  # all of them where none are at rest
        if not any(tails) and is_no_heavier_than_normal(self.values[rest] - self.course[rest]):
            return min(scatter, scatter_of_largest_of_normal(maxima, self.noise.rms))
        known = side(self.values[rest]) - side(self.course[rest])
        if self._is_heavy and (clicks := clicks_apart(known, self.step)) is not None:
            of_clicks = clicks.scatter_of_largest(len(deviations) / len(known))
            tail = 1.0 - clicks.probability
            return math.sqrt(tail * scatter**2 + clicks.probability * of_clicks**2)
        return scatter

    @cached_property
    def _drawn_again(self) -> Floats:
        """The course, shape (draws, n), and from where on noise as it is at rest, or elsewhere, meets it."""
        random, count = np.random.default_rng(_SEED), len(self.course)
        draws = max(_FEWEST_DRAWS, min(_DRAWS, _MOST_VALUES // count))
        if self.at_rest:
            noise = np.resize(self._at_rest, count)
            begins = random.integers(0, count, draws).tolist()
            drawn = np.array([np.roll(noise, begin) for begin in begins])
            if self._is_heavy:  # what is far on one side may as well be on the other
                drawn[random.random(draws) < 0.5 * _alike(noise)] *= -1.0
        else:
            drawn = self.noise.draw(random, (draws, count))
        if self.on_the_way is not None:
            drawn[:, : len(self.on_the_way.levels)] = self.on_the_way.draw(random, draws)
        return np.asarray(self.course + self.of_rest * drawn)

    def _of_one_far(self, rms: float, of_power: float) -> float:
        """Return by how much the root mean square is more with the greatest magnitude as much greater as that
        scatters: of heavy tails one sample makes much of it, and most records lack that. Of known clicks it
        is what their squares scatter by, beyond the scatter `of_power` of those here."""
        far, clicks = 0.0, 0.0
        if self._is_heavy:
            greatest, scatter = float(np.max(np.abs(self.values))), self._scatter_of_greatest(np.abs)
            far = (greatest + 0.5 * scatter) * scatter
        if self.clicks is not None:
            clicks = 0.5 * self.clicks.scatter_of_sum_of_squares(len(self.values))
        scale = len(self.values) * rms
        return max(far / scale, math.sqrt(max(0.0, (clicks / scale) ** 2 - of_power**2)))

    @property
    def _is_heavy(self) -> bool:
        """Whether the tails of the noise are heavier than normal ones, and not by known clicks alone."""
        return self.noise.innovations is not None and not self._has_clicks_alone

    @cached_property
    def _has_clicks_alone(self) -> bool:
        """Whether clicks, enough to tell their size, are all that is far from the others at rest."""
        if self.clicks is None or not self.clicks.tell_their_size or not self.at_rest:
            return False
        return Noise.of(self._at_rest[~self._is_click[-self.at_rest :]]).innovations is None

    @cached_property
    def _is_click(self) -> NDArray[np.bool_]:
        """Which of the values are known clicks, shape (n,)."""
        places = () if self.clicks is None else self.clicks.places
        return np.isin(np.arange(self.first, len(self.samples)), places)

    def _of_greatest_in_time(self, side: Side) -> float:
        """Return the rms change of the greatest of the values, seen from a side, with other times of the
        rows."""
        if not np.any(self.of_times):
            return 0.0
        values, far = side(self.values), _FAR * self.of_times
        near = np.flatnonzero(values + far >= np.max(values - far))
        moved = np.random.default_rng(_SEED).standard_normal((_DRAWS, len(near))) * self.of_times[near]
        return _rms(np.max(side(self.values[near] + moved), axis=1) - np.max(values))

    def _of_times(self, rms: float) -> float:
        return float(np.sqrt(np.sum((self.course * self.of_times) ** 2))) / (rms * len(self.values))

    @property
    def _settled(self) -> Floats:
        return self.values[-self.at_rest :]

    @property
    def _is_level(self) -> bool:
        """Whether the course of the samples at rest is one level."""
        return bool(np.all(self.course[-self.at_rest :] == self.course[-1]))

    @property
    def _at_rest(self) -> Floats:
        """Noise of the samples at rest, about their course."""
        return self._settled - self.course[-self.at_rest :]

    @property
    def _share(self) -> float:
        """By how much the mean of all samples scatters less than that of those at rest: of white noise by the
        root of their numbers, of the slowest not at all."""
        if self.on_the_way is not None:
            return self.at_rest / len(self.values)
        least = math.sqrt(min(1.0, self.at_rest / len(self.values)))
        of_rest = self.noise.of_mean(self.at_rest)
        return max(least, min(1.0, self.noise.of_mean(len(self.values)) / of_rest)) if of_rest else least

    def _of_rows(self, rows: NDArray[np.int64], of: Callable[[Floats], float]) -> float:
        """Return the rms change of a number of the values where they begin in other rows, as likely as each
        is. Noise that moves the instant ahead of an edge moves the samples there as much: they are no further
        away than the course after it is steep, and noise."""
        found, samples = of(self.values), self.samples
        if self.is_moved_by_noise and len(self.course) > 1 and not np.any(self.of_times):
            ahead = np.arange(self.first, 0, -1.0)
            rms = self.noise.rms if self.on_the_way is None else float(self.on_the_way.rms[0])
            reach = _STEEPER * abs(float(self.course[1] - self.course[0])) * ahead + rms
            level = float(self.values[0])
            before = np.clip(samples[: self.first], level - reach, level + reach)
            samples = np.concatenate([before, self.values])
        moved = np.array([of(samples[row:]) - found for row in rows.tolist()])
        return math.sqrt(float(self.shares @ moved**2))


def _combined(noise: list[Contribution], begun: float, steps: float) -> Uncertainty | None:
    row = Contribution("row of the first of the samples", "B", begun)
    lines = [*noise, row, Contribution("step of a converter", "B", abs(steps))]
    return combined_by_names([each for each in lines if each.standard != 0.0] or [row])


def _alike(deviations: Floats) -> float:
    """Return how probable it is that the tails of deviations about zero, shape (n,), are alike on both sides:
    by how many of the largest are on the side of fewer, whose number is binomial then."""
    largest = deviations[np.argsort(np.abs(deviations))[-_LARGEST:]]
    fewer = min(int(np.count_nonzero(largest > 0.0)), int(np.count_nonzero(largest < 0.0)))
    ways = sum(math.comb(len(largest), each) for each in range(fewer + 1))
    odds = least_odds(min(1.0, 2.0 * ways / 2.0 ** len(largest)))
    return odds / (1.0 + odds)


def _maxima(deviations: Floats) -> Floats:
    """Return the largest of as many deviations, shape (n,), as count as one where their size has a memory: of
    a line that scatters, the largest of a crest is one value."""
    apart = math.ceil(len(deviations) / (error_of_series(deviations**2).dof + 1.0) - 1e-9)
    if 1 < apart <= len(deviations) // _FEWEST_MAXIMA:
        return np.asarray(np.maximum.reduceat(deviations, np.arange(0, len(deviations), apart)))
    return deviations


def _rms(values: Floats) -> float:
    return math.sqrt(float(np.mean(values**2)))
