"""The torque reference: a limited setpoint, or the output of the speed PI around every torque law."""

from __future__ import annotations

from typing import Any

from benchtool.emulator.control.braking import at_rest, brake, is_at_standstill
from benchtool.emulator.jit import njit
from benchtool.protocol import Mode

_VELOCITY = int(Mode.VELOCITY)


@njit
def limited(torque: float, limit: float) -> float:
    """Return the torque within +-limit."""
    return min(max(torque, -limit), limit)


@njit
def torque_reference(
    drive: Any, command: Any, control: Any, omega_m: float, torque_added: float, omega_added: float
) -> float:
    """Return the torque asked of the law, within `torque_limit`; what a stimulus adds counts as part of the
    setpoint.

    Quick stop, in any mode, and halt in velocity mode brake to rest and hold it; halt in torque mode makes no
    torque. `standstill` is set when they have reached it, and once a quick stop has, `off_at_standstill`
    switches the power stage off in the same tick.
    """
    if command.quick_stop != 0 or (command.halt != 0 and command.mode == _VELOCITY):
        torque = brake(drive, control, omega_m)
        if command.quick_stop == 0:
            command.standstill = 1 if is_at_standstill(control) else 0
        elif at_rest(drive, control):
            command.standstill = 1
            if command.off_at_standstill != 0:
                command.pwm_enabled = 0
        return torque
    control.braking = 0
    if command.halt != 0:
        control.speed_integral = 0.0
        command.standstill = 1
        return 0.0
    command.standstill = 0
    if command.mode == _VELOCITY:
        return speed_pi(drive.omega_m_command + omega_added - omega_m, drive, control)
    control.speed_integral = 0.0
    return limited(drive.torque_command + torque_added, drive.torque_limit)


@njit
def speed_pi(error: float, drive: Any, control: Any) -> float:
    """Return output of the PI; its integral is held while it would drive further into the torque limit."""
    proportional = drive.K_p_speed * error
    integral = control.speed_integral + drive.K_i_speed * drive.control_period * error
    wanted = proportional + integral
    torque = limited(wanted, drive.torque_limit)
    if wanted == torque or wanted * error < 0.0:
        control.speed_integral = limited(integral, drive.torque_limit)
    return torque
