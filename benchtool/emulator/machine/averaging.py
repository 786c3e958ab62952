"""One PWM period by its mean voltage and the moments of its ripple, where nothing asks for the edges in time.

The pulses of all legs are centred. What they add to the mean voltage moves the stator flux by a ripple W(t)
that is zero at both ends of the period and in its middle, and odd about the middle. With the states x =
(psi_alpha, psi_beta, omega_e, theta_e) and the machine x' = f(x) + (u, 0, 0), the ripple leaves at the end of
the period, to second order in W (averaging as of Krylov and Bogoliubov, one order further than Middlebrook
and Cuk, PESC 1976),

    integral of F W + (W d2f/dpsi2 W) / 2 dt,    F(t) = Phi(end, t) df/dpsi.

W is odd, so that of the smooth F its rate in the middle is what counts, with the first moment of W. The
rate is d/dt df/dpsi - df/dx df/dpsi; `rippled` is that in d/q. Of d2f/dpsi2 there is the torque's, in a
salient machine: it makes the mean product of the ripples of i_d and i_q a torque. Harmonics of the flux
change the torque's slope over the currents, which turns with the angle, and what the currents become as the
rotor turns; their torque is linear in the currents.

So a period is two steps under the mean voltage with the ripple's effect between them, whatever the duties;
there is no order of edges. What is left out is of the fifth order in the period's length.
"""

from __future__ import annotations

from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.harmonics import (
    flux_slope,
    linkage,
    with_harmonic_emf,
    with_harmonic_slopes,
    with_turning_torque,
)
from benchtool.emulator.machine.inverter import SQRT3, clarke, phase_currents
from benchtool.emulator.machine.plant import added, derivative, scaled_voltage, step
from benchtool.emulator.machine.shaft import Friction
from benchtool.emulator.machine.state import State
from benchtool.emulator.rotate import rotate

SLOW_ENOUGH = 0.1  # rad of the fastest process in a period; a step of half of it leaves less than 1e-8


@njit
def averaged(
    x: State,
    duties: tuple[float, float, float],
    u_dc: float,
    T_s: float,
    machine: Machine,
    T_load: float,
    metered: bool,
) -> tuple[State, float]:
    """Integrate one PWM period of these duties, between ideal switches on a constant dc link.

    Of machines without a drive train, in periods in which dry friction cannot bring the shaft to rest.

    Returns the charge drawn from the link as well, in As, if that is `metered`: the duties times the
    integrals of their currents, by Simpson's rule. What the ripple stores it gives back within the
    period, but for some 1e-5 of it, as much as a trapezoidal rule from edge to edge is off by.
    """
    duty_a, duty_b, duty_c = duties
    u_alpha, u_beta = clarke(u_dc * duty_a, u_dc * duty_b, u_dc * duty_c)
    charge = T_s * (1.0 / 6.0) * link_current(duties, x) if metered else 0.0
    for half in range(2):
        x = step(x, u_alpha, u_beta, 0.5 * T_s, machine, T_load)
        if half == 0:
            x = rippled(x, duties, u_dc, T_s, machine, T_load)
        if metered:
            charge += T_s * ((4.0 - 3.0 * half) * (1.0 / 6.0)) * link_current(duties, x)
    return x, charge


@njit
def link_current(duties: tuple[float, float, float], x: State) -> float:
    """Return what legs of these duties draw from the dc link in the mean."""
    i_a, i_b, i_c = phase_currents(x)
    return duties[0] * i_a + duties[1] * i_b + duties[2] * i_c


@njit
def rippled(
    x: State,
    duties: tuple[float, float, float],
    u_dc: float,
    T_s: float,
    machine: Machine,
    T_load: float,
) -> State:
    """Return the state in the middle of a period with what the period's ripple adds to it."""
    duty_a, duty_b, duty_c = duties
    moment = u_dc * T_s * T_s * T_s
    w_alpha, w_beta = clarke(
        moment * first_moment(duty_a), moment * first_moment(duty_b), moment * first_moment(duty_c)
    )
    u_alpha, u_beta = clarke(u_dc * duty_a, u_dc * duty_b, u_dc * duty_c)
    product = _product(x, duties, u_dc, T_s, machine) if machine.sigma != 0.0 else 0.0
    added_by = of_odd_ripple(x, w_alpha, w_beta, u_alpha, u_beta, product, machine, T_load)
    return turned(x, added_by, machine)


class Addition(NamedTuple):
    """What is added to a state: its currents, its speed, and its angle."""

    i_d: float
    i_q: float
    omega_e: float
    turn: float


