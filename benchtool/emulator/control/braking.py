"""Braking to standstill: the torque of a quick stop and of a halt, and when the shaft is at rest.

The speed falls along an exponential, omega' = -omega / tau, so that it meets zero with no acceleration left
and the shaft does not turn back. What torque that takes with the load and the inertia that are there is told
by a disturbance observer: T - J omega', low-passed (Ohnishi, Shibata, Murakami, IEEE/ASME Trans. Mechatronics
1(1), 1996). It starts from the torque of the moment, needs no unwinding after the torque limit, and holds the
load at standstill. With true inertias of 0.1 to 20 times `J` the shaft turns back by less than 0.5 rad/s.

Angle, speed and acceleration come from an observer with two poles at `omega_observer`. The rate of its angle
has no lag at constant acceleration; its acceleration has the lag of these poles, which the torque is given,
too.
"""

from __future__ import annotations

from typing import Any

from benchtool.emulator.control.observer import wrapped
from benchtool.emulator.jit import njit

_STANDSTILL = 0.01  # of the rated speed
_BANDWIDTH = 1.0 / 3.0  # of the disturbance observer in units of omega_observer
_SLOW = 0.1  # of the rated speed
_LANDING = 8.0  # tau in units of 1 / omega_observer
_SETTLING = 3.0  # of the observer's transient, in the same units
_TURNED_S = 4.5e-4
_REST_S = 0.08


@njit
def brake(drive: Any, control: Any, omega_m: float) -> float:
    """Return the torque that brings the shaft to rest and holds it there, within `torque_limit`.

    Args:
        drive: the drive's memory.
        control: state of the control; its `braking` is 0 in the first tick.
        omega_m: measured speed, rad/s, from which the first tick starts.
    """
    T_s, omega_0 = drive.control_period, drive.omega_observer
    if control.braking == 0:
        control.turned_ticks, control.rest_ticks = 0, 0
        control.braking_theta, control.braking_omega = drive.theta_m - T_s * omega_m, omega_m
        control.torque_lag_1 = control.torque_lag_2 = control.load = drive.torque
    control.braking = min(control.braking + 1, 1_000_000)
    predicted = control.braking_theta + T_s * control.braking_omega
    error = wrapped(drive.theta_m - predicted)
    omega = control.braking_omega + 2.0 * omega_0 * error
    acceleration = omega_0 * omega_0 * error
    control.braking_omega += T_s * acceleration
    control.braking_theta = wrapped(predicted + 2.0 * omega_0 * T_s * error)
    share = min(1.0, omega_0 * T_s)
    # The torque asked for, so that what a law misses counts as load: but not where the voltage limits it.
    slow = abs(omega) <= _SLOW * drive.omega_m_N
    torque_made = drive.torque_reference if slow else drive.torque
    control.torque_lag_1 += share * (torque_made - control.torque_lag_1)
    control.torque_lag_2 += share * (control.torque_lag_1 - control.torque_lag_2)
    load = control.torque_lag_2 - drive.J * acceleration
    control.load += _BANDWIDTH * share * (load - control.load)
    _count(drive, control, omega)
    limit = drive.torque_limit
    control.speed_integral = min(
        max(control.load, -limit), limit
    )  # from which the speed controller continues
    torque: float = min(max(control.load - drive.J * omega_0 / _LANDING * omega, -limit), limit)
    return torque


@njit
def _count(drive: Any, control: Any, omega: float) -> None:
    """Count the ticks in which the shaft turns back, and those in which it stands."""
    if control.braking * drive.omega_observer * drive.control_period < _SETTLING:
        control.braking_sign = 1.0 if omega >= 0.0 else -1.0
    elif control.turned_ticks * drive.control_period < _TURNED_S:
        control.turned_ticks = control.turned_ticks + 1 if control.braking_sign * omega <= 0.0 else 0
    stands = abs(omega) <= _STANDSTILL * drive.omega_m_N
    control.rest_ticks = min(control.rest_ticks + 1, 1_000_000) if stands else 0


@njit
def is_at_standstill(control: Any) -> bool:
    """Return whether the speed is below 1 % of the rated one."""
    standing: bool = control.rest_ticks > 0
    return standing


@njit
def at_rest(drive: Any, control: Any) -> bool:
    """Return whether braking is complete: the speed has reached zero, or stays near it for 80 ms."""
    T_s = drive.control_period
    ended: bool = control.turned_ticks * T_s >= _TURNED_S or control.rest_ticks * T_s >= _REST_S
    return ended
