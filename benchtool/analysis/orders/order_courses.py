"""Course of an order's amplitude from revolution to revolution that a curve explains: it is no scatter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples, CoherentSpectrum, spectrum_of
from benchtool.analysis.noise.noise_of_lines import line_noise
from benchtool.analysis.orders.angle import TURN
from benchtool.analysis.orders.slow_course import Turns
from benchtool.analysis.spectra.amplitude_trend import AmplitudeTrend
from benchtool.analysis.spectra.modulation import PeriodsInTime

_ROUNDS = 3
_MATTERS = 1e-3  # of an amplitude
_CLEARLY = 2.4  # times as much as across it, root of a ratio of variances
_NEARLY_ALL = 0.8  # of the parts: what is between them is then a small matter
_STANDS_OUT = 5.0  # times its deviation, or noise: the course of less is one of noise


@dataclass(frozen=True)
class OrderCourse:
    """The course that the amplitude of one `order` has over a record, as a `trend` relative to its mean over
    the revolutions: `phasor` is that mean, a peak amplitude with the phase at the angle zero."""

    order: int
    phasor: complex
    trend: AmplitudeTrend

    @property
    def of_level(self) -> float:
        """Standard uncertainty of the amplitude against the mean over revolutions."""
        return abs(self.phasor) * self.trend.of_level

    def beside_level(
        self, passed: NDArray[np.float64], angle_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return what the course adds at angles after a share of the record, 0 to 1, both of shape (n,)."""
        carrier = np.real(self.phasor * np.exp(1j * self.order * angle_rad))
        return np.asarray((self.trend.curve(passed) - self.trend.level) * carrier)


def of_levels(courses: Mapping[int, OrderCourse], orders: int) -> NDArray[np.float64]:
    """Return the standard uncertainties of amplitudes of orders 1 to `orders` against their means over
    revolutions, shape (orders,); 0 of those without a course."""
    return np.array([courses[each].of_level if each in courses else 0.0 for each in range(1, orders + 1)])


def _course_of(
    order: int, phasors: NDArray[np.complex128], in_time: PeriodsInTime, known: OrderCourse | None
) -> OrderCourse | None:
    """Return the course of one order, of phasors of its revolutions, shape (revolutions,), as peak
    amplitudes, which a course that is `known` already is taken off; None if there is none."""
    mean = complex(np.mean(phasors))
    if mean == 0.0:
        return None
    towards = mean / abs(mean)
    along = np.real(phasors * np.conj(towards))
    if known is not None:
        along += abs(known.phasor) * (known.trend.over_periods - known.trend.level)
    trend = in_time.trend(along)
    return None if trend is None else OrderCourse(order, towards * float(np.mean(along)), trend)


def _courses_of(
    phasors: Mapping[int, NDArray[np.complex128]], in_time: PeriodsInTime, known: Mapping[int, OrderCourse]
) -> dict[int, OrderCourse]:
    found = {order: _course_of(order, of_it, in_time, known.get(order)) for order, of_it in phasors.items()}
    return {order: course for order, course in found.items() if course is not None}


