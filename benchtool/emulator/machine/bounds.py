"""What can be computed: machines whose fastest process turns by no more than so much in a PWM period.

A step of the integration covers a small part of a radian of the fastest process, so that beyond this bound
a period takes thousands of them, and a run has no end that is worth waiting for.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.machine.asymmetry import series_resistance
from benchtool.emulator.machine.coefficients import MOST_TURN, Machine, fastest_rate
from benchtool.emulator.machine.harmonics import linkage
from benchtool.emulator.machine.iron import iron_slope
from benchtool.emulator.machine.saturation import Flux, incremental, largest
from benchtool.emulator.machine.state import flux_of, place
from benchtool.emulator.machine.train_truth import NOTHING, TrainTruth
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.errors import EmulationError, ValueRefused


def require_computable(motor: MotorTruth, T_s: float, train: TrainTruth = NOTHING) -> None:
    """Refuse a machine that is too fast at standstill already.

    Raises:
        ValueRefused: it is; the keys of the fastest process are named.
    """
    machine = machine_of_bench(motor, train)
    flux = flux_of(machine.saturation, 0.0, 0.0, Flux(machine.psi_r, 0.0))
    rate = fastest_rate(machine, place(0.0, 0.0, 0.0, 0.0, flux))
    if rate * T_s <= MOST_TURN:
        return
    L = min(motor.L_d_H, motor.L_q_H)
    J = motor.J_kgm2 + train.rigid_kgm2
    per_inertia = motor.pole_pairs / J
    psi = machine.psi_r + linkage(machine.harmonics)
    R = motor.R_s_ohm + series_resistance(machine.asymmetry)
    stiffness = 1.5 * motor.pole_pairs * psi**2 / L
    slope = max(motor.breakaway_Nm - motor.coulomb_Nm, 0.0) / max(motor.stribeck_rad_s, 1e-300)
    friction = (motor.friction_Nms + (slope if motor.stribeck_rad_s > 0.0 else 0.0)) / motor.pole_pairs
    friction += iron_slope(machine.iron, psi, machine.p)
    cogging = motor.cogging_stiffness_Nm / motor.pole_pairs
    processes = {
        f"motor.R_s_ohm (and series_R_ohm) = {R:g} over L_d_H or L_q_H = {L:g}": R / L,
        f"motor.psi_r_Wb (and its harmonics) = {psi:g} with L_d_H or L_q_H = {L:g} and "
        f"J_kgm2 = {motor.J_kgm2:g}": math.sqrt(per_inertia * stiffness),
        f"motor.cogging_Nm = {str(motor.cogging_Nm).strip('(),')} with J_kgm2 = {motor.J_kgm2:g}": math.sqrt(
            per_inertia * cogging
        ),
        f"motor.friction_Nms = {motor.friction_Nms:g}, stribeck_rad_s = {motor.stribeck_rad_s:g} and "
        f"R_fe_ohm = {motor.R_fe_ohm:g} over "
        f"J_kgm2 = {motor.J_kgm2:g}": per_inertia * friction,
        **dict(train.processes(motor.J_kgm2)),
    }
    fastest = max(processes, key=lambda name: processes[name])
    raise ValueRefused(
        f"emulator.{fastest} makes a process of {rate:.3g} 1/s, the emulated machine can be computed "
        f"up to {MOST_TURN / T_s:.3g} 1/s: correct them, in [emulator] or in [motor]"
    )


def machine_of_bench(motor: MotorTruth, train: TrainTruth, devices_ohm: float = 0.0) -> Machine:
    """Return the machine with what is beyond its rotor, and devices of this resistance in each phase."""
    return motor.machine(False, devices_ohm, train.rigid_kgm2, train.train(motor.pole_pairs))


def runaway(shaft: Any, load: Any, motor: MotorTruth, time_s: float) -> EmulationError:
    """Return what has become of a machine that can no longer be computed, from its records `shaft` and
    `load`."""
    omega_m = load.omega_m_rad_s if load.held else shaft.omega_m
    if not math.isfinite(shaft.i_d + shaft.i_q):
        seen = f"its currents (i_d, i_q) are ({shaft.i_d:g}, {shaft.i_q:g}) A"
        remedy = "correct R_s_ohm, L_d_H, L_q_H or u_dc_V of [emulator]"
    elif not _has_inverse(motor, shaft):
        seen = (
            f"its flux linkages (psi_d, psi_q) are ({shaft.psi_d:g}, {shaft.psi_q:g}) Wb, where currents "
            f"fall with rising flux"
        )
        remedy = "lower a_dq in [emulator.motor.saturation], or stay at lower currents"
    elif load.held:
        seen = f"it is held at {omega_m:.3g} rad/s"
        remedy = "hold it at a lower speed"
    else:
        seen = f"{load.torque_Nm:g} Nm of load on J_kgm2 = {motor.J_kgm2:g}, at {omega_m:.3g} rad/s"
        remedy = "lower the load, or raise J_kgm2 in [emulator.motor] or [motor]"
    return EmulationError(
        f"the emulated machine is too fast to be computed after {time_s:.4f} s: {seen}; {remedy}"
    )


def _has_inverse(motor: MotorTruth, shaft: Any) -> bool:
    saturation = motor.machine().saturation
    if saturation is None:
        return True
    return math.isfinite(largest(incremental(saturation, shaft.psi_d, shaft.psi_q)))
