"""Energy accounts of the bench, optional: where the energy that is drawn from the dc link goes.

They are those of `energies`, since they began; `shaft` is what the rotor passes on, through an elastic
coupling if there is one; what is rigid on the rotor turns with it in `kinetic`. Each is integrated by
Simpson's rule over the steps of the machine, with the state half-way from the cubic through both ends, of the
order of the steps. Devices lose their forward voltage times the current that they carry; nothing is the
remainder of the others, so that the balance shows what a bench's equations are worth. Those of the dc link
are booked by `dc_link`, once a control period.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.asymmetry import leakage_energy, loss_in_series
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.cogging import cogging_torque
from benchtool.emulator.machine.coupling import Coupling, twist_energy
from benchtool.emulator.machine.drive_train import DriveTrain, Far, beyond, contact_of, passed_on
from benchtool.emulator.machine.energies import Accounts
from benchtool.emulator.machine.inverter import SQRT3
from benchtool.emulator.machine.iron import iron_torque
from benchtool.emulator.machine.plant import (
    airgap_torque,
    derivative,
    flux_linkages,
    scaled_voltage,
    sliding_of,
)
from benchtool.emulator.machine.saturation import Flux, Saturation, field_energy
from benchtool.emulator.machine.shaft import less_friction
from benchtool.emulator.machine.state import State, electrical, state_at, stationary_currents
from benchtool.emulator.rotate import rotate


class Powers(NamedTuple):
    """Currents in A, and powers in W, of one moment."""

    i_alpha: float
    i_beta: float
    copper: float
    devices: float
    iron: float
    friction: float
    cogging: float
    shaft: float
    coupling: float
    load: float


class Rails(NamedTuple):
    """Potentials of the rails that the legs' switches connect to, and whether a leg has neither switch on."""

    a: float
    b: float
    c: float
    off_a: bool
    off_b: bool
    off_c: bool


@njit
def finer(accounts: Accounts | None, step: float, part: float) -> float:
    """Return what a step may cover, or with accounts a part of it: a balance to 1e-9 takes finer ones."""
    return step if accounts is None else part * step


@njit
def account(
    accounts: Accounts | None,
    h: float,
    before: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    u_dc: float,
    rails: Rails,
    machine: Machine,
    T_load: float,
    record: Any,
) -> None:
    """Book a step of `h` seconds under the voltage (u_alpha, u_beta), from legs at these rails."""
    if accounts is None:
        return
    _book(accounts, h, before, after, u_alpha, u_beta, u_dc, rails, machine, T_load, record)


@called
def _book(
    accounts: Accounts,
    h: float,
    before: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    u_dc: float,
    rails: Rails,
    m: Machine,
    T_load: float,
    record: Any,
) -> None:
    contact = contact_of(m.train, before.far, before.omega_e)
    T0, far0 = beyond(m.train, before.far, before.omega_e, before.theta_e, T_load, contact)
    T2, far2 = beyond(m.train, after.far, after.omega_e, after.theta_e, T_load, contact)
    slide = sliding_of(m.friction, before, m, T0)
    far = _half_way_of(h, before.far, after.far, far0, far2)
    middle = _half_way(h, before, after, u_alpha, u_beta, slide, m, T0, T2, far)
    T1, _ = beyond(m.train, middle.far, middle.omega_e, middle.theta_e, T_load, contact)
    p0 = _powers(accounts, before, slide, m, T0, T_load, contact)
    p1 = _powers(accounts, middle, slide, m, T1, T_load, contact)
    p2 = _powers(accounts, after, slide, m, T2, T_load, contact)
    i_alpha = _simpson(h, p0.i_alpha, p1.i_alpha, p2.i_alpha)
    i_beta = _simpson(h, p0.i_beta, p1.i_beta, p2.i_beta)
    q_a = i_alpha
    q_b = -0.5 * i_alpha + 0.5 * SQRT3 * i_beta
    q_c = -0.5 * i_alpha - 0.5 * SQRT3 * i_beta
    record.E_dc += _drawn(rails.a, rails.off_a, u_dc, q_a) + _drawn(rails.b, rails.off_b, u_dc, q_b)
    record.E_dc += _drawn(rails.c, rails.off_c, u_dc, q_c)
    record.E_copper += _simpson(h, p0.copper, p1.copper, p2.copper)
    record.E_inverter += accounts.drop * (abs(q_a) + abs(q_b) + abs(q_c))
    record.E_inverter += _simpson(h, p0.devices, p1.devices, p2.devices)
    record.E_iron += _simpson(h, p0.iron, p1.iron, p2.iron)
    record.E_friction += _simpson(h, p0.friction, p1.friction, p2.friction)
    record.E_shaft += _simpson(h, p0.shaft, p1.shaft, p2.shaft)
    record.E_magnetic += _field(m.saturation, after, m) - _field(m.saturation, before, m)
    record.E_magnetic += _simpson(h, p0.cogging, p1.cogging, p2.cogging)
    record.E_coupling += _simpson(h, p0.coupling, p1.coupling, p2.coupling)
    record.E_load += _simpson(h, p0.load, p1.load, p2.load)
    _store(m.train, contact, before.far, after.far, record)
    per = 0.5 * (m.J + m.J_load) / (m.p * m.p)
    record.E_kinetic += per * (after.omega_e - before.omega_e) * (after.omega_e + before.omega_e)


