"""Inertia and friction of a shaft that is reversed between constant speeds.

Over whole revolutions at a steady speed the work of the torque is that of friction and load,

    integral of T over the angle / 2 pi n = coulomb sgn(omega) + friction omega + load,

as cogging has no work over a revolution. It has a mean over time, where the shaft is slower in front of each
tooth than behind it: T, too, has to be averaged over the angle. Between the middles of two such stretches the
impulse of T is what the speed changes by,

    J (omega_2 - omega_1) = integral of T - coulomb sgn(omega) - friction omega - load - cogging over time,

with the mean of cogging over the time of a stretch by what the two averages of T differ by.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import least_squares
from benchtool.errors import AnalysisError, SetUpError

_FEWEST_ROWS = 20
_SPAN = 8  # rows of a difference for a speed
_STANDS_RAD = 0.05  # of a stretch of a revolution or more
_DRIFT = 0.05  # of its speed, that a steady stretch may change by


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
    """A steady stretch: its middle and length in rows, speed in rad/s, its mean over the angle, and the mean
    torque over its angle and over its time."""

    middle: float
    rows: int
    omega: float
    over_angle: float
    torque: float
    over_time: float


def mechanics(courses: Sequence[Course]) -> Mechanics:
    """Return the estimates.

    Raises:
        AnalysisError: not enough speeds.
        SetUpError: the shaft holds no speeds.
    """
    stretches = [[_stretch(course, end) for end in course.levels] for course in courses]
    every = [one for each in stretches for one in each]
    omega, torque = np.array([each.over_angle for each in every]), np.array([each.torque for each in every])
    fit = least_squares(np.column_stack([np.sign(omega), omega, np.ones(len(omega))]), torque)
    coulomb, friction, load = (float(value) for value in fit.x)
    changes, impulses = [], []
    for course, held in zip(courses, stretches, strict=True):
        for before, after in itertools.pairwise(held):
            changes.append(after.omega - before.omega)
            impulses.append(_impulse(course, before, after, coulomb, friction, load))
    change = np.array(changes)
    counts = np.sqrt(np.abs(change))  # cogging leaves the less, the faster the shaft passes it
    inertia = least_squares((change * counts)[:, None], np.array(impulses) * counts)
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
    return _Stretch(end - 0.5 * (rows + 1), rows, omega, over_angle, by_angle, float(np.mean(torque)))


def _impulse(
    course: Course, before: _Stretch, after: _Stretch, coulomb: float, friction: float, load: float
) -> float:
    """Return the impulse of the torque that accelerates, between the middles of two stretches, Nms."""
    row = np.arange(len(course.torque_Nm))
    inside = (row > before.middle) & (row < after.middle)
    first, last = int(np.argmax(inside)), len(row) - int(np.argmax(inside[::-1])) - 1
    ends = (before.middle, *row[first : last + 1], after.middle)
    torque = np.interp(ends, row, course.torque_Nm)
    angle = np.interp(ends, row, course.theta_m_rad)
    whole = float(np.trapezoid(torque, ends)) * course.step_s
    duration = (after.middle - before.middle) * course.step_s
    turning = duration * math.copysign(1.0, after.omega)
    if before.omega * after.omega < 0.0:
        furthest = int(np.argmax(angle * math.copysign(1.0, before.omega)))
        reversed_s = (ends[furthest] - before.middle) * course.step_s
        turning = math.copysign(1.0, after.omega) * (duration - 2.0 * reversed_s)
    cogging = 0.5 * sum(
        (each.over_time - each.torque) * each.rows * course.step_s for each in (before, after)
    )
    return whole - coulomb * turning - friction * float(angle[-1] - angle[0]) - load * duration - cogging
