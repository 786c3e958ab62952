"""One control tick: measurements in, signals into the drive's memory, duties for the next period out."""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.current_sensors import calibrate, correct
from benchtool.emulator.control.estimation import (
    StateEstimate,
    clarke,
    into_frame,
    out_of_frame,
    predict,
    state_estimate,
)
from benchtool.emulator.control.field_weakening import reference
from benchtool.emulator.control.injection import current_vector
from benchtool.emulator.control.laws import demand, limits, reset_law
from benchtool.emulator.control.observer import accelerating_torque, rotor_angle, track
from benchtool.emulator.control.protection import overload, trips
from benchtool.emulator.control.speed import torque_reference
from benchtool.emulator.control.stimulus import Quantity, direction_of, play
from benchtool.emulator.control.svpwm import compensated, modulate
from benchtool.emulator.control.vectors import MODULATED, held
from benchtool.emulator.jit import njit, separately
from benchtool.protocol import Mode

_VOLTAGE_MODE, _CURRENT_MODE = int(Mode.VOLTAGE), int(Mode.CURRENT)
_ACB = 1  # of `phase_order`
_TORQUE, _SPEED, _D_CURRENT = int(Quantity.TORQUE), int(Quantity.SPEED), int(Quantity.D_CURRENT)


@separately
def control_tick(drive: Any, command: Any, control: Any, stimulus: Any, measurement: Any) -> bool:
    """Run control once. Returns whether a trip was raised that was not there before."""
    _load_shadow(control)
    calibrate(drive, command, measurement)
    correct(drive, measurement)
    now = _observe(drive, command, control, measurement)
    new_trip = _protect(drive, command, control, measurement)
    if command.pwm_enabled == 0:
        _stand_by(drive, command, control)
        return new_trip
    added = play(stimulus, drive.tick)
    drive.stimulus = added
    at = now
    if drive.delay_compensation != 0:
        at = predict(now, control.u_alpha, control.u_beta, drive)
    _begin_injection(command, control)
    if command.mode == _VOLTAGE_MODE and command.quick_stop == 0:
        command.standstill = command.halt
        cosine, sine = direction_of(stimulus, at.cos_theta, at.sin_theta)
        reset_law(control)
        _inject(added * cosine, added * sine, at, drive, control, measurement.u_dc)
        return new_trip
    if control.injecting != 0:
        command.standstill = command.halt
        cosine, sine = direction_of(stimulus, now.cos_theta, now.sin_theta)
        u_alpha, u_beta = current_vector(added, cosine, sine, now, drive, control)
        _inject(u_alpha, u_beta, now, drive, control, measurement.u_dc)
        return new_trip
    torque_added = added if stimulus.quantity == _TORQUE else 0.0
    omega_added = added if stimulus.quantity == _SPEED else 0.0
    i_d_added = added if stimulus.quantity == _D_CURRENT else 0.0
    integral = control.speed_integral
    wanted = torque_reference(drive, command, control, drive.omega_m, torque_added, omega_added)
    torque, psi_s, given_way = reference(wanted, i_d_added, now.omega_e, limits(drive), drive)
    if control.speed_integral != 0.0 and (control.speed_integral - integral) * (wanted - torque) > 0.0:
        control.speed_integral = integral  # it would only drive further into the limit
    asked = demand(at, torque, psi_s, drive, control)
    if asked.vector == MODULATED:
        limited = _modulate(asked.u_alpha, asked.u_beta, at, drive, control, measurement.u_dc)
    else:
        limited = _hold(asked.vector, drive, control, measurement.u_dc)
    drive.torque_reference = torque
    drive.psi_s_reference = psi_s
    drive.law_angle = asked.angle
    drive.u_alpha = control.u_alpha_next
    drive.u_beta = control.u_beta_next
    if asked.clipped or limited or given_way:
        drive.law_clipped += 1
    return new_trip


@njit
def _load_shadow(control: Any) -> None:
    """Apply what was computed in the tick before to the period that begins now."""
    control.gated = control.gated_next
    control.u_alpha, control.u_beta = control.u_alpha_next, control.u_beta_next
    control.duty_a = control.duty_a_next
    control.duty_b = control.duty_b_next
    control.duty_c = control.duty_c_next


