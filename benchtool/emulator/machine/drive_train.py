"""The drive train beyond the rotor: coupling, load and load machine, an optional part of the machine.

    d twist/dt = omega_m - omega_load
    J_load d omega_load/dt = T_coupling - T_load      (elastic; else the load turns as the rotor)

The rotor feels the torque of an elastic coupling, or the load itself. What is not there costs nothing; the
state of the load side is carried along in any case, untouched.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.coupling import (
    Coupling,
    contact_side,
    coupling_rate,
    coupling_torque,
    damped_power,
)
from benchtool.emulator.machine.load import (
    Curve,
    LoadMachine,
    OverAngle,
    OverTime,
    Unbalance,
    angle_torque,
    curve_slope,
    curve_torque,
    curve_turning,
    load_machine_rate,
    machine_rate,
    machine_torque,
    push,
    table_peak,
    table_stiffness,
    table_turning,
    time_torque,
    unbalance_stiffness,
    unbalance_torque,
)


class Far(NamedTuple):
    """State of the load side: speed behind an elastic coupling in rad/s, twist of that in rad, and the torque
    of a load machine with a lag. Of its rates, the same per second."""

    omega: float
    twist: float
    torque: float


class Flange(NamedTuple):
    """A torque transducer at the flange, and its cut-off in rad/s."""

    omega_c: float


class DriveTrain(NamedTuple):
    """What is beyond the rotor; `per_p` is one over the pole pairs."""

    per_p: float
    coupling: Coupling | None
    curve: Curve | None
    over_angle: OverAngle | None
    over_time: OverTime | None
    unbalance: Unbalance | None
    machine: LoadMachine | None
    flange: Flange | None


@njit
def beyond(
    train: DriveTrain | None, far: Far, omega_e: float, theta_e: float, T_load: float, contact: float
) -> tuple[float, Far]:
    """Return the torque against positive rotation that the rotor feels, and the rates of the load side.

    `T_load` is what the load machine is told to make, `contact` the side on which faces of the coupling
    touch.
    """
    if train is None:
        return T_load, far
    omega_m, theta_m = omega_e * train.per_p, theta_e * train.per_p
    omega, theta = load_side(train.coupling, far, omega_m, theta_m)
    rate = machine_rate(train.machine, far.torque, omega, T_load)
    torque = machine_torque(train.machine, far.torque, T_load) + driven_torque(train, omega, theta)
    return _coupled(train.coupling, far, omega_m, torque, rate, contact)


@njit
def driven_torque(train: DriveTrain, omega: float, theta: float) -> float:
    """Return the torque of the driven machine at its speed and angle, that of its unbalance among it."""
    torque = curve_torque(train.curve, omega) + angle_torque(train.over_angle, theta)
    return torque + unbalance_torque(train.unbalance, theta)


@njit
def load_side(coupling: Coupling | None, far: Far, omega_m: float, theta_m: float) -> tuple[float, float]:
    """Return speed and angle of the load."""
    if coupling is None:
        return omega_m, theta_m
    return far.omega, theta_m - far.twist


@njit
def _coupled(
    coupling: Coupling | None, far: Far, omega_m: float, torque: float, rate: float, contact: float
) -> tuple[float, Far]:
    if coupling is None:
        return torque, Far(0.0, 0.0, rate)
    slip = omega_m - far.omega
    passed = coupling_torque(coupling, far.twist, slip, contact)
    return passed, Far((passed - torque) * coupling.inv_J, slip, rate)


@njit
def passed_on(
    train: DriveTrain | None,
    far: Far,
    omega_m: float,
    theta_e: float,
    T_load: float,
    contact: float,
    torque: float,
) -> tuple[float, float]:
    """Return the powers that an elastic coupling's damping and the load take, of a rotor that passes on this
    torque."""
    if train is None:
        return 0.0, torque * omega_m
    return _passed_behind(train.coupling, train, far, omega_m, theta_e, T_load, contact, torque)


@njit
def _passed_behind(
    coupling: Coupling | None,
    train: DriveTrain,
    far: Far,
    omega_m: float,
    theta_e: float,
    T_load: float,
    contact: float,
    torque: float,
) -> tuple[float, float]:
    if coupling is None:
        return 0.0, torque * omega_m
    slip = omega_m - far.omega
    if coupling.inv_J == 0.0:  # what holds the load takes what is passed
        load = coupling_torque(coupling, far.twist, slip, contact)
    else:
        load = machine_torque(train.machine, far.torque, T_load)
        load += driven_torque(train, far.omega, theta_e * train.per_p - far.twist)
    return damped_power(coupling, slip, contact), load * far.omega


@njit
def ahead(train: DriveTrain | None, far: Far, rates: Far, h: float) -> Far:
    """Return the load side `h` seconds ahead at these rates."""
    if train is None:
        return far
    return Far(far.omega + h * rates.omega, far.twist + h * rates.twist, far.torque + h * rates.torque)


@njit
def stepped(train: DriveTrain | None, far: Far, a: Far, b: Far, c: Far, d: Far, h: float) -> Far:
    """Return the load side after a Runge-Kutta step of `h` with these rates at its four stages."""
    if train is None:
        return far
    sixth = h * (1.0 / 6.0)
    return Far(
        far.omega + sixth * (a.omega + 2.0 * (b.omega + c.omega) + d.omega),
        far.twist + sixth * (a.twist + 2.0 * (b.twist + c.twist) + d.twist),
        far.torque + sixth * (a.torque + 2.0 * (b.torque + c.torque) + d.torque),
    )


@njit
def contact_of(train: DriveTrain | None, far: Far, omega_e: float) -> float:
    """Return the side on which faces of a coupling with play touch, see `contact_side`."""
    if train is None:
        return 0.0
    return contact_side(train.coupling, far.twist, slip_of(train, far, omega_e))


@njit
def slip_of(train: DriveTrain, far: Far, omega_e: float) -> float:
    """Return the rate of the coupling's twist."""
    return omega_e * train.per_p - far.omega


