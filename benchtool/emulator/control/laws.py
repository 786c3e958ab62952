"""The torque laws by number, chosen at run time by object `law`."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import Any, NamedTuple

from benchtool.emulator.control import deadbeat, dtc, fcs_mpc, foc, svm_dtc, tpc, tpc_stator
from benchtool.emulator.control.estimation import SQRT3, StateEstimate, into_frame
from benchtool.emulator.control.field_weakening import Limits
from benchtool.emulator.control.fixed_voltage import mean_voltage
from benchtool.emulator.control.flux_comparator import threshold
from benchtool.emulator.control.vectors import MODULATED, held
from benchtool.emulator.jit import njit
from benchtool.emulator.rotate import rotate


class Law(IntEnum):
    """Values of object `law`."""

    TPC = 0
    TPC_STATOR = 1
    SVM_DTC = 2
    DTC = 3
    FCS_MPC = 4
    FOC = 5
    DEADBEAT = 6


_TPC, _TPC_STATOR, _SVM_DTC = int(Law.TPC), int(Law.TPC_STATOR), int(Law.SVM_DTC)
_DTC, _FCS_MPC, _FOC, _DEADBEAT = int(Law.DTC), int(Law.FCS_MPC), int(Law.FOC), int(Law.DEADBEAT)


# Of the largest mean voltage in the steady state; the rest corrects errors.
_OF_FIXED_VOLTAGE, _OF_ONE_VECTOR, _OF_MODULATOR = 0.94, 0.9, 0.95


class Demand(NamedTuple):
    """Output of a law for a period.

    A mean voltage for the modulator, or, where `vector` is not `MODULATED`, that vector for the whole period.
    `angle` is that of the voltage against the rotor flux at the period's end; with `tpc_stator` against the
    stator flux. `clipped`: the reference could not be reached.
    """

    u_alpha: float
    u_beta: float
    vector: int
    angle: float
    clipped: bool


@njit
def demand(at: StateEstimate, torque: float, psi_s: float, drive: Any, control: Any) -> Demand:
    """Run the chosen law for the period that begins in the state estimate `at`.

    Inconsistent parameters (no flux, no voltage) and an unknown law give no voltage, and count as clipped.
    """
    u_alpha, u_beta, vector, angle, clipped = 0.0, 0.0, MODULATED, 0.0, False
    law = drive.law
    if law == _TPC:
        raise_below = threshold(psi_s, at, drive, control)
        u_alpha, u_beta, angle, clipped = tpc.voltage(at, torque, raise_below, drive)
    elif law == _TPC_STATOR:
        raise_below = threshold(psi_s, at, drive, control)
        u_alpha, u_beta, angle, clipped = tpc_stator.voltage(at, torque, psi_s, raise_below, drive)
    elif law == _SVM_DTC:
        u_alpha, u_beta = svm_dtc.voltage(at, torque, psi_s, drive, control)
    elif law == _DTC:
        vector = dtc.vector(at, torque, psi_s, drive, control)
    elif law == _FCS_MPC:
        vector = fcs_mpc.vector(at, torque, psi_s, drive, control)
    elif law == _FOC:
        u_alpha, u_beta, clipped = foc.voltage(at, torque, psi_s, drive, control)
    elif law == _DEADBEAT:
        u_alpha, u_beta, clipped = deadbeat.voltage(at, torque, psi_s, drive)
    else:
        clipped = True
    if vector != MODULATED:
        switched = held(vector, drive.u_dc)
        u_alpha, u_beta = switched.u_alpha, switched.u_beta
    if not (math.isfinite(u_alpha) and math.isfinite(u_beta)):
        reset_law(control)
        return Demand(0.0, 0.0, MODULATED, 0.0, True)
    if law != _TPC and law != _TPC_STATOR:
        angle = _against_rotor(u_alpha, u_beta, at, drive)
    return Demand(u_alpha, u_beta, vector, angle, clipped)


@njit
def limits(drive: Any) -> Limits:
    """Return what the chosen law can use of voltage and current in the steady state.

    A law needs some of its voltage to correct errors with. It keeps the current so far below the trip level
    that its own ripple does not trip: a share for noise and overshoot, and, where the length of the voltage
    is not free, 1.5 steps of a period's voltage; 2.5 with dtc, whose table looks no step ahead.
    """
    law = drive.law
    if law in (_TPC, _TPC_STATOR):
        u = mean_voltage(drive)
        steps = 1.5 * u
        u *= _OF_FIXED_VOLTAGE
    elif law in (_DTC, _FCS_MPC):
        u = _OF_ONE_VECTOR * drive.u_dc / SQRT3
        steps = (2.5 if law == _DTC else 1.5) * drive.u_dc * (2.0 / 3.0)
    else:
        u = _OF_MODULATOR * drive.u_dc / SQRT3
        steps = 0.0
    ripple = steps * drive.control_period / min(drive.L_d, drive.L_q)
    return Limits(u, max(0.95 * drive.i_trip - ripple, 0.5 * drive.i_trip))


@njit
def reset_law(control: Any) -> None:
    """Reset the state that the laws keep from period to period."""
    control.limited = 0
    control.flux_error_sum = 0.0
    control.delta_integral = 0.0
    control.torque_state, control.flux_state = 0, 0
    control.u_d_integral, control.u_q_integral = 0.0, 0.0
    control.u_alpha_asked, control.u_beta_asked = 0.0, 0.0


@njit
def _against_rotor(u_alpha: float, u_beta: float, at: StateEstimate, drive: Any) -> float:
    cos_theta, sin_theta = rotate(at.cos_theta, at.sin_theta, at.omega_e * drive.control_period)
    u_d, u_q = into_frame(u_alpha, u_beta, cos_theta, sin_theta)
    return math.atan2(u_q, u_d)
