"""The machine: dq model of a permanent-magnet motor and its shaft, integrated under constant stator voltage.

Amplitude-invariant space vectors; the d axis lies on the rotor flux, which is along phase a at theta_e = 0.

    L_d d i_d/dt = u_d - R_s i_d + omega_e psi_q - e_d        psi_d = L_d i_d + psi_r
    L_q d i_q/dt = u_q - R_s i_q - omega_e psi_d - e_q        psi_q = L_q i_q
    J d omega_m/dt = T - T_cogging - B omega_m - T_coulomb - T_load
    T = 3/2 p (psi_d i_q - psi_q i_d) + harmonics

Between two switching edges the stator voltage is constant in alpha/beta, so in d/q it turns at -omega_e; it
is integrated along with the currents, in steps of the classical Runge-Kutta method of fourth order. The
direction of the rotor flux, (cos_theta, sin_theta), is carried along and turned by the angle of each step.

Harmonics of the flux, phases that differ, cogging and dry friction are optional parts of the machine, in
modules of their own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.asymmetry import (
    Asymmetry,
    Symmetric,
    asymmetric_turning,
    series_resistance,
    through_asymmetry,
    with_asymmetry,
)
from benchtool.emulator.machine.harmonics import (
    Harmonics,
    harmonic_turning,
    linkage,
    with_harmonic_emf,
    with_harmonic_torque,
)
from benchtool.emulator.machine.shaft import (
    Cogging,
    Friction,
    cogging_stiffness,
    cogging_turning,
    less_cogging,
    less_friction,
    part_until_rest,
    sliding,
    stribeck_slope,
)
from benchtool.emulator.rotate import rotate

MOST_TURN = 100.0  # rad of the fastest process in a PWM period: beyond, a period takes too many steps


class Machine(NamedTuple):
    """True parameters, and below them the equations' coefficients as `machine_of` derives them.

    Voltages are integrated divided by their axis' inductance and torques times p / J, which leaves the fewest
    operations between one stage and the next.
    """

    p: float
    R_s: float
    L_d: float
    L_q: float
    psi_r: float
    J: float
    B: float
    harmonics: Harmonics | None
    asymmetry: Asymmetry | None
    cogging: Cogging | None
    friction: Friction | None

    inv_L_d: float  # zero with open terminals
    inv_L_q: float
    rho_d: float  # R_s / L_d
    rho_q: float
    k_d: float  # L_q / L_d
    k_q: float
    epsilon: float  # psi_r / L_q, the back EMF; zero with open terminals
    gamma: float  # p / J; zero with held speed, as are the three below
    kappa: float  # gamma 3/2 p psi_r
    sigma: float  # gamma 3/2 p (L_d - L_q)
    beta: float  # B / J


class State(NamedTuple):
    """Currents, electrical speed and angle; `theta_e` never wraps, `theta_rest` is its rounding."""

    i_d: float
    i_q: float
    omega_e: float
    theta_e: float
    theta_rest: float
    cos_theta: float
    sin_theta: float


@njit
def place(i_d: float, i_q: float, omega_e: float, theta_e: float) -> State:
    """Return the state with its direction derived from the angle."""
    return State(i_d, i_q, omega_e, theta_e, 0.0, math.cos(theta_e), math.sin(theta_e))


@njit
def machine_of(
    p: float,
    R_s: float,
    L_d: float,
    L_q: float,
    psi_r: float,
    J: float,
    B: float,
    harmonics: Harmonics | None,
    asymmetry: Asymmetry | None,
    cogging: Cogging | None,
    friction: Friction | None,
    speed_held: bool,
    open_terminals: bool,
) -> Machine:
    """Return the coefficients of a machine, with its speed held, its currents held at zero, or both, or
    neither."""
    closed = 0.0 if open_terminals else 1.0
    gamma = 0.0 if speed_held else p / J
    return Machine(
        p,
        R_s,
        L_d,
        L_q,
        psi_r,
        J,
        B,
        harmonics,
        asymmetry,
        cogging,
        friction,
        closed / L_d,
        closed / L_q,
        R_s / L_d,
        R_s / L_q,
        L_q / L_d,
        L_d / L_q,
        closed * psi_r / L_q,
        gamma,
        gamma * 1.5 * p * psi_r,
        gamma * 1.5 * p * (L_d - L_q),
        gamma * B / p,
    )


@njit
def holding(m: Machine, speed: bool, currents: bool) -> Machine:
    """Return the machine with its speed held, or with open terminals, or both; what was held before stays
    held."""
    return machine_of(
        m.p,
        m.R_s,
        m.L_d,
        m.L_q,
        m.psi_r,
        m.J,
        m.B,
        m.harmonics,
        m.asymmetry,
        m.cogging,
        m.friction,
        speed or m.gamma == 0.0,
        currents or m.inv_L_d == 0.0,
    )


@njit
def fastest_rate(m: Machine) -> float:
    """Return the sum of the machine's rates at standstill, 1/s: electrical, mechanical and coupled."""
    inv_L = max(m.inv_L_d, m.inv_L_q)
    psi = m.psi_r + linkage(m.harmonics)
    stiffness = 1.5 * m.p * psi * psi * inv_L + cogging_stiffness(m.cogging)
    friction = m.B / m.p + stribeck_slope(m.friction)
    return (
        (m.R_s + series_resistance(m.asymmetry)) * inv_L + math.sqrt(m.gamma * stiffness) + m.gamma * friction
    )


