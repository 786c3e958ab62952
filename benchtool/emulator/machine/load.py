"""What loads the shaft: torques of the driven machine by speed and angle, and a load machine with its limits.

    T = linear omega + quadratic |omega| omega + table(theta) + g U sin(theta)

Torques are against positive rotation. A load machine makes the torque that is asked of it with a lag of first
order, and holds a speed by a torque in proportion to what the speed is off, up to its limit.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit


class Curve(NamedTuple):
    """Torque by speed: of a generator or a brake in proportion to it, of a fan or a pump to its square."""

    linear: float
    quadratic: float


class OverAngle(NamedTuple):
    """Torques at even angles of a revolution, shape (n,), linear in between; `peak` is the largest of them,
    `slope` the steepest in Nm/rad."""

    torques: NDArray[np.float64]
    peak: float
    slope: float


class Unbalance(NamedTuple):
    """Torque of the weight of an unbalance on a horizontal shaft, at its largest."""

    torque: float


class OverTime(NamedTuple):
    """Torques at even times of a cycle, shape (n,), linear in between; `per_s` is one over its duration."""

    torques: NDArray[np.float64]
    per_s: float


class LoadMachine(NamedTuple):
    """A load machine: cut-off of its torque in rad/s, torque per rad/s that the speed it holds is off, the
    torque that it has; and whether it holds a speed now, and which."""

    omega_c: float
    stiffness: float
    limit: float
    holds: bool
    omega_m: float


@njit
def curve_torque(curve: Curve | None, omega: float) -> float:
    """Return the torque that depends on the speed."""
    if curve is None:
        return 0.0
    return (curve.linear + curve.quadratic * abs(omega)) * omega


@njit
def angle_torque(table: OverAngle | None, theta: float) -> float:
    """Return the torque that depends on the angle."""
    if table is None:
        return 0.0
    return _interpolated(table.torques, theta * (1.0 / (2.0 * math.pi)))


@njit
def unbalance_torque(unbalance: Unbalance | None, theta: float) -> float:
    """Return the torque of the weight of an unbalance."""
    if unbalance is None:
        return 0.0
    return unbalance.torque * math.sin(theta)


@njit
def time_torque(table: OverTime | None, load: Any, T_s: float) -> float:
    """Return the mean torque of the cycle over the period that begins, and let that pass in `load`."""
    if table is None:
        return 0.0
    part = T_s * table.per_s
    torque = _interpolated(table.torques, load.cycle + 0.5 * part)
    load.cycle += part
    load.cycle -= math.floor(load.cycle)
    return torque


@njit
def _interpolated(values: NDArray[np.float64], part: float) -> float:
    """Return the value at this part of a cycle, linear between even points, of which the first follows the
    last."""
    place = (part - math.floor(part)) * values.size
    k = int(place)
    if k >= values.size:  # the part was so little below a whole that it rounded to it
        k, place = 0, 0.0
    following = values[k + 1] if k + 1 < values.size else values[0]
    return float(values[k] + (place - k) * (following - values[k]))


@njit
def machine_torque(machine: LoadMachine | None, torque: float, T_load: float) -> float:
    """Return the torque that the load machine makes: `T_load` at once if it has no lag."""
    if machine is None:
        return T_load
    return torque


@njit
def machine_rate(machine: LoadMachine | None, torque: float, omega: float, T_load: float) -> float:
    """Return the rate of the load machine's torque, in Nm/s; `T_load` is asked of it unless it holds."""
    if machine is None:
        return 0.0
    if machine.holds:
        T_load = machine.stiffness * (omega - machine.omega_m)
    return (min(max(T_load, -machine.limit), machine.limit) - torque) * machine.omega_c


@njit
def push(machine: LoadMachine | None, torque: float, omega: float, T_load: float) -> float:
    """Return the largest torque that the load machine may make within a period, from `torque` on."""
    if machine is None:
        return abs(T_load)
    wanted = machine.stiffness * abs(omega - machine.omega_m) if machine.holds else abs(T_load)
    return max(abs(torque), min(wanted, machine.limit))


@njit
def table_peak(table: OverAngle | None) -> float:
    """Return the largest torque over the angle."""
    return 0.0 if table is None else table.peak


@njit
def curve_slope(curve: Curve | None) -> float:
    """Return the slope of the torque over the speed at rest, in Nms/rad."""
    return 0.0 if curve is None else curve.linear


@njit
def curve_turning(curve: Curve | None) -> float:
    """Return what every rad/s adds to that slope."""
    return 0.0 if curve is None else 2.0 * curve.quadratic


@njit
def table_stiffness(table: OverAngle | None) -> float:
    """Return the steepest slope of the torque over the angle, in Nm/rad."""
    return 0.0 if table is None else table.slope


@njit
def table_turning(table: OverAngle | None) -> float:
    """Return the periods of the fastest torque in a table in a revolution."""
    return 0.0 if table is None else 0.5 * table.torques.size


@njit
def unbalance_stiffness(unbalance: Unbalance | None) -> float:
    """Return the steepest slope of the torque of an unbalance over the angle, in Nm/rad."""
    return 0.0 if unbalance is None else unbalance.torque


@njit
def load_machine_rate(machine: LoadMachine | None, inv_J: float) -> float:
    """Return a bound of the rate of a load machine in 1/s, on 1 / J of the shaft that it holds."""
    if machine is None:
        return 0.0
    return machine.omega_c + math.sqrt(machine.stiffness * machine.omega_c * inv_J)
