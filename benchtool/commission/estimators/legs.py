"""What dead time and devices take of each phase in a PWM period, by the course of its current within it.

A leg that is to go high waits for the dead time, and takes T_d u_dc from the period's volt-seconds if the
current flows out of it; one that is to go low gives as much if the current flows into it. A device takes its
voltage against the current all the time. Where the current has one sign in a period both are V_drop sgn(i).
Where its ripple takes it through zero they are less, and each in its way: the dead time counts at the edges,
between which the current may have turned, the device by the share of the period that either sign lasts. A
current that comes to zero within the dead time rests there, so that only a part of it is lost.

What is taken bends the current, which decides what is taken: the course is computed step by step from what
the current is at the beginning of a period, and once more with what that missed its end by, spread evenly.

The modulation is taken to be centred with equal zero vectors (SVPWM), sampled at the ends of its periods.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.vectors import phases_of, vector_of

_STEPS: Final = 48  # of a period
_FAR: Final = 0.25  # of what the whole link changes a current by in a period: its ripple is less
_SQRT_3: Final = math.sqrt(3.0)
_OF_LINK: Final = 2.0 / 3.0  # that changes the current of a phase


@dataclass(frozen=True)
class Legs:
    """An inverter and the winding at its legs.

    `T_s` is the control period, `double_update` whether it is half of a PWM period. `L_d_H` and `L_q_H` hold
    for the ripple, and `drop_V` is what dead time and devices take of a phase together.
    """

    T_s: float
    u_dc_V: float
    L_d_H: float
    L_q_H: float
    drop_V: float
    double_update: bool = False

    def taken(
        self,
        u_V: NDArray[np.complex128],
        i_A: NDArray[np.complex128],
        rotor_rad: NDArray[np.float64],
        dead_share: float,
        against_V: NDArray[np.complex128] | complex = 0j,
    ) -> NDArray[np.complex128]:
        """Return the mean voltages that are taken, in the stator's frame, shape (n,).

        Args:
            u_V: asked for over each period, shape (n,).
            i_A: currents at their ends, shape (n + 1,).
            rotor_rad: electrical angle of the rotor in each, shape (n,).
            dead_share: part of `drop_V` that is the dead time's.
            against_V: what the EMF and the resistance have of the voltage, likewise, shape (n,).
        """
        if self.drop_V == 0.0:
            return np.zeros(len(u_V), np.complex128)
        ends = phases_of(i_A)
        least_A = np.min(np.minimum(np.abs(ends[1:]), np.abs(ends[:-1])), axis=1)
        far_A = _FAR * _OF_LINK * self.u_dc_V * self.T_s * (0.5 / self.L_d_H + 0.5 / self.L_q_H)
        clear = (least_A > far_A) & np.all(ends[1:] * ends[:-1] > 0.0, axis=1)
        found: NDArray[np.complex128] = self.drop_V * vector_of(np.sign(ends[1:]))
        (near,) = np.nonzero(~clear)
        phases = phases_of(u_V[near]).T
        centre = 0.5 * (np.max(phases, axis=0) + np.min(phases, axis=0))
        duty = np.clip(0.5 + (phases - centre) / self.u_dc_V, 0.0, 1.0)
        waits = dead_share * self.drop_V / self.u_dc_V
        pulses = [(0.5 * (1.0 - duty), 0.5 * (1.0 + duty), waits)]
        if self.double_update:  # a half of a PWM period has the one edge or the other
            never = np.full_like(duty, 4.0)
            pulses = [(1.0 - duty, never, 2.0 * waits), (-never, duty, 2.0 * waits)]
        course = _Course(
            i_A[near],
            i_A[near + 1],
            np.exp(2j * rotor_rad[near]),
            np.broadcast_to(against_V, len(u_V))[near],
            (1.0 - dead_share) * self.drop_V,
        )
        found[near] = np.mean([self._of_pulse(*each, course) for each in pulses], axis=0)
        return found

    def _of_pulse(
        self, rise: NDArray[np.float64], fall: NDArray[np.float64], waits: float, course: _Course
    ) -> NDArray[np.complex128]:
        """Return what is taken of legs that go high and low at these shares of the periods, shape (3, n)."""
        step = 1.0 / _STEPS
        isotropic = step * self.T_s * (0.5 / self.L_d_H + 0.5 / self.L_q_H)
        salient = step * self.T_s * (0.5 / self.L_d_H - 0.5 / self.L_q_H) * course.axis
        near_A = _OF_LINK * self.u_dc_V * isotropic  # zero: what it changes by in a step
        link, half = self.u_dc_V, 0.5 * self.u_dc_V
        begins = step * np.arange(_STEPS)
        told = []  # in each step, what the legs are told and what they wait for, as vectors and of each leg
        for begin in begins.tolist():
            rising = half * _within(begin, step, rise, rise + waits)
            falling = half * _within(begin, step, fall, fall + waits)
            asked = link * _vector(_within(begin, step, rise, fall)) - course.against_V
            told.append((asked, rising - falling, rising + falling + course.device_V))
        lost = missed = np.zeros_like(course.begin_A)
        for _ in range(2):
            i, lost, change = course.begin_A, np.zeros_like(course.begin_A), np.zeros_like(course.begin_A)
            for asked, anyway, by_sign in told:
                sign = np.clip(_phases(i + 0.5 * change) / near_A, -1.0, 1.0)
                taken = _vector(anyway + by_sign * sign)
                v = asked - taken
                change = isotropic * v + salient * np.conj(v) + step * missed
                i = i + change
                lost += taken
            missed = missed + course.end_A - i
        return step * lost


@dataclass(frozen=True)
class _Course:
    """Currents at both ends of n periods, exp(j 2 theta_e) of the rotor, EMF and what the resistance has, and
    voltage of a device."""

    begin_A: NDArray[np.complex128]
    end_A: NDArray[np.complex128]
    axis: NDArray[np.complex128]
    against_V: NDArray[np.complex128]
    device_V: float


def _vector(phases: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Return the vectors of phases of shape (3, n), without a matrix product: rows are long."""
    found = np.empty(phases.shape[1], np.complex128)
    found.real = _OF_LINK * (phases[0] - 0.5 * (phases[1] + phases[2]))
    found.imag = (phases[1] - phases[2]) / _SQRT_3
    return found


def _phases(vectors: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the phases of vectors, shape (3, n)."""
    half, across = -0.5 * vectors.real, 0.5 * _SQRT_3 * vectors.imag
    return np.stack([vectors.real, half + across, half - across])


def _within(
    begin: float, step: float, since: NDArray[np.float64], until: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return which share of a step lies between two moments."""
    longest: NDArray[np.float64] = np.minimum(begin + step, until) - np.maximum(begin, since)
    return np.clip(longest / step, 0.0, 1.0)
