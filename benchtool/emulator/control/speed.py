"""The torque reference: a limited setpoint, or the speed PI that stands around every torque law."""

from __future__ import annotations

from typing import Any

from benchtool.emulator.jit import njit
from benchtool.protocol.modes import Mode

_VELOCITY = int(Mode.VELOCITY)
_STANDSTILL = 0.01  # of the rated speed


@njit
def limited(torque: float, limit: float) -> float:
    """Torque within +-limit."""
    return min(max(torque, -limit), limit)


@njit
def torque_reference(
    drive: Any, command: Any, control: Any, omega_m: float, torque_added: float, omega_added: float
) -> float:
    """Torque asked of the law, within `torque_limit`; what a stimulus adds counts as part of the setpoint.

    Velocity mode and quick stop close the speed loop; a quick stop is a speed setpoint of zero in either
    mode, and marks `standstill` below 1 % of the rated speed.
    """
    if command.quick_stop != 0:
        if abs(omega_m) <= _STANDSTILL * drive.omega_m_N:
            command.standstill = 1
        return speed_pi(0.0 - omega_m, drive, control)
    command.standstill = 0
    if command.mode == _VELOCITY:
        return speed_pi(drive.omega_m_command + omega_added - omega_m, drive, control)
    control.speed_integral = 0.0
    return limited(drive.torque_command + torque_added, drive.torque_limit)


@njit
def speed_pi(error: float, drive: Any, control: Any) -> float:
    """PI whose integral stands still while it would drive further into the torque limit."""
    proportional = drive.K_p_speed * error
    integral = control.speed_integral + drive.K_i_speed * drive.control_period * error
    wanted = proportional + integral
    torque = limited(wanted, drive.torque_limit)
    if wanted == torque or wanted * error < 0.0:
        control.speed_integral = limited(integral, drive.torque_limit)
    return torque
