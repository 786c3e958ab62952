"""The torque at the flange between machine and load, and a transducer there with a bandwidth.

It is what the rotor passes on: the air-gap torque less cogging and friction, and less what accelerates the
rotor. Behind an elastic coupling that is the coupling's torque; what is rigid beyond the flange is driven and
accelerated by it.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.cogging import cogging_torque
from benchtool.emulator.machine.coupling import Coupling
from benchtool.emulator.machine.drive_train import DriveTrain, Flange, beyond, contact_of
from benchtool.emulator.machine.iron import iron_torque
from benchtool.emulator.machine.plant import acceleration_at, airgap_torque, flux_linkages
from benchtool.emulator.machine.shaft import friction_torque, less_friction, sliding
from benchtool.emulator.machine.state import State, electrical


@njit
def flange_torque(train: DriveTrain | None, x: State, machine: Machine, T_load: float) -> float:
    """Return the torque at the flange in Nm, positive where the machine drives the load."""
    if train is None:
        return T_load
    contact = contact_of(train, x.far, x.omega_e)
    torque, _ = beyond(train, x.far, x.omega_e, x.theta_e, T_load, contact)
    return _passed_on(train.coupling, torque, x, machine)


@njit
def _passed_on(coupling: Coupling | None, torque: float, x: State, machine: Machine) -> float:
    """Return the torque at the flange, of what the rotor feels of the load."""
    if coupling is not None:
        return torque
    y_d, y_q = electrical(machine.saturation, x)
    if machine.gamma == 0.0:  # the speed is held: the flange takes whatever there is
        made = airgap_torque(y_d, y_q, x.theta_e, machine) - cogging_torque(machine.cogging, x.theta_e)
        made -= machine.B * x.omega_e / machine.p
        psi_d, psi_q = flux_linkages(machine.saturation, y_d, y_q, machine)
        made -= iron_torque(machine.iron, psi_d, psi_q, x.omega_e, machine.p)
        return made - friction_torque(machine.friction, x.omega_e, made)
    domega = acceleration_at(x, machine, torque)
    slide = sliding(machine.friction, x.omega_e, domega, machine.gamma)
    domega = less_friction(machine.friction, domega, x.omega_e, slide, machine.gamma)
    return torque + machine.J_load * domega / machine.p


@njit
def lagged(y: float, before: float, now: float, turn: float) -> float:
    """Return a lag of first order after a time in which its cut-off turns by `turn` rad, exact for a line."""
    kept = math.exp(-turn)
    mean = (1.0 - kept) / turn
    return kept * y + (mean - kept) * before + (1.0 - mean) * now


@njit
def follow(
    train: DriveTrain | None, x: State, machine: Machine, T_load: float, transducer: Any, T_s: float
) -> float:
    """Have a transducer at the flange follow its torque from tick to tick while nothing is recorded.

    Returns what it reads, 0 without one.
    """
    if train is None:
        return 0.0
    return _follow(train.flange, train, x, machine, T_load, transducer, T_s)


@njit
def _follow(
    flange: Flange | None,
    train: DriveTrain,
    x: State,
    machine: Machine,
    T_load: float,
    transducer: Any,
    T_s: float,
) -> float:
    if flange is None:
        return 0.0
    if transducer.recording == 0:
        reading(flange, flange_torque(train, x, machine, T_load), transducer)
        transducer.until_next = T_s
    return float(transducer.flange)


@njit
def reading(flange: Flange, torque: float, transducer: Any) -> float:
    """Return what a transducer reads of a torque, `until_next` after the last one; the first it reads as it
    is."""
    if transducer.until_next == 0.0:
        transducer.flange = torque
    else:
        turn = flange.omega_c * transducer.until_next
        transducer.flange = lagged(transducer.flange, transducer.flange_before, torque, turn)
    transducer.flange_before = torque
    return float(transducer.flange)
