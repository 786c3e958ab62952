"""Cogging by its orders, from a shaft that turns slowly.

Over the angle of the shaft, whatever its speed does meanwhile,

    T(theta) = d/dtheta (J omega^2 / 2) + T_friction + T_cogging(theta),

so that for each order n of a revolution the amplitudes hold, T_cogging,n = T_n - j n (J omega^2 / 2)_n: a
controller that holds the speed shows cogging as torque, one that does not as speed, and the sum is the same.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.mechanics import Course

_ROWS_PER_PERIOD = 5.0  # of the highest order that is told, at least
_LOWEST, _HIGHEST = 3, 300  # orders; those below are what is left of an eccentric encoder
_BY_CHANCE = 1e-5  # probability that an order which is not there is told, by the F distribution
_FEWEST = 3  # stretches


@dataclass(frozen=True)
class Cogging:
    """One order: periods in a revolution, amplitude in Nm with its standard uncertainty and degrees of
    freedom. The torque that overcomes it is amplitude_Nm cos(order theta_m + phase_rad)."""

    order: int
    amplitude_Nm: float
    phase_rad: float
    standard_Nm: float
    dof: float


def cogging(courses: Sequence[Course], J_kgm2: float, least_Nm: float) -> tuple[Cogging, ...]:
    """Return the orders whose amplitude is beyond `least_Nm` and what the scatter makes of none, largest
    first.

    Each steady stretch of whole revolutions tells the orders of which it has rows enough, in amplitude and
    phase. An order is the mean over stretches of several speeds and both directions: what depends on the
    speed scatters.
    """
    found = [
        each
        for course in courses
        for end in course.levels
        if (each := _orders(course, end, J_kgm2)) is not None
    ]
    told = []
    for order in range(_LOWEST, max((len(each) for each in found), default=0)):
        values = np.array([each[order] for each in found if len(each) > order])
        n, mean = len(values), complex(np.mean(values))
        if n < _FEWEST:
            break
        standard = math.sqrt(float(np.sum(np.abs(values - mean) ** 2)) / (n - 1.0) / n / 2.0)
        sure = _not_by_chance(n)
        if abs(mean) > max(least_Nm, sure * standard):
            told.append(Cogging(order, abs(mean), cmath.phase(mean), standard, 2.0 * (n - 1.0)))
    return tuple(sorted(told, key=lambda each: -each.amplitude_Nm))


def _not_by_chance(count: int) -> float:
    """Return beyond how many standard uncertainties the mean of so many phasors is, none of them there, once
    in 1 / `_BY_CHANCE` times.

    Half of its square has Fisher's distribution F(2, d) with d = 2 (count - 1), which is beyond x with the
    probability (1 + 2 x / d)^(-d / 2).
    """
    half_of_freedom = count - 1.0
    return math.sqrt(2.0 * half_of_freedom * math.expm1(-math.log(_BY_CHANCE) / half_of_freedom))


def without(courses: Sequence[Course], orders: Sequence[Cogging]) -> tuple[Course, ...]:
    """Return courses whose torque is less what overcomes the cogging.

    Of a small rotor, cogging has as large an impulse as the inertia while the shaft is reversed.
    """
    return tuple(
        replace(
            course,
            torque_Nm=course.torque_Nm
            - sum(
                (
                    each.amplitude_Nm * np.cos(each.order * course.theta_m_rad + each.phase_rad)
                    for each in orders
                ),
                np.zeros(len(course.theta_m_rad)),
            ),
        )
        for course in courses
    )


def _orders(course: Course, end: int, J_kgm2: float) -> NDArray[np.complex128] | None:
    """Return the amplitudes of the cogging by order, from 0 on, of the last whole revolutions of a stretch;
    None of less than one."""
    rows = slice(max(1, end - course.steady), min(end, len(course.theta_m_rad) - 1))
    theta, torque = course.theta_m_rad[rows], course.torque_Nm[rows]
    before, after = course.theta_m_rad[rows.start - 1 : rows.stop - 1], course.theta_m_rad[rows.start + 1 :]
    spans = after[: len(theta)] - before
    turned = np.abs(theta - theta[-1])
    revolutions = math.floor(float(turned[0]) / (2.0 * math.pi))
    if revolutions < 1:
        return None
    whole = turned <= 2.0 * math.pi * revolutions
    theta, torque, spans = theta[whole], torque[whole], spans[whole]
    step_rad = 2.0 * math.pi * revolutions / len(theta)
    order = np.arange(min(_HIGHEST, math.floor(2.0 * math.pi / step_rad / _ROWS_PER_PERIOD)) + 1)
    waves = np.exp(-1j * np.outer(order, theta)) * (0.5 * spans)  # an integral over the angle
    waves /= math.pi * revolutions * math.copysign(1.0, float(spans.sum()))
    energy = 0.5 * J_kgm2 * (spans / (2.0 * course.step_s)) ** 2
    torque, energy = (each - np.polyval(np.polyfit(theta, each, 1), theta) for each in (torque, energy))
    seen = np.sinc(order * step_rad / math.pi)  # of a wave, by a difference over two rows
    found: NDArray[np.complex128] = waves @ torque - 1j * order / seen * (waves @ energy)
    return found
