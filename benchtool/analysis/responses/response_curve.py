"""A number of a frequency response along its frequencies, with errors: where it passes a level, its greatest.

A response with errors first falls to a level too early, and its greatest value is too great. Both are read
off local fits: a parabola over as many neighbouring frequencies as it describes within their errors,
shortened so that hardly any bias is left. Where one does not even follow the five nearest, or they are far
apart, the reciprocals of the response tell its course between two frequencies.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.numbers import raw
from benchtool.analysis.responses.estimated_response import NEPER_DB, decibels, without_jumps
from benchtool.analysis.responses.local_parabola import LocalParabola
from benchtool.analysis.responses.local_reciprocal import LocalReciprocal
from benchtool.analysis.steps.noisy_curve import NoisyCurve

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]
Course = Callable[[int, Floats], tuple[Floats, Floats]]
"""Values and their standard uncertainties at frequencies between the one before an index and that."""

_FEWEST = 2  # neighbours to either side of a local fit
_MISSED = 3  # longer fits in a row that by chance do not describe their points
_LONGER = 1.5
_LEFT_OF_CHANGE = 0.5  # what a parabola leaves out grows as the cube of its reach: 1 / (1.5^3 - 1) is left
_MOST_UNCERTAIN = 0.2  # of a frequency: beyond this standard uncertainty it is undefined
_CLEAR = 3.0  # standard uncertainties of a smooth value beyond which it is off a level
_REACH = 0.7  # of the frequency: a local fit goes at most so far to either side
_FAR = 0.04  # of the frequency, from the neighbour below to that above
_SURE = 0.25  # of the smallest movement that matters: what is left of the error of a smooth curve
_MOST_SMOOTHED = 8  # a smoothing window is at most this part of the frequencies
_HOLE, _OF_A_HOLE = 4.0, 0.5  # of the distances beside it; of the frequency below
_FINE, _FINER = 100, 2  # places between two frequencies, and between two of these
_OF_A_CUBIC, _FEWEST_OF_SCATTER = 4, 20  # neighbours that leave one free; values that tell their scatter
_OF_MEDIAN = 1.0 / 0.4549  # mean square over median square, of normal values
_VERTICES = 2  # fits, each about the vertex of the one before
_NEPER_OF_POWER_DB = 10.0 / math.log(10.0)
_DRAWS = 80
_SEED = 19_870_201
_MOST_UNEQUAL = 1e4  # ratio of the greatest error to the least, beyond which neither matters
_LEAST_ERROR = 1e-9  # of the values: least error, so that a fit of exact values has weights


@dataclass(frozen=True)
class Point:
    """A frequency and its standard uncertainty; nan if it is below the frequencies used."""

    frequency_Hz: float
    standard_Hz: float

    @property
    def undefined_because(self) -> str:
        """Reason why it is undefined; empty if it is defined."""
        if math.isnan(self.standard_Hz):
            return (
                f"it is passed at {raw(self.frequency_Hz, 4)} Hz already, the lowest frequency that is "
                f"accurate enough: play lower ones, and let the stimulus begin and end at rest"
            )
        if self.standard_Hz > _MOST_UNCERTAIN * self.frequency_Hz:
            return (
                f"the errors do not determine whether or where, near {raw(self.frequency_Hz, 2)} Hz: raise "
                f"the stimulus"
            )
        return ""


@dataclass(frozen=True)
class ResponseCurve:
    """Values at rising frequencies, all of shape (n,), with the standard uncertainty of each, uncorrelated.

    `movement` is what counts as a small change of the values, and `between` their course where no parabola
    follows five of them.
    """

    frequency_Hz: Floats
    values: Floats
    error: Floats
    movement: float
    between: Course | None = None

    @classmethod
    def of_gain(
        cls,
        frequency_Hz: Floats,
        response: Complex,
        error: Floats,
        movement_dB: float,
        shared: Floats | None = None,
    ) -> ResponseCurve:
        """Return the gain in dB of a response and its relative errors, all of shape (n,), so many of which
        tell as much as one."""
        reciprocal = LocalReciprocal(frequency_Hz, 1.0 / response, error, shared)

        def between(at: int, fine_Hz: Floats) -> tuple[Floats, Floats]:
            found, relative = reciprocal.between(at, fine_Hz)
            return -decibels(found), NEPER_DB * relative

        return cls(frequency_Hz, decibels(response), NEPER_DB * error, movement_dB, between)

    @classmethod
    def of_phase(
        cls,
        frequency_Hz: Floats,
        response: Complex,
        error: Floats,
        movement_rad: float,
        shared: Floats | None = None,
        *,
        turns: int = 0,
    ) -> ResponseCurve:
        """Return the phase of a response, without jumps, and its errors, all of shape (n,), so many of which
        tell as much as one.

        The first is within half a turn of so many `turns`.
        """
        reciprocal = LocalReciprocal(frequency_Hz, 1.0 / response, error, shared)
        phase = without_jumps(frequency_Hz, response) + 2.0 * np.pi * turns

        def between(at: int, fine_Hz: Floats) -> tuple[Floats, Floats]:
            found, relative = reciprocal.between(at, fine_Hz)
            along = np.interp(fine_Hz, frequency_Hz, phase)
            return along - np.angle(found * np.exp(1j * along)), relative

        return cls(frequency_Hz, phase, error, movement_rad, between)

    def falls_to(self, level: float, level_error: float = 0.0) -> Point | None:
        """Return the lowest frequency at which the values are down at a level; None if they stay above.

        The standard uncertainty is that of the fit and of the level, over the slope, what a longer window
        changes, and how far apart the errors let the first and the last crossing be; nan where the values are
        below from the first on, infinite where neither they nor the local fit are clearly below anywhere, or
        are first so behind a hole.
        """
        smooth = self.smooth
        below = smooth <= level
        if not np.any(below):
            return None
        at = int(np.argmax(below))
        if at == 0:
            return Point(float(self.frequency_Hz[0]), math.nan)
        clear = np.flatnonzero(self._clearly_below(level)[at:])
        if len(clear) == 0 or self._holes[at - 1]:
            return Point(float(self.frequency_Hz[at]), math.inf)
        found = self._crossing(at, level, level_error)
        # the errors may have raised values to the level up to where they are clearly below
        last_above = int(np.flatnonzero(smooth[: at + int(clear[0])] > level)[-1])
        if (again := self._crossing(last_above + 1, level, level_error)) != found:
            found = _anywhere_between(found, again)
        lowest_Hz = float(self.frequency_Hz[0])
        return found if found.frequency_Hz > lowest_Hz else Point(lowest_Hz, math.nan)

    def rises_again_to(self, level: float) -> float | None:
        """Return the lowest frequency at which values are clearly above a level that they were clearly below
        before; None where they stay below."""
        below = np.flatnonzero(self._clearly_below(level))
        upside_down = ResponseCurve(self.frequency_Hz, -self.values, self.error, self.movement)
        above = np.flatnonzero(upside_down._clearly_below(-level))
        again = above[above > below[0]] if len(below) else below
        return float(self.frequency_Hz[again[0]]) if len(again) else None

    def _clearly_below(self, level: float) -> NDArray[np.bool_]:
        """Return which of the values are below a level by more than errors of many values explain: together
        with the next one, as single values are by chance."""
        weights = 1.0 / np.square(self._smooth_error)
        both = weights[:-1] + weights[1:]
        mean = (weights[:-1] * self.smooth[:-1] + weights[1:] * self.smooth[1:]) / both
        below = (mean < level - _CLEAR / np.sqrt(both)) & (self.smooth[:-1] < level)
        last = self.smooth[-1] < level - _CLEAR * self._smooth_error[-1]
        return np.append(below, last)

    def _crossing(self, at: int, level: float, level_error: float) -> Point:
        """Return where the values fall to a level, by a local fit about where the smooth ones do before
        `at`."""
        before, after = self.smooth[at - 1 : at + 1].tolist()
        low_Hz, high_Hz = self.frequency_Hz[at - 1 : at + 1].tolist()
        start_Hz = low_Hz + (before - level) / (before - after) * (high_Hz - low_Hz)
        short, long = self._fits(start_Hz)
        if short is long and short.bridges and (found := self._between(at, level, level_error)):
            return found
        place, standard = short.zero(level)
        other, _ = long.zero(level)
        # of many values that are hardly below a level some are clearly so by chance: their fit is not
        if not math.isfinite(place) or max(fit.most_below(level, place) for fit in (short, long)) < _CLEAR:
            return Point(start_Hz, math.inf)
        changed = _LEFT_OF_CHANGE * (other - place) if math.isfinite(other) else 0.0
        slope = abs(short.slope_at(place))
        bent = float(short.left_out(place)) / slope
        spread = math.hypot(standard, level_error / slope, changed, bent)
        return Point(start_Hz * (1.0 + place), start_Hz * spread)

    def _between(self, at: int, level: float, level_error: float) -> Point | None:
        """Return where the course between the values falls to a level before `at`; None where it does not."""
        if self.between is None:
            return None
        low_Hz, high_Hz = self.frequency_Hz[at - 1 : at + 1].tolist()
        for _ in range(_FINER):
            fine_Hz = np.linspace(low_Hz, high_Hz, _FINE)
            values, errors = self.between(at, fine_Hz)
            passed = np.flatnonzero((values[:-1] > level) & (values[1:] <= level))
            if len(passed) == 0:
                return None
            before = int(passed[0])
            low_Hz, high_Hz = fine_Hz[before : before + 2].tolist()
        slope = float(values[before] - values[before + 1]) / (high_Hz - low_Hz)
        found_Hz = low_Hz + float(values[before] - level) / slope
        return Point(found_Hz, math.hypot(float(errors[before]), level_error) / slope)

    def at(self, frequency_Hz: float) -> tuple[float, float]:
        """Return the value at a frequency and its standard uncertainty."""
        short, long = self._fits(frequency_Hz)
        if short is not long or not short.bridges or self.between is None:
            return short.level, math.hypot(short.standard, long.level - short.level)
        values, errors = self.between(self._after(frequency_Hz), np.array([frequency_Hz]))
        return float(values[0]), float(errors[0])

    def slope_at(self, frequency_Hz: float) -> float:
        """Return the change of the values per Hz."""
        short, long = self._fits(frequency_Hz)
        if short is not long or not short.bridges or self.between is None:
            return short.slope_at(0.0) / frequency_Hz
        at = self._after(frequency_Hz)
        low_Hz, high_Hz = self.frequency_Hz[at - 1 : at + 1].tolist()
        near_Hz = frequency_Hz + (high_Hz - low_Hz) / _FINE * np.array([-0.5, 0.5])
        values, _ = self.between(at, near_Hz)
        return float(np.diff(values)[0] / np.diff(near_Hz)[0])

    def _after(self, frequency_Hz: float) -> int:
        """Return the first index from a frequency on, at least 1."""
        return min(max(1, int(np.searchsorted(self.frequency_Hz, frequency_Hz))), len(self.frequency_Hz) - 1)

    def resonance(self) -> tuple[float, float]:
        """Return the greatest of values in dB and its standard uncertainty, by the resonance about it;
        without one, `greatest`. Between few frequencies a lower crest may be the top of a higher resonance.
        Beside a hole the uncertainty is infinite.
        """
        found, standard = self._resonance()
        top = int(np.argmax(self.smooth))
        if np.any(self._holes[max(0, top - 1) : top + 1]):
            return found, math.inf
        if self.between is None:
            return found, standard
        for crest in self._crests():
            height, height_error = self._greatest_between(crest, self.between)
            if height > found:
                found, standard = height, height_error
            else:
                standard = max(standard, height + height_error - found)
        return found, standard

    def _crests(self) -> list[int]:
        """Return where values clearly above both of their neighbours, these far from them, are not the
        greatest."""
        values, error = self.values, _CLEAR * self.error
        above = values[1:-1] - error[1:-1] > np.maximum(values[:-2] + error[:-2], values[2:] + error[2:])
        is_far = self.frequency_Hz[2:] - self.frequency_Hz[:-2] > _FAR * self.frequency_Hz[1:-1]
        top = int(np.argmax(self.smooth))
        return [at for at in (1 + np.flatnonzero(above & is_far)).tolist() if at != top]

    def _resonance(self) -> tuple[float, float]:
        """Return the greatest of values in dB and its standard uncertainty, by the resonance about it.

        The inverse square of the gain of two poles is a parabola of the square of frequency: its least value,
        of as many neighbours as it describes within their errors, shortened. Of all of them none is picked
        because its error is large.
        """
        top = int(np.argmax(self.smooth))
        if not 0 < top < len(self.smooth) - 1:
            return self.greatest()
        place = self.frequency_Hz**2
        near = np.abs(place / place[top] - 1.0) <= _REACH  # beyond it the inverse square grows without bound
        square = _of_inverse_square(
            place[near], self.values[near] - self.smooth[top], self.error[near], float(place[top])
        )
        # of several alike the top is one that errors have raised, by its own, the greatest of so many
        own, greatest = float(self._smooth_error[top]), self.greatest()
        raised = max(0.0, min(float(self.smooth[top]) - greatest[0], own * self._greatest_error))
        is_followed = len(square.values) > 2 * _FEWEST and square._is_followed(float(place[top]))
        if not is_followed and self.between is not None:
            found, standard = self._greatest_between(top, self.between)
            return found - raised, standard
        vertex = square.least_near(float(place[top])) if is_followed else None
        if vertex is None:
            return greatest
        least, standard, by_place, within = vertex
        standard, by_place = (_NEPER_OF_POWER_DB * each / least for each in (standard, by_place))
        # a least-squares fit has as much of the error of one of its values as their variances are alike,
        # and none where all that may be the greatest are in it: those that are not are as much too low
        peak = float(self.smooth[top]) - 10.0 * math.log10(least)
        share = min(1.0, (standard / own) ** 2) * self._is_greatest_beyond(np.sqrt(within), peak)
        return peak - max(0.0, share * raised - by_place), standard

    @property
    def _greatest_error(self) -> float:
        """What the greatest of so many normal errors is at most on average, in standard deviations."""
        return math.sqrt(2.0 * math.log(len(self.values)))

    def _is_followed(self, frequency_Hz: float) -> bool:
        """Return whether a parabola follows the values about a frequency."""
        short, long = self._fits(frequency_Hz)
        return short is not long or not short.misses

    def _greatest_between(self, top: int, course: Course) -> tuple[float, float]:
        """Return the greatest value of the course between the neighbours of `top`, and its standard
        uncertainty."""
        found = []
        for at in (top, top + 1):
            low_Hz, high_Hz = self.frequency_Hz[at - 1 : at + 1].tolist()
            for _ in range(_FINER):
                fine_Hz = np.linspace(low_Hz, high_Hz, _FINE)
                values, errors = course(at, fine_Hz)
                place = int(np.argmax(values))
                low_Hz, high_Hz = fine_Hz[[max(0, place - 1), min(place + 1, _FINE - 1)]].tolist()
            found.append((float(values[place]), float(errors[place])))
        return max(found)

    def _is_greatest_beyond(self, between_Hz: Floats, peak: float) -> float:
        """Return how probable it is that the greatest of values that are a peak's at most is not between two
        frequencies."""
        at_Hz = self.frequency_Hz[np.argmax(np.minimum(self.smooth, peak) + self._drawn, axis=1)]
        return float(np.mean((at_Hz < between_Hz[0]) | (at_Hz > between_Hz[1])))

    def least_near(self, start: float) -> tuple[float, float, float, Floats] | None:
        """Return the least value near a place, its standard uncertainty, what is in it against errors that
        place it where they lower it, and between which places; None where the values of a local fit are not
        least within it, or not above zero there."""
        for _ in range(_VERTICES):
            short, long = self._fits(start)
            place = short.vertex
            if not abs(place) <= min(short.reach, _REACH):
                return None
            start *= 1.0 + place
        short, long = self._fits(start)
        place, other = short.vertex, long.vertex
        if not (abs(place) <= short.reach and abs(other) <= long.reach):
            return None
        least, by_place = short.value_at(place), short.below_by_vertex
        left = _LEFT_OF_CHANGE * (long.value_at(other) - least)
        least += by_place
        standard = math.hypot(short.error_at(place), left, short.left_out(place), by_place)
        within = start * np.array([max(0.0, 1.0 - short.reach), 1.0 + short.reach])
        return (least, standard, by_place, within) if least > _CLEAR * standard else None

    def greatest(self) -> tuple[float, float]:
        """Return the greatest value, less what the errors add to it, and its standard uncertainty."""
        return NoisyCurve(self.smooth, self._drawn).greatest()

    @cached_property
    def _drawn(self) -> Floats:
        """Errors that the smooth values may have, shape (draws, n)."""
        drawn = np.random.default_rng(_SEED).standard_normal((_DRAWS, len(self.values))) * self.error
        return np.array([_running_mean(each, self._weights, self._widths) for each in drawn])

    @cached_property
    def smooth(self) -> Floats:
        """Running means over so many neighbours that their error is small against the movement."""
        return _running_mean(self.values, self._weights, self._widths)

    @cached_property
    def _smooth_error(self) -> Floats:
        """Standard uncertainty of the smooth values, shape (n,)."""
        total, places = np.concatenate([[0.0], np.cumsum(self._weights)]), np.arange(len(self.values))
        return np.asarray(1.0 / np.sqrt(total[places + self._widths + 1] - total[places - self._widths]))

    @cached_property
    def _weights(self) -> Floats:
        least = _LEAST_ERROR * max(float(np.max(np.abs(self.values))), self.movement)
        smallest = max(float(np.min(self.error)), least)
        return 1.0 / np.clip(self.error, least, _MOST_UNEQUAL * smallest) ** 2

    @cached_property
    def _holes(self) -> NDArray[np.bool_]:
        """Whether frequencies that are not used, as where noise hides them, leave a hole between two, shape
        (n - 1,): far wider than the distances beside it."""
        wide = np.diff(self.frequency_Hz)
        beside = np.maximum(np.append(0.0, wide[:-1]), np.append(wide[1:], 0.0))
        return np.asarray((wide > _HOLE * beside) & (wide > _OF_A_HOLE * self.frequency_Hz[:-1]))

    @cached_property
    def _scatter(self) -> float:
        """Mean square by which the values scatter, over that of their errors, at least 1: by the median of
        what cubics leave of five neighbours each, of which few bend more than a cubic does."""
        count = len(self.values)
        if count < _FEWEST_OF_SCATTER:
            return 1.0
        rows = np.arange(count - _OF_A_CUBIC)[:, np.newaxis] + np.arange(_OF_A_CUBIC + 1)
        places = np.log(self.frequency_Hz)[rows]
        apart = places[:, :, np.newaxis] - places[:, np.newaxis, :] + np.eye(_OF_A_CUBIC + 1)
        of_each = 1.0 / np.prod(apart, axis=2)  # fourth divided difference
        left = np.sum(of_each * self.values[rows], axis=1) ** 2
        stated = np.sum(of_each**2 / self._weights[rows], axis=1)
        return max(1.0, _OF_MEDIAN * float(np.median(left / stated)))

    @cached_property
    def _widths(self) -> NDArray[np.int64]:
        """Neighbours to either side of each value."""
        count = len(self.values)
        widths = np.zeros(count, dtype=np.int64)
        total = np.concatenate([[0.0], np.cumsum(self._weights)])
        places = np.arange(count)
        for reach in range(1, max(1, count // _MOST_SMOOTHED) + 1):
            room = np.minimum(np.minimum(places, count - 1 - places), reach - 1)
            error = 1.0 / np.sqrt(total[places + room + 1] - total[places - room])
            widths = np.where(error > _SURE * self.movement, reach, widths)
        return np.minimum(widths, np.minimum(places, count - 1 - places))

    def _fits(self, frequency_Hz: float) -> tuple[LocalParabola, LocalParabola]:
        """Return the local fits about a frequency: the shortened one, and the longest that describes its
        points; by chance one or two do not, and are passed over where the next longer one does."""
        places = self.frequency_Hz / frequency_Hz - np.ones(len(self.frequency_Hz))
        nearest = np.argsort(np.abs(places), kind="stable")
        within = int(np.count_nonzero(np.abs(places) <= _REACH))
        found: list[LocalParabola] = []
        missed = 0
        count = 2 * _FEWEST + 1
        while count <= max(within, 2 * _FEWEST + 1) and count <= len(places):
            chosen = nearest[:count]
            fit = LocalParabola.through(
                places[chosen], self.values[chosen], self._weights[chosen], self._scatter
            )
            missed = 0 if fit.describes or not found else missed + 1
            if missed > _MISSED:
                break
            if not missed:
                found.append(fit)
            count = math.ceil(_LONGER * count)
        if not found:
            found.append(LocalParabola.through(places, self.values, self._weights, self._scatter))
        return found[max(0, len(found) - 2)], found[-1]


def _of_inverse_square(place: Floats, above_dB: Floats, error_dB: Floats, start: float) -> ResponseCurve:
    """Return the inverse squares of gains that are so much above that at a place, all of shape (n,), without
    what errors add to them on average.

    Their errors are those of a parabola that describes them: by its own an inverse square that errors lower
    would count more.
    """
    relative = error_dB / _NEPER_OF_POWER_DB
    inverse = 10.0 ** (-0.1 * above_dB) / (1.0 + 0.5 * relative**2)
    _, long = ResponseCurve(place, inverse, inverse * relative, 1.0)._fits(start)
    course = np.polynomial.polynomial.polyval(place / start - 1.0, long.coefficients)
    is_on = long.describes & (np.abs(place / start - 1.0) <= long.reach) & (course > 0.0)
    return ResponseCurve(place, inverse, np.where(is_on, course, inverse) * relative, 1.0)


def _running_mean(values: Floats, weights: Floats, widths: NDArray[np.int64]) -> Floats:
    places = np.arange(len(values))
    above = np.concatenate([[0.0], np.cumsum(values * weights)])
    below = np.concatenate([[0.0], np.cumsum(weights)])
    first, last = places - widths, places + widths + 1
    return np.asarray((above[last] - above[first]) / (below[last] - below[first]), dtype=np.float64)


def _anywhere_between(first: Point, last: Point) -> Point:
    """Return a place that the errors leave open between two, as likely at any frequency between them; of two
    that are too far apart nothing is known."""
    apart_Hz = last.frequency_Hz - first.frequency_Hz
    of_both_Hz = math.sqrt(0.5 * (first.standard_Hz**2 + last.standard_Hz**2))
    is_far = apart_Hz > _MOST_UNCERTAIN * first.frequency_Hz
    standard_Hz = math.inf if is_far else math.hypot(of_both_Hz, apart_Hz / math.sqrt(12.0))
    return Point(first.frequency_Hz + 0.5 * apart_Hz, standard_Hz)