@njit
def _simpson(h: float, f0: float, f1: float, f2: float) -> float:
    return h * (1.0 / 6.0) * (f0 + 4.0 * f1 + f2)


@njit
def _drawn(rail: float, off: bool, u_dc: float, charge: float) -> float:
    """Return the energy that a leg draws from the dc link; one that is off conducts through its diodes."""
    if off:
        return u_dc * min(charge, 0.0)
    return rail * charge


@called
def _powers(
    accounts: Accounts, x: State, slide: float, m: Machine, T: float, T_load: float, contact: float
) -> Powers:
    omega_m = x.omega_e / m.p
    squared = 1.5 * (x.i_d * x.i_d + x.i_q * x.i_q)
    cogging = cogging_torque(m.cogging, x.theta_e)
    dry = -less_friction(m.friction, 0.0, x.omega_e, slide, 1.0)
    friction = m.B * omega_m + dry
    y_d, y_q = electrical(m.saturation, x)
    psi_d, psi_q = flux_linkages(m.saturation, y_d, y_q, m)
    iron = iron_torque(m.iron, psi_d, psi_q, x.omega_e, m.p)
    torque = T
    if m.gamma == 0.0:  # what holds the speed takes what is left
        torque = airgap_torque(y_d, y_q, x.theta_e, m) - iron - friction - cogging
    lost, load = passed_on(m.train, x.far, omega_m, x.theta_e, T_load, contact, torque)
    i_alpha, i_beta = stationary_currents(x)
    return Powers(
        i_alpha,
        i_beta,
        (m.R_s - accounts.R_devices) * squared
        + loss_in_series(m.asymmetry, x.i_d, x.i_q, x.cos_theta, x.sin_theta),
        accounts.R_devices * squared,
        iron * omega_m,
        friction * omega_m,
        cogging * omega_m,
        torque * omega_m,
        lost,
        load,
    )


@njit
def _store(train: DriveTrain | None, contact: float, before: Far, after: Far, record: Any) -> None:
    """Book what an elastic coupling and the load behind it store."""
    if train is None:
        return
    _store_behind(train.coupling, contact, before, after, record)


@njit
def _store_behind(coupling: Coupling | None, contact: float, before: Far, after: Far, record: Any) -> None:
    if coupling is None:
        return
    if coupling.inv_J > 0.0:
        record.E_load_kinetic += (
            0.5 * (after.omega - before.omega) * (after.omega + before.omega) / coupling.inv_J
        )
    # Faces that have parted let go of what they were still bent by: they have no mass.
    record.E_coupling += record.E_twist - twist_energy(coupling.play, coupling, before.twist, contact)
    record.E_twist = twist_energy(coupling.play, coupling, after.twist, contact)


@njit
def _half_way(
    h: float,
    before: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    slide: float,
    m: Machine,
    T0: float,
    T2: float,
    far: Far,
) -> State:
    """Return the state half-way through a step, by the cubics through both ends and their rates."""
    d0, q0 = electrical(m.saturation, before)
    d1, q1 = electrical(m.saturation, after)
    v_d, v_q = scaled_voltage(before, u_alpha, u_beta, m)
    a_d, a_q, a_w, _, _ = derivative(d0, q0, before.omega_e, before.theta_e, v_d, v_q, m, T0, slide)
    v_d, v_q = scaled_voltage(after, u_alpha, u_beta, m)
    b_d, b_q, b_w, _, _ = derivative(d1, q1, after.omega_e, after.theta_e, v_d, v_q, m, T2, slide)
    eighth = 0.125 * h
    omega_e = 0.5 * (before.omega_e + after.omega_e) + eighth * (a_w - b_w)
    turned = 0.5 * (after.theta_e - before.theta_e) + eighth * (before.omega_e - after.omega_e)
    cos_theta, sin_theta = rotate(before.cos_theta, before.sin_theta, turned)
    y_d, y_q = 0.5 * (d0 + d1) + eighth * (a_d - b_d), 0.5 * (q0 + q1) + eighth * (a_q - b_q)
    theta_e = before.theta_e + turned
    return state_at(m.saturation, y_d, y_q, omega_e, theta_e, 0.0, cos_theta, sin_theta, far)


@njit
def _half_way_of(h: float, before: Far, after: Far, rate0: Far, rate2: Far) -> Far:
    """Return the load side half-way through a step, by the same cubics."""
    eighth = 0.125 * h
    return Far(
        0.5 * (before.omega + after.omega) + eighth * (rate0.omega - rate2.omega),
        0.5 * (before.twist + after.twist) + eighth * (rate0.twist - rate2.twist),
        0.5 * (before.torque + after.torque) + eighth * (rate0.torque - rate2.torque),
    )


@njit
def _field(saturation: Saturation | None, x: State, m: Machine) -> float:
    """Return the energy of the field, in J."""
    leakage = leakage_energy(m.asymmetry, x.i_d, x.i_q, x.cos_theta, x.sin_theta)
    if saturation is None:
        return 0.75 * (m.L_d * x.i_d * x.i_d + m.L_q * x.i_q * x.i_q) + leakage
    psi_d, psi_q = electrical(m.saturation, x)
    return 1.5 * field_energy(saturation, Flux(psi_d, psi_q)) + leakage
