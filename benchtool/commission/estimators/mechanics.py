"""Inertia and friction of a shaft that is reversed between constant speeds.

Over whole revolutions at a steady speed the work of the torque is that of friction and load,

    integral of T over the angle / 2 pi n = coulomb sgn(omega) + friction omega + load,

as cogging has no work over a revolution. It has a mean over time, where the shaft is slower in front of each
tooth than behind it: T, too, has to be averaged over the angle. While the shaft is reversed, the impulse of T
is what its speed changes by. With a weight w(t) that comes from zero and goes back to it with its slope,

    J integral of w'' theta = integral of w (T - coulomb sgn(omega) - friction omega - load),

as integration by parts has it (M. Shinbrot's modulating functions, 1957): no speed has to be told from the
counts of an encoder, and friction and load count only for as long as the weight lasts. T is to be without
cogging, as far as that is known.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import least_squares
from benchtool.errors import AnalysisError, SetUpError

_FEWEST_ROWS = 20
_SPAN = 8  # rows of a difference for a speed
_STANDS_RAD = 0.05  # of a stretch of a revolution or more
_DRIFT = 0.05  # of its speed, that a steady stretch may change by
_STEADY_ROWS = 6000  # of a course, for what is steady: of finer ones a speed is counts of the encoder
_LASTS = 3.0  # times from the setpoint to no speed, half of a weight
_NARROWEST = 24  # rows, half of a weight


@dataclass(frozen=True)
class Course:
    """A shaft that goes from one speed to the next.

    `theta_m_rad` without wraps and `torque_Nm` of the air gap, shape (n,), every `step_s`; `levels` are the
    rows at which each setpoint ends, `steady` is how many rows before that are taken for steady.
    """

    theta_m_rad: NDArray[np.float64]
    torque_Nm: NDArray[np.float64]
    step_s: float
    levels: tuple[int, ...]
    steady: int

    @property
    def thinned(self) -> Course:
        """This with rows left out, so that it has not more than some thousand."""
        k = math.ceil(len(self.theta_m_rad) / _STEADY_ROWS)
        levels = tuple(end // k for end in self.levels)
        return replace(
            self,
            theta_m_rad=self.theta_m_rad[::k],
            torque_Nm=self.torque_Nm[::k],
            step_s=k * self.step_s,
            levels=levels,
            steady=self.steady // k,
        )


@dataclass(frozen=True)
class Mechanics:
    """Estimates with standard uncertainties: inertia in kgm2, viscous friction in Nms, Coulomb friction and a
    torque in one direction in Nm; degrees of freedom of the inertia and of the friction."""

    J_kgm2: float
    J_standard: float
    J_dof: float
    friction_Nms: float
    friction_standard: float
    coulomb_Nm: float
    coulomb_standard: float
    load_Nm: float
    load_standard: float
    friction_dof: float


@dataclass(frozen=True)
class _Stretch:
    """A steady stretch: its speed in rad/s and the torque in Nm, means over the angle."""

    omega: float
    torque: float


def mechanics(courses: Sequence[Course]) -> Mechanics:
    """Return the estimates.

    Raises:
        AnalysisError: not enough speeds.
        SetUpError: the shaft holds no speeds.
    """
    stretches = [
        _stretch(each, end) for each in (course.thinned for course in courses) for end in each.levels
    ]
    omega, torque = np.array([(each.omega, each.torque) for each in stretches]).T
    fit = least_squares(np.column_stack([np.sign(omega), omega, np.ones(len(omega))]), torque)
    coulomb, friction, load = (float(value) for value in fit.x)
    change, impulse = np.array(
        [_reversal(course, end, coulomb, friction, load) for course in courses for end in course.levels[:-1]]
    ).T
    counts = np.sqrt(np.abs(change))  # cogging leaves the less, the faster the shaft passes it
    inertia = least_squares((change * counts)[:, None], impulse * counts)
    return Mechanics(
        float(inertia.x[0]),
        inertia.standard(0),
        inertia.dof,
        friction,
        fit.standard(1),
        coulomb,
        fit.standard(0),
        load,
        fit.standard(2),
        fit.dof,
    )


def _stretch(course: Course, end: int) -> _Stretch:
    """Return the last whole revolutions before a row, or all that are there of less than one."""
    theta = course.theta_m_rad[max(0, end - course.steady) : end]
    if len(theta) < _FEWEST_ROWS:
        raise AnalysisError(f"{len(theta)} rows at a constant speed, {_FEWEST_ROWS} at least are needed")
    turned = np.abs(theta - theta[-1])
    if float(np.max(turned)) < _STANDS_RAD:
        raise SetUpError(
            f"the shaft turns by {math.degrees(float(np.max(turned))):.2g} degrees in "
            f"{len(theta) * course.step_s:.2g} s where it should hold a speed",
            "a load on the shaft, a brake, or friction beyond the torque that the controller may ask for",
            "uncouple the load, release the brake, and see that the shaft turns freely by hand",
        )
    revolutions = math.floor(turned[0] / (2.0 * math.pi))
    rows = len(theta)
    if revolutions >= 1:
        rows = int(np.count_nonzero(turned <= 2.0 * math.pi * revolutions))
    rows = max(rows, _FEWEST_ROWS)
    theta, torque = theta[-rows:], course.torque_Nm[end - rows : end]
    omega = float(theta[-1] - theta[0]) / ((rows - 1) * course.step_s)
    x = (np.arange(rows) - 0.5 * (rows - 1)) * course.step_s
    change = float(np.polyfit(x, theta, 2)[0]) * 2.0 * rows * course.step_s
    if not abs(change) <= _DRIFT * abs(omega):
        raise SetUpError(
            f"the speed changes from {omega - 0.5 * change:.4g} rad/s by {change:.3g} rad/s where it should "
            f"be steady",
            "a load on the shaft, of a larger inertia than the nameplate's or a torque that varies",
            "uncouple the load to commission the motor alone, or state its inertia in motor.J_kgm2",
        )
    steps = np.diff(theta)
    by_angle = float(np.sum(0.5 * (torque[1:] + torque[:-1]) * steps) / np.sum(steps))
    spans = theta[_SPAN:] - theta[:-_SPAN]  # a shaft that cogs is faster where it covers more of its angle
    over_angle = float(np.sum(spans**2) / np.sum(spans)) / (_SPAN * course.step_s)
    return _Stretch(over_angle, by_angle)


def _reversal(course: Course, end: int, coulomb: float, friction: float, load: float) -> tuple[float, float]:
    """Return the weighted change of the speed, rad/s, after the row at which a setpoint ends, and the
    impulse of the torque that it takes, Nms."""
    theta = course.theta_m_rad
    sense = math.copysign(1.0, theta[end - 1] - theta[max(0, end - course.steady)])
    furthest = sense * theta[end : end + course.steady]
    # the encoder shows one count all the while in which the shaft turns back within it
    turns_back = end + round(float(np.mean(np.flatnonzero(furthest == np.max(furthest)))))
    half = max(_NARROWEST, round(_LASTS * (turns_back - end)))
    half = min(half, turns_back, len(theta) - 1 - turns_back)
    rows = slice(turns_back - half, turns_back + half + 1)
    x = np.arange(-half, half + 1) / half
    weight = (1.0 - x**2) ** 4
    slope = -8.0 * x * (1.0 - x**2) ** 3 / (half * course.step_s)
    bend = 8.0 * (1.0 - x**2) ** 2 * (7.0 * x**2 - 1.0) / (half * course.step_s) ** 2
    angle = theta[rows] - theta[turns_back]
    accelerates = course.torque_Nm[rows] + coulomb * sense * np.sign(x) - load
    change = float(np.sum(bend * angle)) * course.step_s
    return change, float(np.sum(weight * accelerates + friction * slope * angle)) * course.step_s
