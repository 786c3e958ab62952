"""Currents within a PWM period, along the smooth course that a mean voltage gives them.

    i(t) = smooth(t) + G(theta) W - R G^2 (integral of W dt),    W = integral of (u - mean) dt

A course is a parabola through three states. W is the ripple of the flux; at the end of a period what it has
done to speed and angle follows from its moments (`averaging`), of which the zeroth need not be zero here, and
what it is then is added to the flux.
"""

from __future__ import annotations

from typing import NamedTuple

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.averaging import Addition, of_odd_ripple, torque_slopes, turned
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.inverter import inverse_clarke
from benchtool.emulator.machine.plant import scaled_voltage
from benchtool.emulator.machine.state import State, stationary_currents, with_currents


class Course(NamedTuple):
    """Smooth course of the currents, i_0 + i_1 t + i_2 t^2 in alpha/beta, and what a flux adds to them.

    That is `G` of it, and where the machine is salient a part that turns: `c` and `s` in the middle of the
    period, `turning` as fast.
    """

    alpha_0: float
    alpha_1: float
    alpha_2: float
    beta_0: float
    beta_1: float
    beta_2: float
    G: float
    loss: float
    salient: bool
    c: float
    s: float
    turning: float
    middle: float


class Ripple(NamedTuple):
    """W in Vs, its integral in Vs2, its first moment about the middle of the period in Vs3, and the integrals
    of its products in V2s3."""

    alpha: float
    beta: float
    alpha_0: float
    beta_0: float
    alpha_1: float
    beta_1: float
    aa: float
    bb: float
    ab: float


@njit
def course_of(x: State, middle: State, end: State, T_s: float, machine: Machine) -> Course:
    """Return the parabolas through the currents of three states, a half period apart."""
    alpha_0, beta_0 = stationary_currents(x)
    alpha_1, beta_1 = stationary_currents(middle)
    alpha_2, beta_2 = stationary_currents(end)
    per_s = 1.0 / T_s
    G, salient = 0.5 * (machine.inv_L_d + machine.inv_L_q), 0.5 * (machine.inv_L_d - machine.inv_L_q)
    c, s = middle.cos_theta, middle.sin_theta
    return Course(
        alpha_0,
        (4.0 * alpha_1 - 3.0 * alpha_0 - alpha_2) * per_s,
        (alpha_0 - 2.0 * alpha_1 + alpha_2) * 2.0 * per_s * per_s,
        beta_0,
        (4.0 * beta_1 - 3.0 * beta_0 - beta_2) * per_s,
        (beta_0 - 2.0 * beta_1 + beta_2) * 2.0 * per_s * per_s,
        G,
        machine.R_s * G * G,
        salient != 0.0,
        salient * (c * c - s * s),
        salient * 2.0 * c * s,
        2.0 * middle.omega_e,
        0.5 * T_s,
    )


@njit
def slopes_of(
    course: Course, time: float, w_alpha: float, w_beta: float, d_alpha: float, d_beta: float
) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
    """Return k and l of the phases' currents i + h k + h^2 l from `time` on, where the ripple is W at first
    and changes at a constant rate."""
    k_alpha = course.alpha_1 + 2.0 * time * course.alpha_2 + (course.G * d_alpha - course.loss * w_alpha)
    k_beta = course.beta_1 + 2.0 * time * course.beta_2 + (course.G * d_beta - course.loss * w_beta)
    l_alpha, l_beta = (
        course.alpha_2 - 0.5 * course.loss * d_alpha,
        course.beta_2 - 0.5 * course.loss * d_beta,
    )
    if course.salient:
        at = course.turning * (time - course.middle)
        c, s = course.c - at * course.s, course.s + at * course.c
        turn_c, turn_s = -course.turning * course.s, course.turning * course.c
        k_alpha += c * d_alpha + s * d_beta + turn_c * w_alpha + turn_s * w_beta
        k_beta += s * d_alpha - c * d_beta + turn_s * w_alpha - turn_c * w_beta
        l_alpha += turn_c * d_alpha + turn_s * d_beta
        l_beta += turn_s * d_alpha - turn_c * d_beta
    return inverse_clarke(k_alpha, k_beta), inverse_clarke(l_alpha, l_beta)


