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
from benchtool.emulator.machine.inverter import SQRT3
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
        salient * (c * c - s * s),
        salient * 2.0 * c * s,
        2.0 * middle.omega_e,
        0.5 * T_s,
    )


@njit
def currents_at(
    course: Course, time: float, w_alpha: float, w_beta: float, n_alpha: float, n_beta: float
) -> tuple[float, float, float]:
    """Return the currents of the phases at `time`, where the ripple is W and its integral n."""
    i_alpha = course.alpha_0 + time * (course.alpha_1 + time * course.alpha_2)
    i_beta = course.beta_0 + time * (course.beta_1 + time * course.beta_2)
    i_alpha += course.G * w_alpha - course.loss * n_alpha
    i_beta += course.G * w_beta - course.loss * n_beta
    at = course.turning * (time - course.middle)
    c, s = course.c - at * course.s, course.s + at * course.c
    i_alpha += c * w_alpha + s * w_beta
    i_beta += s * w_alpha - c * w_beta
    along, across = -0.5 * i_alpha, (0.5 * SQRT3) * i_beta
    return i_alpha, along + across, along - across


@njit
def currents_after(
    course: Course, time: float, ripple: Ripple, d_alpha: float, d_beta: float, h: float
) -> tuple[float, float, float]:
    """Return the currents of the phases at `time`, `h` after those of the ripple, which changes at a rate
    until then."""
    w_alpha, w_beta = ripple.alpha + h * d_alpha, ripple.beta + h * d_beta
    n_alpha = ripple.alpha_0 + 0.5 * h * (ripple.alpha + w_alpha)
    n_beta = ripple.beta_0 + 0.5 * h * (ripple.beta + w_beta)
    return currents_at(course, time, w_alpha, w_beta, n_alpha, n_beta)


@njit
def ahead(
    ripple: Ripple, d_alpha: float, d_beta: float, h: float, from_middle: float, products: bool
) -> Ripple:
    """Return the ripple after `h` seconds at this rate."""
    a, b = ripple.alpha, ripple.beta
    a1, b1 = a + h * d_alpha, b + h * d_beta
    mean_a, mean_b = 0.5 * (a + a1), 0.5 * (b + b1)
    aa, bb, ab = ripple.aa, ripple.bb, ripple.ab
    if products:
        third = h * (1.0 / 3.0)
        aa += third * (a * a + a * a1 + a1 * a1)
        bb += third * (b * b + b * b1 + b1 * b1)
        ab += third * (a * b + 0.5 * (a * b1 + a1 * b) + a1 * b1)
    sixth = h * h * (1.0 / 6.0)
    return Ripple(
        a1,
        b1,
        ripple.alpha_0 + h * mean_a,
        ripple.beta_0 + h * mean_b,
        ripple.alpha_1 + from_middle * h * mean_a + sixth * (a + 2.0 * a1),
        ripple.beta_1 + from_middle * h * mean_b + sixth * (b + 2.0 * b1),
        aa,
        bb,
        ab,
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