def without_courses(
    coherent: CoherentSamples, highest_order: int, in_time: PeriodsInTime
) -> tuple[CoherentSpectrum, dict[int, OrderCourse]]:
    """Return the spectrum of samples over whole revolutions in which the mean and the amplitudes of orders
    are steady, each at the level of its course, and those courses by order, that of the mean as of order 0.

    A course has sidebands beside its order, which are not what that is uncertain by, and their tails are in
    the other orders.
    """
    steady, courses = _without_courses(coherent, (), in_time)  # a drift hides which amplitudes move
    spectrum = spectrum_of(steady)
    orders = np.arange(1, min(highest_order, (len(spectrum.amplitude) - 1) // spectrum.periods) + 1)
    lines = orders * spectrum.periods
    noise = line_noise(spectrum, lines)
    moving = orders[noise.wanders & (spectrum.amplitude[lines] > _STANDS_OUT * noise.in_phase)]
    if not len(moving):
        return spectrum, courses
    steady, courses = _without_courses(coherent, moving.tolist(), in_time)
    return spectrum_of(steady), courses


def _without_courses(
    coherent: CoherentSamples, orders: Sequence[int], in_time: PeriodsInTime
) -> tuple[CoherentSamples, dict[int, OrderCourse]]:
    """Return samples without the courses of the mean and of these orders."""
    courses: dict[int, OrderCourse] = {}
    points = np.arange(len(coherent.values), dtype=np.float64)
    angle_rad = TURN / coherent.per_period * points
    passed = np.interp(points / coherent.per_period, np.arange(len(in_time.edges)), in_time.edges)
    carriers = {each: np.exp(-1j * each * angle_rad[: coherent.per_period]) for each in orders}
    values = coherent.values
    # a mean may be zero, or of either sign
    middle, size = float(np.mean(values)), float(np.max(np.abs(values)))
    for _ in range(_ROUNDS):
        table = values.reshape(coherent.periods, -1)
        phasors = {order: table @ each * (2.0 / coherent.per_period) for order, each in carriers.items()}
        phasors[0] = size + np.mean(table, axis=1).astype(np.complex128) - middle
        courses = _courses_of(phasors, in_time, courses)
        if not courses:
            return coherent, courses
        values = coherent.values - _beside_levels(courses, passed, angle_rad)
    return replace(coherent, values=values), courses


def _beside_levels(
    courses: Mapping[int, OrderCourse], passed: NDArray[np.float64], angle_rad: NDArray[np.float64]
) -> NDArray[np.float64]:
    return np.asarray(np.sum([each.beside_level(passed, angle_rad) for each in courses.values()], axis=0))


@dataclass(frozen=True)
class CoursesByAngle:
    """Courses of the mean, as of order 0, and of orders 1, 2 ... over the turns of a record without time.

    `edges` are those of its parts, of which some are `whole` turns, and some left out; `total` are all turns.
    The course of the mean is relative to `size`.
    """

    edges: NDArray[np.float64]
    whole: NDArray[np.bool_]
    total: float
    size: float
    courses: Mapping[int, OrderCourse]

    @classmethod
    def none_over(cls, turns: Turns, size: float) -> CoursesByAngle:
        """Return none yet over turns."""
        edges = np.unique(turns.edges[turns.whole])
        return cls(edges, np.isin(edges[:-1], turns.edges[turns.whole, 0]), turns.total, size, {})

    def found_in(self, phasors: NDArray[np.complex128]) -> CoursesByAngle:
        """Return the courses of phasors of the whole turns, shape (1 + orders, turns), means and peak
        amplitudes, which those known so far are taken off; none where many turns are left out."""
        if np.mean(self.whole) < _NEARLY_ALL:
            return self
        phasors = phasors.copy()
        phasors[0] += self.size - np.mean(phasors[0])
        mean = np.mean(phasors, axis=1)
        turned = phasors * np.exp(-1j * np.angle(mean))[:, np.newaxis]
        along, across = np.std(turned.real, axis=1), np.std(turned.imag, axis=1)
        moves = along > np.maximum(_CLEARLY * across, _MATTERS * np.abs(mean))
        moves &= np.abs(mean) > _STANDS_OUT * along
        orders = sorted({0, *self.courses, *np.flatnonzero(moves).tolist()})
        middle = 0.5 * (self.edges[1:] + self.edges[:-1])
        of_parts = {each: np.interp(middle, middle[self.whole], phasors[each]) for each in orders}
        length = float(self.edges[-1] - self.edges[0])
        before, after = float(self.edges[0]) / length, (self.total - float(self.edges[-1])) / length
        in_turns = PeriodsInTime((self.edges - self.edges[0]) / length, before, after)
        return replace(self, courses=_courses_of(of_parts, in_turns, self.courses))

    def beside_levels(
        self, turns: NDArray[np.float64], angle_rad: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return what they add at angles after so many turns, both of shape (n,)."""
        if not self.courses:
            return np.zeros(len(turns))
        passed = (turns - self.edges[0]) / (self.edges[-1] - self.edges[0])
        return _beside_levels(self.courses, passed, angle_rad)
