"""Position from the encoder's count, speed from a tracking observer of second order."""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.jit import njit

TWO_PI = 2.0 * math.pi
_TURNS = 1.0 / TWO_PI  # per rad; a product is cheaper than a quotient
_DAMPING = 1.0  # both poles at -omega_observer


@njit
def wrapped(angle: float) -> float:
    """Angle in [-pi, pi)."""
    return angle - TWO_PI * math.floor(angle * _TURNS + 0.5)


@njit
def rotor_angle(count: int, drive: Any) -> float:
    """Mechanical angle of the rotor flux against phase a, 0 to 2 pi: the middle of the encoder's step."""
    angle: float = (count + 0.5) * TWO_PI / (4.0 * drive.encoder_lines) - drive.encoder_offset
    return angle - TWO_PI * math.floor(angle * _TURNS)


@njit
def track(theta_m: float, drive: Any, control: Any) -> float:
    """Mechanical speed: the observer's angle follows `theta_m` with two poles at `omega_observer`.

    At constant speed it has no lag; the first call takes the angle as it is and starts at standstill.
    """
    T_s, omega_0 = drive.control_period, drive.omega_observer
    if control.started == 0:
        control.started = 1
        control.theta_m = theta_m
        control.omega_m = 0.0
        return 0.0
    predicted = control.theta_m + T_s * control.omega_m
    error = wrapped(theta_m - predicted)
    control.omega_m += T_s * omega_0 * omega_0 * error
    control.theta_m = wrapped(predicted + 2.0 * _DAMPING * omega_0 * T_s * error)
    omega_m: float = control.omega_m
    return omega_m