@njit
def of_odd_ripple(
    x: State,
    w_alpha: float,
    w_beta: float,
    u_alpha: float,
    u_beta: float,
    product: float,
    machine: Machine,
    T_load: float,
) -> Addition:
    """Return what a ripple adds in the middle of the period, by its first moment in Vs3 and the integral of
    the product of the ripples of i_d and i_q in A2s, which only a salient machine needs."""
    w_d, w_q = scaled_voltage(x, w_alpha, w_beta, machine)  # of the ripple of the currents, As2
    per_flux = machine.gamma * 1.5 * machine.p
    h_d, h_q = torque_slopes(x, machine)
    turn = -(h_d * w_d + h_q * w_q)
    domega = x.omega_e * (h_d * machine.k_d * w_q - h_q * machine.k_q * w_d)
    domega += (machine.rho_d + machine.beta) * h_d * w_d + (machine.rho_q + machine.beta) * h_q * w_q
    domega = with_turning_torque(
        machine.harmonics, domega, w_d, w_q, x.omega_e, x.cos_theta, x.sin_theta, per_flux
    )
    if machine.sigma != 0.0:
        v_d, v_q = scaled_voltage(x, u_alpha, u_beta, machine)
        di_d, di_q, _, _, _ = derivative(x.i_d, x.i_q, x.omega_e, x.theta_e, v_d, v_q, machine, T_load)
        domega += machine.sigma * (di_q * w_d + di_d * w_q + product)
    di_d = -machine.rho_d * (x.omega_e * (machine.k_d - 1.0) * w_q + machine.rho_d * w_d)
    di_q = machine.rho_q * (x.omega_e * (machine.k_q - 1.0) * w_d - machine.rho_q * w_q)
    return Addition(di_d, di_q, domega, turn)


@njit
def torque_slopes(x: State, machine: Machine) -> tuple[float, float]:
    """Return the changes of domega with i_d and i_q."""
    h_d, h_q = machine.sigma * x.i_q, machine.kappa + machine.sigma * x.i_d
    g_d, g_q = flux_slope(machine.harmonics, x.cos_theta, x.sin_theta)
    return with_harmonic_slopes(machine.harmonics, h_d, h_q, g_d, g_q, machine.gamma * 1.5 * machine.p)


@njit
def turned(x: State, added_by: Addition, machine: Machine) -> State:
    """Return the state with an addition, and with its rotor turned while the flux stays in alpha/beta."""
    turn = added_by.turn
    g_d, g_q = flux_slope(machine.harmonics, x.cos_theta, x.sin_theta)
    di_d = added_by.i_d + machine.k_d * x.i_q * turn
    di_q = added_by.i_q - (machine.k_q * x.i_d + machine.epsilon) * turn
    di_d, di_q = with_harmonic_emf(
        machine.harmonics, di_d, di_q, turn, g_d, g_q, machine.inv_L_d, machine.inv_L_q
    )
    cos_theta, sin_theta = rotate(x.cos_theta, x.sin_theta, turn)
    theta_e, theta_rest = added(x.theta_e, x.theta_rest, turn)
    return State(
        x.i_d + di_d,
        x.i_q + di_q,
        x.omega_e + added_by.omega_e,
        theta_e,
        theta_rest,
        cos_theta,
        sin_theta,
        x.far,
        x.flux,
    )


@njit
def first_moment(duty: float) -> float:
    """Return the integral of (t - T_s / 2) w(t), w the integral of a leg's voltage less its mean; of u_dc
    T_s^3."""
    return duty * (1.0 - duty * duty) * (1.0 / 24.0)


@njit
def overlap(duty_1: float, duty_2: float) -> float:
    """Return the integral of w_1(t) w_2(t) of two legs, as in `first_moment`; of u_dc^2 T_s^3."""
    x, y = min(duty_1, duty_2), max(duty_1, duty_2)
    return x * (2.0 * y - x * x - 3.0 * y * y + y * (x * x + y * y)) * (1.0 / 24.0)


@njit
def _product(
    x: State, duties: tuple[float, float, float], u_dc: float, T_s: float, machine: Machine
) -> float:
    """Return the integral of the product of the ripples of i_d and i_q over the period, A2s."""
    a, b, c = duties
    aa, bb, cc = overlap(a, a), overlap(b, b), overlap(c, c)
    ab, bc, ca = overlap(a, b), overlap(b, c), overlap(c, a)
    alpha_alpha = (4.0 * (aa - ab - ca) + bb + cc + 2.0 * bc) * (1.0 / 9.0)
    beta_beta = (bb + cc - 2.0 * bc) * (1.0 / 3.0)
    alpha_beta = (2.0 * (ab - ca) - bb + cc) * (1.0 / (3.0 * SQRT3))
    square = x.cos_theta * x.cos_theta - x.sin_theta * x.sin_theta
    d_q = alpha_beta * square + (beta_beta - alpha_alpha) * x.cos_theta * x.sin_theta
    return u_dc * u_dc * T_s * T_s * T_s * machine.inv_L_d * machine.inv_L_q * d_q


@njit
def can_rest(
    friction: Friction | None, x: State, u_dc: float, T_s: float, machine: Machine, T_load: float
) -> bool:
    """Return whether dry friction could bring the shaft to rest within the period."""
    if friction is None:
        return False
    inv_L = max(machine.inv_L_d, machine.inv_L_q)
    current = abs(x.i_d) + abs(x.i_q) + u_dc * T_s * inv_L
    torque = (machine.kappa + abs(machine.sigma) * current) * current
    torque += machine.gamma * 1.5 * machine.p * linkage(machine.harmonics) * current
    return abs(x.omega_e) <= T_s * (torque + machine.gamma * (abs(T_load) + friction.T_breakaway))