@njit
def fastest_omega(train: DriveTrain | None, far: Far, omega_e: float) -> float:
    """Return the larger of the electrical speeds of rotor and load."""
    if train is None:
        return abs(omega_e)
    return max(abs(omega_e), abs(far.omega) / train.per_p)


@njit
def train_rate(train: DriveTrain | None, gamma: float) -> float:
    """Return a bound of the rates of the drive train at rest in 1/s; `gamma` is p / J of the rotor."""
    if train is None:
        return 0.0
    rotor = gamma * train.per_p
    load = _inv_J(train.coupling, rotor)
    stiffness = table_stiffness(train.over_angle) + unbalance_stiffness(train.unbalance)
    rate = (
        coupling_rate(train.coupling, rotor) + load * curve_slope(train.curve) + math.sqrt(load * stiffness)
    )
    return rate + load_machine_rate(train.machine, load)


@njit
def train_turning(train: DriveTrain | None, gamma: float) -> float:
    """Return the rate in 1/s that every electrical rad/s adds to `train_rate`."""
    if train is None:
        return 0.0
    load = _inv_J(train.coupling, gamma * train.per_p)
    return train.per_p * (load * curve_turning(train.curve) + table_turning(train.over_angle))


@njit
def acceleration_of(train: DriveTrain | None, far: Far, omega_e: float, gamma: float, T_load: float) -> float:
    """Return a bound of the acceleration by the load within a period, in electrical rad/s2."""
    if train is None:
        return gamma * abs(T_load)
    omega, _ = load_side(train.coupling, far, omega_e * train.per_p, 0.0)
    torque = push(train.machine, far.torque, omega, T_load) + table_peak(train.over_angle)
    return _inv_J(train.coupling, gamma * train.per_p) * torque / train.per_p


@njit
def _inv_J(coupling: Coupling | None, rotor: float) -> float:
    """Return 1 / J of what the load acts upon: of the load behind an elastic coupling, else of the rotor."""
    if coupling is None:
        return rotor
    return coupling.inv_J


# ---- what is told to the load ------------------------------------------------------------------------------


@njit
def asked_torque(train: DriveTrain | None, load: Any, T_s: float) -> float:
    """Return the torque that the load machine is told to make in the period that begins."""
    if train is None:
        return float(load.torque_Nm)
    return float(load.torque_Nm) + time_torque(train.over_time, load, T_s)


@njit
def is_ideal(train: DriveTrain | None) -> bool:
    """Return whether a speed is held at any torque, by a load machine without limits."""
    if train is None:
        return True
    return _is_ideal(train.machine)


@njit
def _is_ideal(machine: LoadMachine | None) -> bool:
    return machine is None


@njit
def holds_rotor(train: DriveTrain | None) -> bool:
    """Return whether a speed that is held is the rotor's: no coupling gives way, nor the load machine."""
    if train is None:
        return True
    return _is_ideal(train.machine) and _is_rigid(train.coupling)


@njit
def _is_rigid(coupling: Coupling | None) -> bool:
    return coupling is None


@njit
def told(train: DriveTrain | None, held: bool, omega_m: float) -> DriveTrain | None:
    """Return the drive train with its load machine told to hold a speed, or not to."""
    if train is None:
        return train
    return DriveTrain(
        train.per_p,
        _held(train.coupling, held and _is_ideal(train.machine)),
        train.curve,
        train.over_angle,
        train.over_time,
        train.unbalance,
        _told(train.machine, held, omega_m),
        train.flange,
    )


@njit
def _held(coupling: Coupling | None, held: bool) -> Coupling | None:
    if coupling is None:
        return coupling
    return Coupling(coupling.stiffness, coupling.damping, 0.0 if held else coupling.inv_J, coupling.play)


@njit
def _told(machine: LoadMachine | None, held: bool, omega_m: float) -> LoadMachine | None:
    if machine is None:
        return machine
    return LoadMachine(machine.omega_c, machine.stiffness, machine.limit, held, omega_m)