@njit
def turning_rate(m: Machine) -> float:
    """Return the rate in 1/s that every electrical rad/s adds to `fastest_rate`."""
    return (
        max(1.0, m.k_d, m.k_q)
        + asymmetric_turning(m.asymmetry)
        + harmonic_turning(m.harmonics)
        + cogging_turning(m.cogging)
    )


@njit
def inverse_inductance(theta_e: float, m: Machine) -> Symmetric:
    """Return by what the rates of the currents change with the voltage at the terminals, in d/q, in 1/H."""
    return through_asymmetry(m.asymmetry, theta_e, Symmetric(m.inv_L_d, 0.0, m.inv_L_q))


@njit
def airgap_torque(i_d: float, i_q: float, theta_e: float, m: Machine) -> float:
    """Return the electromagnetic torque in Nm, 3/2 p (psi_s x i_s), with the torque of the flux harmonics."""
    torque = (m.psi_r + (m.L_d - m.L_q) * i_d) * i_q
    return 1.5 * m.p * with_harmonic_torque(m.harmonics, torque, i_d, i_q, theta_e, 1.0)


@njit
def derivative(
    i_d: float,
    i_q: float,
    omega_e: float,
    theta_e: float,
    v_d: float,
    v_q: float,
    m: Machine,
    T_load: float,
    slide: float = 0.0,
) -> tuple[float, float, float, float, float]:
    """Return the rates of i_d, i_q, omega_e, v_d and v_q, where v_d = u_d / L_d and v_q = u_q / L_q.

    `slide` is the direction in which a shaft with dry friction slides; by default it sticks.
    """
    along, across = omega_e * m.k_d, omega_e * m.k_q
    di_d = (v_d + along * i_q) - m.rho_d * i_d
    di_q = (v_q - across * i_d) - (m.rho_q * i_q + omega_e * m.epsilon)
    di_d, di_q = with_harmonic_emf(m.harmonics, di_d, di_q, omega_e, theta_e, m.inv_L_d, m.inv_L_q)
    G = Symmetric(m.inv_L_d, 0.0, m.inv_L_q)
    di_d, di_q = with_asymmetry(m.asymmetry, di_d, di_q, i_d, i_q, omega_e, theta_e, G)
    domega = _acceleration(i_d, i_q, omega_e, theta_e, m, T_load)
    domega = less_friction(m.friction, domega, omega_e, slide, m.gamma)
    return di_d, di_q, domega, along * v_q, -(across * v_d)


@njit
def _acceleration(i_d: float, i_q: float, omega_e: float, theta_e: float, m: Machine, T_load: float) -> float:
    """Return the rate of omega_e without dry friction."""
    domega = (m.kappa + m.sigma * i_d) * i_q - (m.beta * omega_e + m.gamma * T_load)
    domega = with_harmonic_torque(m.harmonics, domega, i_d, i_q, theta_e, m.gamma * 1.5 * m.p)
    return less_cogging(m.cogging, domega, theta_e, m.gamma)