class Moments(NamedTuple):
    """Integrals of the voltage's difference from its mean: W in Vs, and with the time from the middle of the
    period and its square, in Vs2 and Vs3."""

    alpha: float
    beta: float
    alpha_1: float
    beta_1: float
    alpha_2: float
    beta_2: float


@njit
def ahead(moments: Moments, d_alpha: float, d_beta: float, h: float, from_middle: float) -> Moments:
    """Return the moments after `h` seconds of this difference."""
    at = from_middle + 0.5 * h
    square = at * at + (1.0 / 12.0) * h * h
    g_alpha, g_beta = h * d_alpha, h * d_beta
    return Moments(
        moments.alpha + g_alpha,
        moments.beta + g_beta,
        moments.alpha_1 + at * g_alpha,
        moments.beta_1 + at * g_beta,
        moments.alpha_2 + square * g_alpha,
        moments.beta_2 + square * g_beta,
    )


class Products(NamedTuple):
    """Integrals of the products of W, in V2s3."""

    aa: float
    bb: float
    ab: float


@njit
def products_ahead(
    products: Products, w_alpha: float, w_beta: float, d_alpha: float, d_beta: float, h: float
) -> Products:
    """Return the products after `h` seconds of a difference, from W on."""
    a, b = w_alpha, w_beta
    a1, b1 = a + h * d_alpha, b + h * d_beta
    third = h * (1.0 / 3.0)
    return Products(
        products.aa + third * (a * a + a * a1 + a1 * a1),
        products.bb + third * (b * b + b * b1 + b1 * b1),
        products.ab + third * (a * b + 0.5 * (a * b1 + a1 * b) + a1 * b1),
    )


@njit
def ripple_of(moments: Moments, products: Products, T_s: float) -> Ripple:
    """Return the ripple at the end of the period, by partial integration of its moments."""
    half = 0.5 * T_s
    eighth = 0.5 * half * half
    return Ripple(
        moments.alpha,
        moments.beta,
        half * moments.alpha - moments.alpha_1,
        half * moments.beta - moments.beta_1,
        eighth * moments.alpha - 0.5 * moments.alpha_2,
        eighth * moments.beta - 0.5 * moments.beta_2,
        products.aa,
        products.bb,
        products.ab,
    )


@called
def with_ripple(
    middle: State,
    end: State,
    ripple: Ripple,
    mean_alpha: float,
    mean_beta: float,
    T_s: float,
    machine: Machine,
    T_load: float,
) -> State:
    """Return the end of a period with what its ripple adds."""
    c, s = middle.cos_theta, middle.sin_theta
    product = (
        (ripple.ab * (c * c - s * s) + (ripple.bb - ripple.aa) * c * s) * machine.inv_L_d * machine.inv_L_q
    )
    odd = of_odd_ripple(
        middle, ripple.alpha_1, ripple.beta_1, mean_alpha, mean_beta, product, machine, T_load
    )
    w_d, w_q = scaled_voltage(middle, ripple.alpha_0, ripple.beta_0, machine)  # of the currents, As
    h_d, h_q = torque_slopes(middle, machine)
    domega = odd.omega_e + h_d * w_d + h_q * w_q
    x = turned(end, Addition(odd.i_d, odd.i_q, domega, odd.turn + 0.5 * T_s * domega), machine)
    w_d, w_q = scaled_voltage(x, ripple.alpha, ripple.beta, machine)
    n_d, n_q = scaled_voltage(x, ripple.alpha_0, ripple.beta_0, machine)
    w_d, w_q = w_d - machine.rho_d * n_d, w_q - machine.rho_q * n_q
    return with_currents(machine.saturation, x, x.i_d + w_d, x.i_q + w_q)
