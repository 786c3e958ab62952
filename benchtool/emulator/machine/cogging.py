"""Cogging of several orders, an optional part of the machine: torques that the angle alone determines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit


class Cogging(NamedTuple):
    """Torques -T sin(order theta_m + phase): a row of T in Nm, order over pole pairs, and phase for each."""

    orders: NDArray[np.float64]


def cogging_of(
    torques_Nm: Sequence[float], orders: Sequence[int], phases_rad: Sequence[float], pole_pairs: int
) -> Cogging | None:
    """Return the cogging of a machine, None if it has none."""
    rows = [
        (torque, order / pole_pairs, phase)
        for torque, order, phase in zip(torques_Nm, orders, phases_rad, strict=True)
        if torque != 0.0 and order != 0
    ]
    return Cogging(np.array(rows)) if rows else None


@njit
def less_cogging(cogging: Cogging | None, domega: float, theta_e: float, gamma: float) -> float:
    """Return the rate of the speed, less that of the cogging torque; `gamma` is its gain, p / J."""
    if cogging is None:
        return domega
    return domega - gamma * cogging_torque(cogging, theta_e)


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
