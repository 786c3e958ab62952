"""Cogging of several orders, an optional part of the machine: torques that the angle alone determines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit


class Cogging(NamedTuple):
    """Torques -T sin(order theta_m + phase): a row of T in Nm, order over pole pairs, and phase for each.

    The rest of a row is T times cosine and sine of the phase, and whether the order is a multiple of the pole
    pairs, as that of slots and poles together is: then the direction of the rotor flux tells the torque
    without a sine.
    """

    orders: NDArray[np.float64]


def cogging_of(
    torques_Nm: Sequence[float], orders: Sequence[int], phases_rad: Sequence[float], pole_pairs: int
) -> Cogging | None:
    """Return the cogging of a machine, None if it has none."""
    rows = [
        (
            torque,
            order / pole_pairs,
            phase,
            torque * math.cos(phase),
            torque * math.sin(phase),
            float(order % pole_pairs == 0),
        )
        for torque, order, phase in zip(torques_Nm, orders, phases_rad, strict=True)
        if torque != 0.0 and order != 0
    ]
    return Cogging(np.array(rows)) if rows else None


@njit
def less_cogging(
    cogging: Cogging | None,
    domega: float,
    theta_e: float,
    cos_theta: float,
    sin_theta: float,
    gamma: float,
) -> float:
    """Return the rate of the speed, less that of the cogging torque; `gamma` is its gain, p / J."""
    if cogging is None:
        return domega
    torque = 0.0
    for k in range(cogging.orders.shape[0]):
        if cogging.orders[k, 5] != 0.0:
            c, s = multiple(cos_theta, sin_theta, int(cogging.orders[k, 1]))
            torque += cogging.orders[k, 3] * s + cogging.orders[k, 4] * c
        else:
            torque += cogging.orders[k, 0] * math.sin(cogging.orders[k, 1] * theta_e + cogging.orders[k, 2])
    return domega - gamma * torque


@njit
def multiple(cosine: float, sine: float, n: int) -> tuple[float, float]:
    """Return cosine and sine of n times an angle, by squaring: n is a whole number, and not negative."""
    c, s = 1.0, 0.0
    while n > 0:
        if n & 1:
            c, s = c * cosine - s * sine, s * cosine + c * sine
        cosine, sine = cosine * cosine - sine * sine, 2.0 * sine * cosine
        n >>= 1
    return c, s


@njit
def cogging_torque(cogging: Cogging | None, theta_e: float) -> float:
    """Return the cogging torque against positive rotation, in Nm."""
    if cogging is None:
        return 0.0
    torque = 0.0
    for k in range(cogging.orders.shape[0]):
        torque += cogging.orders[k, 0] * math.sin(cogging.orders[k, 1] * theta_e + cogging.orders[k, 2])
    return torque


@njit
def cogging_stiffness(cogging: Cogging | None) -> float:
    """Return a bound of the slope of the cogging torque over theta_e, in Nm/rad."""
    if cogging is None:
        return 0.0
    stiffness = 0.0
    for k in range(cogging.orders.shape[0]):
        stiffness += cogging.orders[k, 0] * cogging.orders[k, 1]
    return stiffness


@njit
def cogging_turning(cogging: Cogging | None) -> float:
    """Return the periods of the fastest cogging torque in an electrical one."""
    if cogging is None:
        return 0.0
    turning = 0.0
    for k in range(cogging.orders.shape[0]):
        turning = max(turning, cogging.orders[k, 1])
    return turning
