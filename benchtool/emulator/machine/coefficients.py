"""The machine's parameters and the coefficients of its equations, and how fast its processes are."""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.asymmetry import (
    Asymmetry,
    asymmetric_turning,
    series_resistance,
)
from benchtool.emulator.machine.cogging import Cogging, cogging_stiffness, cogging_turning
from benchtool.emulator.machine.drive_train import (
    DriveTrain,
    fastest_omega,
    holds_rotor,
    told,
    train_rate,
    train_turning,
)
from benchtool.emulator.machine.harmonics import (
    Harmonics,
    harmonic_turning,
    linkage,
    weakened,
)
from benchtool.emulator.machine.heat import Heat
from benchtool.emulator.machine.iron import Iron, iron_slope
from benchtool.emulator.machine.saturation import Saturation, incremental, largest, magnetised
from benchtool.emulator.machine.shaft import Friction, stribeck_slope
from benchtool.emulator.machine.state import State, electrical

MOST_TURN = 100.0  # rad of the fastest process in a control period: beyond, a period takes too many steps


class Machine(NamedTuple):
    """True parameters, and below them the equations' coefficients as `machine_of` derives them.

    Voltages are integrated divided by their axis' inductance and torques times p / J, which leaves the fewest
    operations between one stage and the next. Where the machine saturates its flux linkages are integrated in
    place of the currents, by the same equations with an inductance of 1.
    """

    p: float
    R_s: float
    L_d: float
    L_q: float
    psi_r: float
    J: float
    B: float
    saturation: Saturation | None
    harmonics: Harmonics | None
    asymmetry: Asymmetry | None
    iron: Iron | None
    cogging: Cogging | None
    friction: Friction | None
    J_load: float  # rigid beyond the flange
    train: DriveTrain | None

    inv_L_d: float  # zero with open terminals
    inv_L_q: float
    rho_d: float  # R_s / L_d
    rho_q: float
    k_d: float  # L_q / L_d
    k_q: float
    epsilon: float  # psi_r / L_q, the back EMF; zero with open terminals, and for flux linkages
    gamma: float  # p / (J + J_load); zero with held speed, as are the three below
    kappa: float  # gamma 3/2 p psi_r
    sigma: float  # gamma 3/2 p (L_d - L_q)
    beta: float  # gamma B / p


@njit
def machine_of(
    p: float,
    R_s: float,
    L_d: float,
    L_q: float,
    psi_r: float,
    J: float,
    B: float,
    saturation: Saturation | None,
    harmonics: Harmonics | None,
    asymmetry: Asymmetry | None,
    iron: Iron | None,
    cogging: Cogging | None,
    friction: Friction | None,
    J_load: float,
    train: DriveTrain | None,
    speed_held: bool,
    open_terminals: bool,
) -> Machine:
    """Return the coefficients of a machine, with its speed held, its currents held at zero, or both, or
    neither."""
    closed = 0.0 if open_terminals else 1.0
    gamma = 0.0 if speed_held else p / (J + J_load)
    inv_L_d, inv_L_q, rho_d, rho_q, k_d, k_q, epsilon = _electrical(saturation, closed, R_s, L_d, L_q, psi_r)
    return Machine(
        p,
        R_s,
        L_d,
        L_q,
        psi_r,
        J,
        B,
        saturation,
        harmonics,
        asymmetry,
        iron,
        cogging,
        friction,
        J_load,
        train,
        inv_L_d,
        inv_L_q,
        rho_d,
        rho_q,
        k_d,
        k_q,
        epsilon,
        gamma,
        gamma * 1.5 * p * psi_r,
        gamma * 1.5 * p * (L_d - L_q),
        gamma * B / p,
    )


@njit
def _electrical(
    saturation: Saturation | None, closed: float, R_s: float, L_d: float, L_q: float, psi_r: float
) -> tuple[float, float, float, float, float, float, float]:
    """Return `inv_L_d` to `epsilon` of a machine."""
    if saturation is None:
        return closed / L_d, closed / L_q, R_s / L_d, R_s / L_q, L_q / L_d, L_d / L_q, closed * psi_r / L_q
    return closed, closed, closed * R_s, closed * R_s, closed, closed, 0.0


