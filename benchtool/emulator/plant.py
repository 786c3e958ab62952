"""The machine: dq model of a permanent-magnet motor and its shaft, integrated under a constant stator voltage.

Amplitude-invariant space vectors; the d axis lies on the rotor flux, which is along phase a at theta_e = 0.

    d i_d/dt = (u_d - R_s i_d + omega_e psi_q - e_d) / L_d        psi_d = L_d i_d + psi_r
    d i_q/dt = (u_q - R_s i_q - omega_e psi_d - e_q) / L_q        psi_q = L_q i_q
    T        = 3/2 p (psi_d i_q - psi_q i_d) + harmonics
    J d omega_m/dt = T - T_cogging - B omega_m - T_coulomb - T_load

Between two switching edges the stator voltage is constant in alpha/beta, so in d/q it turns at -omega_e; it is
integrated along with the state, in steps of the classical Runge-Kutta method of fourth order. The direction of
the rotor flux, (cos_theta, sin_theta), is carried along and turned by the angle of each step.

Flux harmonics 5 and 7 turn up in d/q at 6 theta_e; their torque is the one that conserves energy. Coulomb friction
is smoothed around standstill: T_coulomb omega_m / sqrt(omega_m^2 + omega_0^2).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit

OMEGA_0 = 0.05  # rad/s, speed below which Coulomb friction fades out
_SMALL_ANGLE = 0.05  # rad, up to which the series below are exact to rounding


class Machine(NamedTuple):
    """True coefficients; an inverse that is zero holds what it would move: 1/J the speed, 1/L the currents."""

    p: float
    R_s: float
    L_d: float
    L_q: float
    psi_r: float
    inv_L_d: float
    inv_L_q: float
    inv_J: float
    B: float
    T_coulomb: float
    T_cogging: float
    N_cogging: float
    psi_5: float
    psi_7: float


class State(NamedTuple):
    """Currents, speed and angle; `theta_e` never wraps."""

    i_d: float
    i_q: float
    omega_m: float
    theta_e: float
    cos_theta: float
    sin_theta: float


@njit
def place(i_d: float, i_q: float, omega_m: float, theta_e: float) -> State:
    """State with its direction derived from the angle."""
    return State(i_d, i_q, omega_m, theta_e, math.cos(theta_e), math.sin(theta_e))


@njit
def holding(machine: Machine, speed: bool, currents: bool) -> Machine:
    """The machine with its speed held, or with open terminals, or both."""
    m = machine
    return Machine(
        m.p,
        m.R_s,
        m.L_d,
        m.L_q,
        m.psi_r,
        0.0 if currents else m.inv_L_d,
        0.0 if currents else m.inv_L_q,
        0.0 if speed else m.inv_J,
        m.B,
        m.T_coulomb,
        m.T_cogging,
        m.N_cogging,
        m.psi_5,
        m.psi_7,
    )


@njit
def fastest_rate(machine: Machine) -> float:
    """Sum of the rates at which the machine can change at standstill, 1/s: electrical, mechanical, coupled."""
    inv_L = max(machine.inv_L_d, machine.inv_L_q)
    coupling = machine.p * (machine.psi_r + 5.0 * abs(machine.psi_5) + 7.0 * abs(machine.psi_7))
    friction = machine.B + machine.T_coulomb / OMEGA_0
    cogging = machine.T_cogging * machine.N_cogging
    resonance = math.sqrt((1.5 * coupling * coupling * inv_L + cogging) * machine.inv_J)
    return machine.R_s * inv_L + resonance + friction * machine.inv_J


@njit
def turning_rate(machine: Machine) -> float:
    """Rate in 1/s that every rad/s of mechanical speed adds to `fastest_rate`."""
    rate = machine.p * max(1.0, machine.L_d * machine.inv_L_q, machine.L_q * machine.inv_L_d)
    if machine.psi_5 != 0.0 or machine.psi_7 != 0.0:
        rate += 6.0 * machine.p
    if machine.T_cogging > 0.0:
        rate += machine.N_cogging
    return rate


@njit
def airgap_torque(i_d: float, i_q: float, theta_e: float, machine: Machine) -> float:
    """Electromagnetic torque in Nm, 3/2 p (psi_s x i_s), with the torque of the flux harmonics."""
    psi_d = machine.L_d * i_d + machine.psi_r
    torque = psi_d * i_q - machine.L_q * i_q * i_d
    if machine.psi_5 != 0.0 or machine.psi_7 != 0.0:
        g_d, g_q = _harmonics(theta_e, machine)
        torque += g_d * i_d + g_q * i_q
    return 1.5 * machine.p * torque


@njit
def derivative(
    i_d: float,
    i_q: float,
    omega_m: float,
    theta_e: float,
    u_d: float,
    u_q: float,
    machine: Machine,
    T_load: float,
) -> tuple[float, float, float]:
    """Rates of i_d, i_q and omega_m under a stator voltage in d/q."""
    omega_e = machine.p * omega_m
    psi_d = machine.L_d * i_d + machine.psi_r
    psi_q = machine.L_q * i_q
    torque = psi_d * i_q - psi_q * i_d
    v_d = u_d - machine.R_s * i_d + omega_e * psi_q
    v_q = u_q - machine.R_s * i_q - omega_e * psi_d
    resisting = T_load + machine.B * omega_m
    if machine.psi_5 != 0.0 or machine.psi_7 != 0.0:
        g_d, g_q = _harmonics(theta_e, machine)
        v_d -= omega_e * g_d
        v_q -= omega_e * g_q
        torque += g_d * i_d + g_q * i_q
    if machine.T_cogging > 0.0:
        resisting += machine.T_cogging * math.sin(machine.N_cogging * theta_e / machine.p)
    if machine.T_coulomb > 0.0:
        resisting += machine.T_coulomb * omega_m / math.sqrt(omega_m * omega_m + OMEGA_0 * OMEGA_0)
    return (
        v_d * machine.inv_L_d,
        v_q * machine.inv_L_q,
        (1.5 * machine.p * torque - resisting) * machine.inv_J,
    )


@njit
def _harmonics(theta_e: float, machine: Machine) -> tuple[float, float]:
    """Change of the rotor flux's fifth and seventh harmonic with theta_e, in d/q, in Wb/rad.

    The fifth turns backwards and the seventh forwards: psi_5 exp(-j 5 theta) + psi_7 exp(j 7 theta).
    """
    g_d = -(5.0 * machine.psi_5 + 7.0 * machine.psi_7) * math.sin(6.0 * theta_e)
    g_q = (7.0 * machine.psi_7 - 5.0 * machine.psi_5) * math.cos(6.0 * theta_e)
    return g_d, g_q


@njit
def step(x: State, u_alpha: float, u_beta: float, h: float, machine: Machine, T_load: float) -> State:
    """One Runge-Kutta step of `h` seconds under the constant voltage (u_alpha, u_beta)."""
    i_d, i_q, w = x.i_d, x.i_q, x.omega_m
    p = machine.p
    half = 0.5 * h
    # The voltage in d/q turns with -omega_e; it is a state of the integration like the others.
    u_d = u_alpha * x.cos_theta + u_beta * x.sin_theta
    u_q = u_beta * x.cos_theta - u_alpha * x.sin_theta

    a_d, a_q, a_w = derivative(i_d, i_q, w, x.theta_e, u_d, u_q, machine, T_load)
    a_ud, a_uq = p * w * u_q, -p * w * u_d

    w2 = w + half * a_w
    u_d2, u_q2 = u_d + half * a_ud, u_q + half * a_uq
    theta2 = x.theta_e + half * p * w
    b_d, b_q, b_w = derivative(i_d + half * a_d, i_q + half * a_q, w2, theta2, u_d2, u_q2, machine, T_load)
    b_ud, b_uq = p * w2 * u_q2, -p * w2 * u_d2

    w3 = w + half * b_w
    u_d3, u_q3 = u_d + half * b_ud, u_q + half * b_uq
    theta3 = x.theta_e + half * p * w2
    c_d, c_q, c_w = derivative(i_d + half * b_d, i_q + half * b_q, w3, theta3, u_d3, u_q3, machine, T_load)
    c_ud, c_uq = p * w3 * u_q3, -p * w3 * u_d3

    w4 = w + h * c_w
    u_d4, u_q4 = u_d + h * c_ud, u_q + h * c_uq
    theta4 = x.theta_e + h * p * w3
    d_d, d_q, d_w = derivative(i_d + h * c_d, i_q + h * c_q, w4, theta4, u_d4, u_q4, machine, T_load)

    sixth = h / 6.0
    turn = sixth * p * (w + 2.0 * (w2 + w3) + w4)
    cos_theta, sin_theta = turned(x.cos_theta, x.sin_theta, turn)
    return State(
        i_d + sixth * (a_d + 2.0 * (b_d + c_d) + d_d),
        i_q + sixth * (a_q + 2.0 * (b_q + c_q) + d_q),
        w + sixth * (a_w + 2.0 * (b_w + c_w) + d_w),
        x.theta_e + turn,
        cos_theta,
        sin_theta,
    )


@njit
def turned(cos_theta: float, sin_theta: float, angle: float) -> tuple[float, float]:
    """A direction turned by an angle in rad, exact to rounding."""
    if abs(angle) <= _SMALL_ANGLE:
        q = angle * angle
        sine = angle * (1.0 - q / 6.0 * (1.0 - q / 20.0 * (1.0 - q / 42.0)))
        cosine = 1.0 - q / 2.0 * (1.0 - q / 12.0 * (1.0 - q / 30.0 * (1.0 - q / 56.0)))
    else:
        sine = math.sin(angle)
        cosine = math.cos(angle)
    return cos_theta * cosine - sin_theta * sine, sin_theta * cosine + cos_theta * sine


@njit
def substep(remaining: float, rate: float, turn: float) -> float:
    """Step of equal parts of `remaining` in which the fastest process advances by at most `turn` rad."""
    parts = remaining * rate / turn
    return remaining if parts <= 1.0 else remaining / math.ceil(parts)


@njit
def advance(
    x: State, u_alpha: float, u_beta: float, duration: float, turn: float, machine: Machine, T_load: float
) -> State:
    """Integrate over `duration` seconds of constant voltage, in steps of at most `turn` rad of the fastest process."""
    at_rest, moving = fastest_rate(machine), turning_rate(machine)
    remaining = duration
    while remaining > 0.0:
        h = substep(remaining, at_rest + moving * abs(x.omega_m), turn)
        x = step(x, u_alpha, u_beta, h, machine, T_load)
        remaining = remaining - h if h < remaining else 0.0
    return x
