"""Faults of motor, sensors, dc link and load machine: other numbers of what the kernel computes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

from benchtool.emulator.faults.context import Context, Undo
from benchtool.emulator.faults.declaration import Fault
from benchtool.emulator.machine.truth import MotorTruth


def _phase_sensor(context: Context, fault: Fault, **changes: float) -> Undo:
    name = f"i_{fault.word('phase')}"
    before = getattr(context.core.sensors, name)
    _replace_sensor(context, name, replace(before, **changes))
    return lambda: _replace_sensor(context, name, before)


def _replace_sensor(context: Context, name: str, sensor: Any) -> None:
    context.change_sensors(replace(context.core.sensors, **{name: sensor}))


def _current_gain(context: Context, fault: Fault) -> Undo:
    return _phase_sensor(context, fault, gain=fault.number("gain"))


def _current_offset(context: Context, fault: Fault) -> Undo:
    return _phase_sensor(context, fault, offset_A=fault.number("offset_A"))


def _current_stuck(context: Context, fault: Fault) -> Undo:
    return _phase_sensor(context, fault, stuck_A=fault.number("value_A"))


def _encoder_loss(context: Context, fault: Fault) -> Undo:
    core, stuck, disc_rad = context.core, context.core.sensors.encoder.stuck, context.core.disc_rad
    _replace_sensor(context, "encoder", replace(core.sensors.encoder, stuck=True))
    context.firmware.encoder_connected = False

    def plug_in() -> None:
        _replace_sensor(context, "encoder", replace(core.sensors.encoder, stuck=stuck))
        core.disc_rad = disc_rad  # where it was: what was not counted meanwhile is set right as well
        context.firmware.encoder_connected = True

    return plug_in


def _encoder_offset(context: Context, fault: Fault) -> Undo:
    def turn(angle_rad: float) -> None:
        sensors = context.core.sensors
        context.change_sensors(replace(sensors, encoder_offset_rad=sensors.encoder_offset_rad + angle_rad))

    turn(fault.number("angle_rad"))
    return lambda: turn(-fault.number("angle_rad"))


def _encoder_slip(context: Context, fault: Fault) -> Undo:
    core, slip, disc_rad = context.core, context.core.sensors.encoder.slip, context.core.disc_rad
    _replace_sensor(context, "encoder", replace(core.sensors.encoder, slip=fault.number("share")))

    def tighten() -> None:
        _replace_sensor(context, "encoder", replace(core.sensors.encoder, slip=slip))
        core.disc_rad = disc_rad

    return tighten


def _with_motor(context: Context, motor: MotorTruth) -> Undo:
    before = context.core.motor
    context.core.set_motor(motor)
    return lambda: context.core.set_motor(before)


def open_phase(motor: MotorTruth, fault: Fault) -> MotorTruth:
    """Return the motor with a phase that is open."""
    a, b, c = (fault.number("R_ohm") if phase == fault.word("phase") else 0.0 for phase in "abc")
    return replace(motor, series_R_ohm=(a, b, c))


def _phase_open(context: Context, fault: Fault) -> Undo:
    return _with_motor(context, open_phase(context.core.motor, fault))


def _phases_swapped(context: Context, fault: Fault) -> Undo:
    context.core.swap_phases()
    return context.core.swap_phases


def _dc_link(context: Context, u_dc_V: float) -> Undo:
    before_V = context.core.inverter.u_dc_V
    context.core.set_dc_link(u_dc_V)
    return lambda: context.core.set_dc_link(before_V)


def _dc_link_sag(context: Context, fault: Fault) -> Undo:
    return _dc_link(context, fault.number("of_level") * context.firmware.objects["u_dc_min"])


def _dc_link_overvoltage(context: Context, fault: Fault) -> Undo:
    return _dc_link(context, fault.number("of_level") * context.firmware.objects["u_dc_max"])


def _overcurrent(context: Context, fault: Fault) -> Undo:
    motor, left = context.core.motor, fault.number("of_inductance")
    return _with_motor(context, replace(motor, L_d_H=left * motor.L_d_H, L_q_H=left * motor.L_q_H))


def _overspeed(context: Context, fault: Fault) -> Undo:
    load = context.core.load
    before = int(load.held), float(load.omega_m_rad_s)
    load.omega_m_rad_s = fault.number("of_level") * float(context.firmware.objects["omega_m_trip"])
    load.held = 1

    def let_go() -> None:
        load.held, load.omega_m_rad_s = before

    return let_go


def _overtemperature(context: Context, fault: Fault) -> Undo:
    context.firmware.thermal_switch_closed = False

    def cool_down() -> None:
        context.firmware.thermal_switch_closed = True

    return cool_down


EFFECTS: Final = {
    "encoder_loss": _encoder_loss,
    "encoder_offset": _encoder_offset,
    "encoder_slip": _encoder_slip,
    "phase_open": _phase_open,
    "phases_swapped": _phases_swapped,
    "current_gain": _current_gain,
    "current_offset": _current_offset,
    "current_stuck": _current_stuck,
    "dc_link_sag": _dc_link_sag,
    "dc_link_overvoltage": _dc_link_overvoltage,
    "overcurrent": _overcurrent,
    "overspeed": _overspeed,
    "overtemperature": _overtemperature,
}