@njit
def _observe(drive: Any, command: Any, control: Any, measurement: Any) -> StateEstimate:
    """Return the signals that need no more than the measurements."""
    theta_m = rotor_angle(measurement.count, drive)
    omega_m = track(theta_m, accelerating_torque(drive, command), drive, control)
    theta_e = drive.pole_pairs * theta_m
    cos_theta, sin_theta = math.cos(theta_e), math.sin(theta_e)
    i_alpha, i_beta = clarke(measurement.i_a, measurement.i_b, measurement.i_c)
    i_d, i_q = into_frame(i_alpha, i_beta, cos_theta, sin_theta)
    now = state_estimate(i_d, i_q, drive.pole_pairs * omega_m, cos_theta, sin_theta, drive)
    drive.i_a, drive.i_b, drive.i_c = measurement.i_a, measurement.i_b, measurement.i_c
    drive.i_d, drive.i_q = i_d, i_q
    drive.u_dc = measurement.u_dc
    drive.theta_m, drive.omega_m = theta_m, omega_m
    drive.torque = now.torque
    drive.psi_s = math.sqrt(now.psi_d * now.psi_d + now.psi_q * now.psi_q)
    drive.psi_alpha, drive.psi_beta = out_of_frame(now.psi_d, now.psi_q, cos_theta, sin_theta)
    drive.adc_saturated += measurement.saturated
    return now


@njit
def _protect(drive: Any, command: Any, control: Any, measurement: Any) -> bool:
    """Latch trips and keep the power stage off while one is latched."""
    raised = trips(drive, measurement, drive.omega_m, command.pwm_enabled != 0)
    raised |= overload(drive, control, measurement)
    new_trip: bool = (raised & ~command.trip) != 0
    command.trip |= raised
    if command.trip != 0:
        command.pwm_enabled = 0
    return new_trip


@njit
def _stand_by(drive: Any, command: Any, control: Any) -> None:
    """Power stage off: no voltage, no references, no memory of the speed loop or of a law."""
    reset_law(control)
    control.gated = 0
    control.gated_next = 0
    control.u_alpha_next, control.u_beta_next = 0.0, 0.0
    control.speed_integral = 0.0
    control.braking = 0
    if command.quick_stop == 0:  # else the firmware has to see the cause first
        command.standstill = 0
    drive.u_alpha, drive.u_beta = 0.0, 0.0
    drive.torque_reference, drive.psi_s_reference, drive.law_angle = 0.0, 0.0, 0.0
    drive.stimulus = 0.0


@njit
def _begin_injection(command: Any, control: Any) -> None:
    """Have neither the current mode nor a law go on with what the other remembers."""
    injecting = 1 if command.mode == _CURRENT_MODE and command.quick_stop == 0 else 0
    if control.injecting != injecting:
        reset_law(control)
        control.injecting = injecting


@njit
def _inject(u_alpha: float, u_beta: float, at: StateEstimate, drive: Any, control: Any, u_dc: float) -> None:
    """Put out the voltage of a stimulus, or of its current; no law runs, and there are no references."""
    if _modulate(u_alpha, u_beta, at, drive, control, u_dc):
        drive.law_clipped += 1
    control.speed_integral = 0.0
    drive.u_alpha, drive.u_beta = control.u_alpha_next, control.u_beta_next
    drive.torque_reference, drive.psi_s_reference, drive.law_angle = 0.0, 0.0, 0.0


@njit
def _modulate(
    u_alpha: float, u_beta: float, at: StateEstimate, drive: Any, control: Any, u_dc: float
) -> bool:
    """Put the duties of a voltage into the shadow register. Returns whether the hexagon limited it."""
    made = modulate(u_alpha, u_beta, u_dc)
    duty_a, duty_b, duty_c = made.duty_a, made.duty_b, made.duty_c
    if drive.dead_time_compensation > 0.0:
        share = drive.dead_time_compensation / drive.pwm_period
        i_alpha, i_beta = out_of_frame(at.i_d, at.i_q, at.cos_theta, at.sin_theta)
        across = 0.5 * math.sqrt(3.0) * i_beta
        duty_a = compensated(duty_a, i_alpha, share)
        duty_b = compensated(duty_b, across - 0.5 * i_alpha, share)
        duty_c = compensated(duty_c, -across - 0.5 * i_alpha, share)
    _load_duties(duty_a, duty_b, duty_c, drive, control)
    control.u_alpha_next, control.u_beta_next = made.u_alpha, made.u_beta
    control.gated_next = 1
    control.limited = 1 if made.limited else 0
    return made.limited


@njit
def _hold(vector: int, drive: Any, control: Any, u_dc: float) -> bool:
    """Put a vector for the whole period into the shadow register. It is within the hexagon: never limited."""
    made = held(vector, u_dc)
    _load_duties(made.duty_a, made.duty_b, made.duty_c, drive, control)
    control.u_alpha_next, control.u_beta_next = made.u_alpha, made.u_beta
    control.gated_next = 1
    control.limited = 0
    return False


@njit
def _load_duties(duty_a: float, duty_b: float, duty_c: float, drive: Any, control: Any) -> None:
    """Put the duties of the motor's phases on the outputs that they are on."""
    if drive.phase_order == _ACB:
        duty_b, duty_c = duty_c, duty_b
    control.duty_a_next, control.duty_b_next, control.duty_c_next = duty_a, duty_b, duty_c
