"""What dead time and devices take of each phase in a PWM period, by the course of its current within it.

A leg that is to go high waits for the dead time, and takes T_d u_dc from the period's volt-seconds if the
current flows out of it; one that is to go low gives as much if the current flows into it. A device takes its
voltage against the current all the time. Where the current has one sign in a period both are V_drop sgn(i).
Where its ripple takes it through zero they are less, and each in its way: the dead time counts at the edges,
between which the current may have turned, the device by the share of the period that either sign lasts. A
current that comes to zero within the dead time rests there, so that only a part of it is lost.

The modulation is taken to be centred with equal zero vectors (SVPWM), sampled at the ends of its periods.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.vectors import PHASES, phases_of, vector_of

_PARTS: Final = 24  # of a period, for the share of it that a current has either sign
_OF_LINK: Final = 2.0 / 3.0  # that drives the current while one leg waits


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
    ) -> NDArray[np.complex128]:
        """Return the mean voltages that are taken, in the stator's frame, shape (n,).

        Args:
            u_V: asked for over each period, shape (n,).
            i_A: currents at their ends, shape (n + 1,).
            rotor_rad: electrical angle of the rotor in each, shape (n,).
            dead_share: part of `drop_V` that is the dead time's.
        """
        phases = phases_of(u_V)
        centre = 0.5 * (np.max(phases, axis=1) + np.min(phases, axis=1))
        duty = np.clip(0.5 + (phases - centre[:, None]) / self.u_dc_V, 0.0, 1.0)
        edges = ((1.0 - duty, np.ones_like(duty)), (np.zeros_like(duty), duty))  # of rising, of falling
        if not self.double_update:
            both = 0.5 * (1.0 - duty), 0.5 * (1.0 + duty)
            edges = (both, both)
        courses = [_Course(self, duty, rise, fall, i_A, rotor_rad) for rise, fall in edges]
        rests_A = _OF_LINK * dead_share * self.drop_V * self.T_s / self.L_q_H
        lost = _before_rest(courses[0].at(courses[0].rise), rests_A)
        lost -= _before_rest(-courses[1].at(courses[1].fall), rests_A)
        signs = np.zeros_like(lost)
        for course in courses:
            for k in range(_PARTS):
                moment = np.full_like(lost, (k + 0.5) / _PARTS)
                signs += np.sign(course.at(moment)) / (_PARTS * len(courses))
        return self.drop_V * vector_of(dead_share * lost + (1.0 - dead_share) * signs)


class _Course:
    """Phase currents within periods whose legs go high and low at these shares of them, shapes (n, 3)."""

    def __init__(
        self,
        legs: Legs,
        duty: NDArray[np.float64],
        rise: NDArray[np.float64],
        fall: NDArray[np.float64],
        i_A: NDArray[np.complex128],
        rotor_rad: NDArray[np.float64],
    ) -> None:
        self._legs, self._duty, self.rise, self.fall = legs, duty, rise, fall
        self._begin, self._end = phases_of(i_A[:-1]), phases_of(i_A[1:])
        self._isotropic = 0.5 / legs.L_d_H + 0.5 / legs.L_q_H
        self._salient = (0.5 / legs.L_d_H - 0.5 / legs.L_q_H) * np.exp(2j * rotor_rad)

    def at(self, moment: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return each phase's current at a moment of its own, in shares of the period, shape (n, 3)."""
        high = np.clip(moment[:, :, None] - self.rise[:, None, :], 0.0, (self.fall - self.rise)[:, None, :])
        beyond = high - self._duty[:, None, :] * moment[:, :, None]  # its mean; by moments and legs
        flux = self._legs.u_dc_V * self._legs.T_s * (beyond @ PHASES) * (2.0 / 3.0)
        ripple = self._isotropic * flux + self._salient[:, None] * np.conj(flux)
        mean = self._begin + (self._end - self._begin) * moment
        found: NDArray[np.float64] = mean + (ripple * np.conj(PHASES)).real
        return found


def _before_rest(currents_A: NDArray[np.float64], rests_A: float) -> NDArray[np.float64]:
    """Return which part of the dead time is lost at edges with these currents, against which it counts from
    `-rests_A`, that come to zero at its end, on."""
    if rests_A <= 0.0:
        return (currents_A > 0.0).astype(np.float64)
    return np.clip(1.0 + currents_A / rests_A, 0.0, 1.0)