@njit
def holding(m: Machine, speed: bool, currents: bool) -> Machine:
    """Return the machine with its speed held, or with open terminals, or both; what was held before stays
    held."""
    return _with(m, m.train, speed, currents)


@njit
def driven_by(m: Machine, held: bool, omega_m: float) -> Machine:
    """Return the machine with its load told to hold a speed, or not to.

    That is the rotor's where all between is rigid; an elastic coupling or a weak load machine gives way.
    """
    return _with(m, told(m.train, held, omega_m), held and holds_rotor(m.train), False)


@njit
def _with(m: Machine, train: DriveTrain | None, speed: bool, currents: bool) -> Machine:
    return machine_of(
        m.p,
        m.R_s,
        m.L_d,
        m.L_q,
        m.psi_r,
        m.J,
        m.B,
        m.saturation,
        m.harmonics,
        m.asymmetry,
        m.iron,
        m.cogging,
        m.friction,
        m.J_load,
        train,
        speed or m.gamma == 0.0,
        currents or m.inv_L_d == 0.0,
    )


@njit
def warmed(heat: Heat | None, m: Machine, T_winding: float, T_magnet: float) -> Machine:
    """Return the machine with the resistance and the rotor flux of these temperatures, in degC."""
    if heat is None:
        return m
    R = 1.0 + heat.alpha_R * (T_winding - heat.T_reference)
    k = 1.0 + heat.alpha_psi * (T_magnet - heat.T_reference)
    return machine_of(
        m.p,
        heat.R_devices + (m.R_s - heat.R_devices) * max(R, 0.0),
        m.L_d,
        m.L_q,
        m.psi_r * max(k, 0.0),
        m.J,
        m.B,
        magnetised(m.saturation, m.psi_r * max(k, 0.0)),
        weakened(m.harmonics, max(k, 0.0)),
        m.asymmetry,
        m.iron,
        m.cogging,
        m.friction,
        m.J_load,
        m.train,
        m.gamma == 0.0,
        m.inv_L_d == 0.0,
    )


@njit
def fastest_rate(m: Machine, x: State) -> float:
    """Return the sum of the machine's rates at standstill, 1/s: electrical, mechanical and coupled.

    The state counts where the machine saturates: its inductances are those of its flux linkages.
    """
    inv_L = largest_inverse_inductance(m.saturation, m, x)
    psi = m.psi_r + linkage(m.harmonics)
    stiffness = 1.5 * m.p * psi * psi * inv_L + cogging_stiffness(m.cogging)
    friction = m.B / m.p + stribeck_slope(m.friction) + iron_slope(m.iron, psi, m.p)
    resistance = m.R_s + series_resistance(m.asymmetry)
    rate = resistance * inv_L + math.sqrt(m.gamma * stiffness) + m.gamma * friction
    return rate + train_rate(m.train, m.gamma)


@njit
def turning_rate(m: Machine) -> float:
    """Return the rate in 1/s that every electrical rad/s adds to `fastest_rate`."""
    turning = max(1.0, m.k_d, m.k_q) + harmonic_turning(m.harmonics) + cogging_turning(m.cogging)
    return turning + asymmetric_turning(m.asymmetry) + train_turning(m.train, m.gamma)


@njit
def rate_at(x: State, at_rest: float, moving: float, m: Machine) -> float:
    """Return the sum of the machine's rates, of `fastest_rate` and `turning_rate`, at the speed of `x`."""
    return at_rest + moving * fastest_omega(m.train, x.far, x.omega_e)


@njit
def largest_inverse_inductance(saturation: Saturation | None, m: Machine, x: State) -> float:
    """Return the largest inverse of the machine's inductances, in 1/H."""
    if saturation is None:
        return max(m.inv_L_d, m.inv_L_q)
    y_d, y_q = electrical(m.saturation, x)
    return m.inv_L_d * largest(incremental(saturation, y_d, y_q))
