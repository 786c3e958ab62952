"""A number of a frequency response along its frequencies, with errors: where it passes a level, its greatest.

A response with errors first falls to a level too early, and its greatest value is too great. Both are read
off local fits: a parabola over as many neighbouring frequencies as it describes within their errors,
shortened so that hardly any bias is left.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.dynamics.local_cubic import NEAREST, LocalCubic
from benchtool.analysis.dynamics.local_parabola import LocalParabola
from benchtool.analysis.dynamics.noisy_curve import NoisyCurve

Floats = NDArray[np.float64]

_FEWEST = 2  # neighbours to either side of a local fit
_LONGER = 1.5
_LEFT_OF_CHANGE = 0.5  # what a parabola leaves out grows as the cube of its reach: 1 / (1.5^3 - 1) is left
_MOST_UNCERTAIN = 0.2  # of a frequency: beyond this standard uncertainty it is undefined
_CLEAR = 3.0  # standard uncertainties of a smooth value beyond which it is off a level
_REACH = 0.7  # of the frequency: a local fit goes at most so far to either side
_AT_THE_TOP = 3  # second differences: the greatest value and its neighbours
_OF_A_CUSP = 1.0 / 3.0  # of the second difference: how much higher the peak is
_OF_TWO = 2.0 * math.sqrt(2.0)  # standard deviations of a value: two of the sum of its neighbours
_SURE = 0.25  # of the smallest movement that matters: what is left of the error of a smooth curve
_MOST_SMOOTHED = 8  # a smoothing window is at most this part of the frequencies
_FINE = 200  # places between two frequencies
_OF_PARABOLA = 0.6  # of what a parabola differs by
_OF_STRAIGHT = 0.1  # of what a straight line differs by
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
                f"it is passed at {self.frequency_Hz:.4g} Hz already, the lowest frequency that is accurate "
                f"enough: play lower ones, and let the stimulus begin and end at rest"
            )
        if self.standard_Hz > _MOST_UNCERTAIN * self.frequency_Hz:
            return (
                f"the errors do not determine whether or where, near {self.frequency_Hz:.2g} Hz: raise the "
                f"stimulus"
            )
        return ""


@dataclass(frozen=True)
class ResponseCurve:
    """Values at rising frequencies, all of shape (n,), with the standard uncertainty of each, uncorrelated.

    `movement` is what counts as a small change of the values.
    """

    frequency_Hz: Floats
    values: Floats
    error: Floats
    movement: float

    def falls_to(self, level: float, level_error: float = 0.0) -> Point | None:
        """Return the lowest frequency at which the values are down at a level; None if they stay above.

        The standard uncertainty is that of the fit and of the level, over the slope, what a longer window
        changes, and how far apart the errors let the first and the last crossing be; nan where the values are
        below from the first on, infinite where they are nowhere clearly below.
        """
        smooth = self.smooth
        below = smooth <= level
        if not np.any(below):
            return None
        at = int(np.argmax(below))
        if at == 0:
            return Point(float(self.frequency_Hz[0]), math.nan)
        clear = np.flatnonzero(smooth[at:] < level - _CLEAR * self._smooth_error[at:])
        if len(clear) == 0:
            return Point(float(self.frequency_Hz[at]), math.inf)
        found = self._crossing(at, level, level_error)
        # the errors may have raised values to the level up to where they are clearly below
        last_above = int(np.flatnonzero(smooth[: at + int(clear[0])] > level)[-1])
        if (again := self._crossing(last_above + 1, level, level_error)) != found:
            apart_Hz = again.frequency_Hz - found.frequency_Hz
            found = Point(found.frequency_Hz, math.hypot(found.standard_Hz, apart_Hz))
        lowest_Hz = float(self.frequency_Hz[0])
        return found if found.frequency_Hz > lowest_Hz else Point(lowest_Hz, math.nan)

    def _crossing(self, at: int, level: float, level_error: float) -> Point:
        """Return where the values fall to a level, by a local fit about where the smooth ones do before
        `at`."""
        before, after = self.smooth[at - 1 : at + 1].tolist()
        low_Hz, high_Hz = self.frequency_Hz[at - 1 : at + 1].tolist()
        start_Hz = low_Hz + (before - level) / (before - after) * (high_Hz - low_Hz)
        short, long = self._fits(start_Hz)
        if short is long and short.bridges:
            return self._between(at, level, level_error)
        if short is long and not short.describes:
            place, spread = self._cubic(start_Hz).zero(level, level_error)
            if not math.isfinite(place):
                return Point(start_Hz, math.inf)
            return Point(start_Hz * (1.0 + place), start_Hz * spread)
        place, standard = short.zero(level)
        other, _ = long.zero(level)
        if not math.isfinite(place):
            return Point(start_Hz, math.inf)
        changed = _LEFT_OF_CHANGE * (other - place) if math.isfinite(other) else 0.0
        slope = abs(short.slope_at(place))
        bent = float(short.left_out(place)) / slope
        spread = math.hypot(standard, level_error / slope, changed, bent)
        return Point(start_Hz * (1.0 + place), start_Hz * spread)

    def _cubic(self, frequency_Hz: float) -> LocalCubic:
        """Return the cubic through the values nearest to a frequency, which no parabola follows."""
        places = self.frequency_Hz / frequency_Hz - np.ones(len(self.frequency_Hz))
        near = np.argsort(np.abs(places), kind="stable")[:NEAREST]
        return LocalCubic.through(places[near], self.values[near], self._weights[near], self._scatter)

    def _between(self, at: int, level: float, level_error: float) -> Point:
        """Return where the smooth values fall to a level before `at`, of few frequencies far apart."""
        fine = np.linspace(math.log(self.frequency_Hz[at - 1] / self.frequency_Hz[at]), 0.0, _FINE)

        def passing(curve: np.polynomial.Polynomial) -> float:
            values = curve(fine) - level
            below = int(np.argmax(values <= 0.0))
            share = values[below - 1] / (values[below - 1] - values[below])
            return float(fine[below - 1] + share * (fine[below] - fine[below - 1]))

        place, *others = (passing(curve) for curve in self._through_neighbours(at))
        slope = float(self.smooth[at - 1] - self.smooth[at]) / float(fine[-1] - fine[0])
        error = math.hypot(level_error, float(np.max(self._smooth_error[at - 1 : at + 1]))) / slope
        spread = math.hypot(error, self._left_out(place, others))
        found_Hz = float(self.frequency_Hz[at]) * math.exp(place)
        return Point(found_Hz, found_Hz * spread)

    def _through_neighbours(self, at: int) -> list[np.polynomial.Polynomial]:
        """Return the cubic through the smooth values at two frequencies before `at` and two from it on, the
        quartics through one more on either side, the parabolas through the first and the last three of the
        four, and the straight line through the middle two.

        They are polynomials of the logarithm of frequency over that at `at`: in it a response is smooth over
        frequencies that are far apart.
        """
        places = np.log(self.frequency_Hz / self.frequency_Hz[at])
        wanted = ((-2, 2), (-3, 2), (-2, 3), (-2, 1), (-1, 2), (-1, 1))
        ends = ((max(0, at + before), min(len(places), at + after)) for before, after in wanted)
        return [
            np.polynomial.Polynomial(
                np.linalg.solve(np.vander(places[begin:end], increasing=True), self.smooth[begin:end])
            )
            for begin, end in ends
        ]

    @staticmethod
    def _left_out(cubic: float, others: Sequence[float]) -> float:
        """Return what the cubic leaves out, by what quartics, parabolas and the straight line differ from it;
        of these a part, as the others may agree by chance. A quartic that would go beyond the frequencies is
        the cubic again, and tells nothing: then the parabolas count."""
        quartics, (left, right, straight) = others[:2], others[2:]
        of_parabola = _OF_PARABOLA if cubic not in quartics else 1.0
        return math.hypot(
            *(each - cubic for each in quartics),
            of_parabola * (left - cubic),
            of_parabola * (right - cubic),
            _OF_STRAIGHT * (straight - cubic),
        )

    def at(self, frequency_Hz: float) -> tuple[float, float]:
        """Return the value at a frequency and its standard uncertainty."""
        short, long = self._fits(frequency_Hz)
        if short is not long or not short.bridges:
            if short is long and not short.describes:
                return self._cubic(frequency_Hz).at_zero()
            return short.level, math.hypot(short.standard, long.level - short.level)
        at, place = self._place_of(frequency_Hz)
        value, *others = (float(curve(place)) for curve in self._through_neighbours(at))
        error = float(np.max(self._smooth_error[at - 1 : at + 1]))
        return value, math.hypot(error, self._left_out(value, others))

    def slope_at(self, frequency_Hz: float) -> float:
        """Return the change of the values per Hz."""
        short, long = self._fits(frequency_Hz)
        if short is not long or not short.bridges:
            return short.slope_at(0.0) / frequency_Hz
        at, place = self._place_of(frequency_Hz)
        return float(self._through_neighbours(at)[0].deriv()(place)) / frequency_Hz

    def _place_of(self, frequency_Hz: float) -> tuple[int, float]:
        """Return the first index from a frequency on, at least 1, and the logarithm of the frequency over
        the one there."""
        at = min(max(1, int(np.searchsorted(self.frequency_Hz, frequency_Hz))), len(self.smooth) - 1)
        return at, math.log(frequency_Hz / self.frequency_Hz[at])

    def resonance(self) -> tuple[float, float]:
        """Return the greatest of values in dB and its standard uncertainty, by the resonance about it;
        without one, `greatest`.

        The inverse square of the gain of two poles is a parabola of the square of frequency: its least value,
        of as many neighbours as it describes within their errors, shortened. Of all of them none is picked
        because its error is large.
        """
        top = int(np.argmax(self.smooth))
        if not 0 < top < len(self.smooth) - 1:
            return self.greatest()
        place = self.frequency_Hz**2
        near = np.abs(place / place[top] - 1.0) <= _REACH  # beyond it the inverse square grows without bound
        if np.count_nonzero(near) <= 2 * _FEWEST:
            return self.greatest()
        inverse = 10.0 ** (-0.1 * (self.values[near] - self.smooth[top]))
        error = inverse * self.error[near] / _NEPER_OF_POWER_DB
        square = ResponseCurve(place[near], inverse, error, 1.0)
        found = square.least_near(float(place[top]))
        if found is None:
            return self.greatest()
        least, standard = found
        return float(self.smooth[top]) - 10.0 * math.log10(least), _NEPER_OF_POWER_DB * standard / least

    def least_near(self, start: float) -> tuple[float, float] | None:
        """Return the least value near a place, and its standard uncertainty; None where the values of a local
        fit are not least within it, or not above zero there."""
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
        return (least, standard) if least > _CLEAR * standard else None

    def greatest(self) -> tuple[float, float]:
        """Return the greatest value, less what the errors add to it, and its standard uncertainty.

        Of a peak that few frequencies show, where its neighbours bend the other way, a third of its second
        difference is part of that, less what noise makes of it: it may be a cusp.
        """
        widths = self._widths
        random = np.random.default_rng(_SEED)
        drawn = random.standard_normal((_DRAWS, len(self.values))) * self.error
        errors = np.array([_running_mean(each, self._weights, widths) for each in drawn])
        value, standard = NoisyCurve(self.smooth, errors).greatest()
        top = int(np.argmax(self.smooth))
        bends = np.diff(self.smooth[max(0, top - 2) : top + 3], 2)
        if len(bends) < _AT_THE_TOP:
            return value, standard
        cusp = 0.0
        if np.max(bends) >= 0.0:
            # noise has raised the greatest, and the two beside it lie where theirs lets them
            of_noise = 2.0 * max(0.0, float(self.smooth[top]) - value) + _OF_TWO * float(
                self._smooth_error[top]
            )
            cusp = _OF_A_CUSP * max(0.0, abs(float(bends[1])) - of_noise)
        return value, math.hypot(standard, cusp, self._of_resonance(top))

    def _of_resonance(self, top: int) -> float:
        """Return how much higher the peak of a resonance through the greatest value, in dB, and its
        neighbours is than a parabola.

        Of a resonance the inverse square of the gain is a parabola of frequency, to second order about its
        peak; infinite where that falls to zero between them.
        """
        if not 0 < top < len(self.smooth) - 1:
            return 0.0
        near = slice(top - 1, top + 2)
        places, values = self.frequency_Hz[near] / self.frequency_Hz[top] - 1.0, self.smooth[near]
        inverse = 10.0 ** (-0.1 * (values - values[1]))
        constant, slope, bend = np.polynomial.polynomial.polyfit(places, inverse, 2).tolist()
        if not bend > 0.0:
            return 0.0
        least = constant - slope**2 / (4.0 * bend)
        if not least > 0.0:
            return math.inf
        _, slope_dB, bend_dB = np.polynomial.polynomial.polyfit(places, values, 2).tolist()
        above_dB = -(slope_dB**2) / (4.0 * bend_dB) if bend_dB < 0.0 else 0.0
        return abs(-10.0 * math.log10(least) - above_dB)

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
        points."""
        places = self.frequency_Hz / frequency_Hz - np.ones(len(self.frequency_Hz))
        nearest = np.argsort(np.abs(places), kind="stable")
        within = int(np.count_nonzero(np.abs(places) <= _REACH))
        found: list[LocalParabola] = []
        count = 2 * _FEWEST + 1
        while count <= max(within, 2 * _FEWEST + 1) and count <= len(places):
            chosen = nearest[:count]
            fit = LocalParabola.through(
                places[chosen], self.values[chosen], self._weights[chosen], self._scatter
            )
            if found and not fit.describes:
                break
            found.append(fit)
            count = math.ceil(_LONGER * count)
        if not found:
            found.append(LocalParabola.through(places, self.values, self._weights, self._scatter))
        return found[max(0, len(found) - 2)], found[-1]


def _running_mean(values: Floats, weights: Floats, widths: NDArray[np.int64]) -> Floats:
    places = np.arange(len(values))
    above = np.concatenate([[0.0], np.cumsum(values * weights)])
    below = np.concatenate([[0.0], np.cumsum(weights)])
    first, last = places - widths, places + widths + 1
    return np.asarray((above[last] - above[first]) / (below[last] - below[first]), dtype=np.float64)
