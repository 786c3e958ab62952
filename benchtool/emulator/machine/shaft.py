"""Dry friction of the shaft, an optional part of the machine.

A shaft at rest sticks: it stays at rest until the torques on it exceed the breakaway torque. A shaft that
turns is braked by the Coulomb torque and, with the Stribeck effect, by what the breakaway torque has above
it, which fades out with the speed as exp(-(omega / omega_stribeck)^2). Nothing is smoothed, so that friction
has no stiffness: the direction of sliding is fixed within a step, and a step ends where the shaft comes to
rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit


class Stribeck(NamedTuple):
    """What the breakaway torque has above the Coulomb torque, and where it has faded out to 1/e."""

    excess: float
    per_omega_e: float  # one over electrical rad/s


class Friction(NamedTuple):
    """Dry friction of the shaft, in Nm."""

    T_coulomb: float
    T_breakaway: float
    stribeck: Stribeck | None


@njit
def sliding(friction: Friction | None, omega_e: float, domega: float, gamma: float) -> float:
    """Return the direction in which the shaft slides, 1 or -1, and 0 while it sticks; `domega` is without
    friction."""
    if friction is None:
        return 0.0
    if omega_e == 0.0 and abs(domega) <= gamma * friction.T_breakaway:
        return 0.0
    return math.copysign(1.0, omega_e if omega_e != 0.0 else domega)


@njit
def less_friction(
    friction: Friction | None, domega: float, omega_e: float, slide: float, gamma: float
) -> float:
    """Return the rate of the speed, less that of dry friction; the shaft slides in direction `slide`, or
    sticks."""
    if friction is None:
        return domega
    if slide == 0.0:
        return 0.0
    return domega - slide * gamma * (friction.T_coulomb + _stribeck_torque(friction.stribeck, omega_e))


@njit
def _stribeck_torque(stribeck: Stribeck | None, omega_e: float) -> float:
    if stribeck is None:
        return 0.0
    ratio = omega_e * stribeck.per_omega_e
    return stribeck.excess * math.exp(-ratio * ratio)


@njit
def friction_torque(friction: Friction | None, omega_e: float, driving: float) -> float:
    """Return the torque of dry friction against positive rotation, in Nm; a shaft at rest takes up to its
    breakaway torque of what drives it."""
    if friction is None:
        return 0.0
    if omega_e == 0.0:
        return min(max(driving, -friction.T_breakaway), friction.T_breakaway)
    return math.copysign(friction.T_coulomb + _stribeck_torque(friction.stribeck, omega_e), omega_e)


@njit
def part_until_rest(friction: Friction | None, before: float, after: float) -> float:
    """Return part of a step after which dry friction has brought the shaft to rest, by the secant; else 1."""
    if friction is None:
        return 1.0
    if before * after >= 0.0 and (before == 0.0 or after != 0.0):
        return 1.0
    return before / (before - after)


@njit
def stribeck_slope(friction: Friction | None) -> float:
    """Return the largest slope of dry friction over omega_e while the shaft slides, in Nms/rad."""
    if friction is None:
        return 0.0
    return _slope(friction.stribeck)


@njit
def _slope(stribeck: Stribeck | None) -> float:
    return 0.0 if stribeck is None else stribeck.excess * stribeck.per_omega_e
