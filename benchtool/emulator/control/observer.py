"""Position from the encoder's count, speed from a third-order observer with torque feedforward."""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.jit import njit
from benchtool.protocol import Mode

_VELOCITY = int(Mode.VELOCITY)
TWO_PI = 2.0 * math.pi
_TURNS = 1.0 / TWO_PI  # per rad; a product is cheaper than a quotient
SETTLED = -1  # of `angles`
_FIRST = (
    8  # ticks of standstill assumed at the start: else the encoder's first step would be 2 pi / 4N in a tick
)


@njit
def wrapped(angle: float) -> float:
    """Return the angle in [-pi, pi)."""
    return angle - TWO_PI * math.floor(angle * _TURNS + 0.5)


@njit
def rotor_angle(count: int, drive: Any) -> float:
    """Return the mechanical angle of the rotor flux against phase a, 0 to 2 pi: the middle of the encoder's
    step."""
    counted = drive.encoder_direction * (count + 0.5) * TWO_PI / (4.0 * drive.encoder_lines)
    angle: float = counted - drive.encoder_offset
    return angle - TWO_PI * math.floor(angle * _TURNS)


@njit
def shift(count: int, drive: Any, control: Any) -> None:
    """Have the observer's angle move with an encoder whose index has just moved its counter: nothing has
    turned."""
    if count != 0:
        turned = drive.encoder_direction * (float(count) * TWO_PI / (4.0 * drive.encoder_lines))
        control.theta_m = wrapped(control.theta_m + turned)


@njit
def accelerating_torque(drive: Any, command: Any) -> float:
    """Return the air-gap torque of the tick before while the speed loop is closed, else 0.

    That is where the speed loop is closed. In torque mode something else sets the speed, a load machine as a
    rule: against a held shaft the torque would pass for an acceleration that there is not. And a power stage
    that is off makes no torque, whatever the offset of the current sensors.
    """
    moves = command.mode == _VELOCITY or command.quick_stop != 0
    torque: float = drive.torque if command.pwm_enabled != 0 and moves else 0.0
    return torque


@njit
def track(theta_m: float, torque: float, drive: Any, control: Any) -> float:
    """Return mechanical speed: angle, speed and load follow `theta_m` with three poles at `omega_observer`.

    `torque` (`accelerating_torque`) over `J` is fed forward, so that the machine's own torque leaves no lag;
    `J` = 0 feeds nothing forward. The third state is the acceleration by all that is not fed forward: the
    load, friction, a wrong `J`. With it a constant acceleration of any origin leaves no lag either.

    The gains put all poles at z = exp(-omega_observer T_s): the critically damped g-h-k filter (Brookner,
    Tracking and Kalman Filtering Made Easy, 1998, 1.3), stable at any bandwidth. To a shaft that turns at the
    first call it would overshoot by a quarter of its speed. It therefore begins with the gains of the
    expanding-memory filter, the straight line of least squares through all angles so far (the same book),
    until these are no longer larger.
    """
    T_s = drive.control_period
    if control.angles == 0:
        control.angles = _FIRST
        control.theta_m = theta_m
        control.omega_m, control.acceleration = 0.0, 0.0
        return 0.0
    acceleration = control.acceleration
    if drive.J > 0.0:
        acceleration += torque / drive.J
    step = T_s * acceleration
    predicted = control.theta_m + T_s * (control.omega_m + 0.5 * step)
    error = wrapped(theta_m - predicted)
    z = math.exp(-drive.omega_observer * T_s)
    g, h, k = 1.0 - z * z * z, 1.5 * (1.0 + z) * (1.0 - z) * (1.0 - z), (1.0 - z) * (1.0 - z) * (1.0 - z)
    if control.angles > 0:
        n = float(control.angles)
        of_line = 6.0 / ((n + 1.0) * (n + 2.0))
        if of_line > h:
            g, h, k = (2.0 * n + 1.0) * of_line / 3.0, of_line, 0.0
            control.angles += 1
        else:
            control.angles = SETTLED
    per_T_s = 1.0 / T_s
    control.theta_m = wrapped(predicted + g * error)
    control.omega_m += step + h * error * per_T_s
    control.acceleration += k * error * per_T_s * per_T_s
    omega_m: float = control.omega_m
    return omega_m