@njit
def scaled_voltage(x: State, u_alpha: float, u_beta: float, m: Machine) -> tuple[float, float]:
    """Return v_d = u_d / L_d and v_q = u_q / L_q of a stator voltage."""
    u_d = u_alpha * x.cos_theta + u_beta * x.sin_theta
    u_q = u_beta * x.cos_theta - u_alpha * x.sin_theta
    return u_d * m.inv_L_d, u_q * m.inv_L_q


@njit
def step(x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float) -> State:
    """Return one Runge-Kutta step of `h` seconds under the constant voltage (u_alpha, u_beta)."""
    i_d, i_q, w, theta = x.i_d, x.i_q, x.omega_e, x.theta_e
    v_d, v_q = scaled_voltage(x, u_alpha, u_beta, m)
    half = 0.5 * h
    slide = sliding(m.friction, w, _acceleration(i_d, i_q, w, theta, m, T_load), m.gamma)

    a_d, a_q, a_w, a_vd, a_vq = derivative(i_d, i_q, w, theta, v_d, v_q, m, T_load, slide)

    w2 = w + half * a_w
    b_d, b_q, b_w, b_vd, b_vq = derivative(
        i_d + half * a_d,
        i_q + half * a_q,
        w2,
        theta + half * w,
        v_d + half * a_vd,
        v_q + half * a_vq,
        m,
        T_load,
        slide,
    )

    w3 = w + half * b_w
    c_d, c_q, c_w, c_vd, c_vq = derivative(
        i_d + half * b_d,
        i_q + half * b_q,
        w3,
        theta + half * w2,
        v_d + half * b_vd,
        v_q + half * b_vq,
        m,
        T_load,
        slide,
    )

    w4 = w + h * c_w
    d_d, d_q, d_w, _, _ = derivative(
        i_d + h * c_d, i_q + h * c_q, w4, theta + h * w3, v_d + h * c_vd, v_q + h * c_vq, m, T_load, slide
    )

    sixth = h * (1.0 / 6.0)
    turn = sixth * (w + 2.0 * (w2 + w3) + w4)
    cos_theta, sin_theta = rotate(x.cos_theta, x.sin_theta, turn)
    theta, theta_rest = added(x.theta_e, x.theta_rest, turn)
    return State(
        i_d + sixth * (a_d + 2.0 * (b_d + c_d) + d_d),
        i_q + sixth * (a_q + 2.0 * (b_q + c_q) + d_q),
        w + sixth * (a_w + 2.0 * (b_w + c_w) + d_w),
        theta,
        theta_rest,
        cos_theta,
        sin_theta,
    )


@njit
def move(x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float) -> tuple[State, float]:
    """`step` that ends early where dry friction brings the shaft to rest. Returns its length as well."""
    after = step(x, u_alpha, u_beta, h, m, T_load)
    part = part_until_rest(m.friction, x.omega_e, after.omega_e)
    if part < 1.0:
        h = part * h
        y = step(x, u_alpha, u_beta, h, m, T_load)
        after = State(y.i_d, y.i_q, 0.0, y.theta_e, y.theta_rest, y.cos_theta, y.sin_theta)
    return after, h


@njit
def substep(remaining: float, rate: float, turn: float) -> float:
    """Return the step of equal parts of `remaining` in which the fastest process advances by at most `turn`
    rad."""
    parts = remaining * rate
    return remaining if parts <= turn else remaining / math.ceil(parts / turn)


@njit
def advance(
    x: State, u_alpha: float, u_beta: float, duration: float, turn: float, m: Machine, T_load: float
) -> State:
    """Integrate over `duration` seconds, in steps of at most `turn` rad of the fastest process."""
    at_rest, moving = fastest_rate(m), turning_rate(m)
    remaining, rest = duration, 0.0
    while remaining > 0.0:
        h = substep(remaining, at_rest + moving * abs(x.omega_e), turn)
        x, h = move(x, u_alpha, u_beta, h, m, T_load)
        remaining, rest = added(remaining, rest, -h)
    return x


@njit
def added(total: float, rest: float, increment: float) -> tuple[float, float]:
    """Compensated sum (Kahan): the total, and what its rounding left over for the next increment."""
    increment += rest
    new = total + increment
    return new, increment - (new - total)
