"""The machine: dq model of a permanent-magnet motor and its shaft, integrated under constant stator voltage.

Amplitude-invariant space vectors; the d axis lies on the rotor flux, which is along phase a at theta_e = 0.

    L_d d i_d/dt = u_d - R_s i_d + omega_e psi_q - e_d        psi_d = L_d i_d + psi_r
    L_q d i_q/dt = u_q - R_s i_q - omega_e psi_d - e_q        psi_q = L_q i_q
    J d omega_m/dt = T - T_cogging - B omega_m - T_friction - T_load
    T = 3/2 p (psi_d i_q - psi_q i_d) + harmonics

Between two switching edges the stator voltage is constant in alpha/beta, so in d/q it turns at -omega_e; it
is integrated along with the currents, in steps of the classical Runge-Kutta method of fourth order. The
direction of the rotor flux, (cos_theta, sin_theta), is carried along and turned by the angle of each step.

Harmonics of the flux, saturation, phases that differ, iron loss, cogging, dry friction and the drive train
beyond the rotor are optional parts of the machine, in modules of their own.
"""

from __future__ import annotations

import math

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.asymmetry import Asymmetry
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.cogging import less_cogging
from benchtool.emulator.machine.drive_train import (
    ahead,
    beyond,
    contact_of,
    stepped,
)
from benchtool.emulator.machine.harmonics import (
    Harmonics,
    flux_slope,
    with_harmonic_emf,
    with_harmonic_torque,
)
from benchtool.emulator.machine.iron import less_iron
from benchtool.emulator.machine.saturation import Saturation, currents_of
from benchtool.emulator.machine.shaft import (
    Friction,
    less_friction,
    sliding,
)
from benchtool.emulator.machine.state import State, electrical, state_at
from benchtool.emulator.machine.terminals import in_series, of_currents
from benchtool.emulator.rotate import rotate


@called
def current_rates(x: State, u_alpha: float, u_beta: float, m: Machine) -> tuple[float, float]:
    """Return the rates of i_d and i_q under a stator voltage."""
    y_d, y_q = electrical(m.saturation, x)
    v_d, v_q = scaled_voltage(x, u_alpha, u_beta, m)
    dy_d, dy_q, _, _, _ = derivative(y_d, y_q, x.omega_e, x.theta_e, v_d, v_q, m, 0.0)
    return of_currents(m.saturation, y_d, y_q, dy_d, dy_q)


@njit
def airgap_torque(y_d: float, y_q: float, theta_e: float, m: Machine) -> float:
    """Return the electromagnetic torque in Nm, 3/2 p (psi_s x i_s), with the torque of the flux harmonics.

    `y_d` and `y_q` are the electrical states.
    """
    i_d, i_q = currents_of(m.saturation, y_d, y_q)
    torque = _flux_cross_current(m.saturation, y_d, y_q, i_d, i_q, m.psi_r, m.L_d - m.L_q, 1.0)
    g_d, g_q = flux_slope(m.harmonics, math.cos(theta_e), math.sin(theta_e))
    return 1.5 * m.p * with_harmonic_torque(m.harmonics, torque, i_d, i_q, g_d, g_q, 1.0)


@njit
def _flux_cross_current(
    saturation: Saturation | None,
    y_d: float,
    y_q: float,
    i_d: float,
    i_q: float,
    by_rotor: float,
    by_saliency: float,
    gain: float,
) -> float:
    """Return psi_s x i_s times a gain, which is within `by_rotor` and `by_saliency` without saturation."""
    if saturation is None:
        return (by_rotor + by_saliency * i_d) * i_q
    return gain * (y_d * i_q - y_q * i_d)


@njit
def derivative(
    y_d: float,
    y_q: float,
    omega_e: float,
    theta_e: float,
    v_d: float,
    v_q: float,
    m: Machine,
    T_load: float,
    slide: float = 0.0,
) -> tuple[float, float, float, float, float]:
    """Return the rates of y_d, y_q, omega_e, v_d and v_q, where v_d = u_d / L_d and v_q = u_q / L_q.

    `y_d` and `y_q` are the electrical states. `slide` is the direction in which a shaft with dry friction
    slides; by default it sticks.
    """
    c, s = math.cos(theta_e), math.sin(theta_e)
    return _derivative_facing(y_d, y_q, omega_e, theta_e, c, s, v_d, v_q, m, T_load, slide)


@njit
def _derivative_facing(
    y_d: float,
    y_q: float,
    omega_e: float,
    theta_e: float,
    cos_theta: float,
    sin_theta: float,
    v_d: float,
    v_q: float,
    m: Machine,
    T_load: float,
    slide: float,
) -> tuple[float, float, float, float, float]:
    """Return `derivative` where the direction of the rotor flux is known, which spares its functions."""
    return _derivative_of(
        m.saturation,
        m.harmonics,
        m.asymmetry,
        y_d,
        y_q,
        omega_e,
        theta_e,
        cos_theta,
        sin_theta,
        v_d,
        v_q,
        m,
        T_load,
        slide,
    )


@njit
def _derivative_of(
    saturation: Saturation | None,
    harmonics: Harmonics | None,
    asymmetry: Asymmetry | None,
    y_d: float,
    y_q: float,
    omega_e: float,
    theta_e: float,
    cos_theta: float,
    sin_theta: float,
    v_d: float,
    v_q: float,
    m: Machine,
    T_load: float,
    slide: float,
) -> tuple[float, float, float, float, float]:
    """Return `derivative`, which is repeated at every call only where the machine is simple enough for
    that."""
    if saturation is not None:
        return _derivative_once(y_d, y_q, omega_e, theta_e, cos_theta, sin_theta, v_d, v_q, m, T_load, slide)
    if harmonics is not None:
        return _derivative_once(y_d, y_q, omega_e, theta_e, cos_theta, sin_theta, v_d, v_q, m, T_load, slide)
    if asymmetry is not None:
        return _derivative_once(y_d, y_q, omega_e, theta_e, cos_theta, sin_theta, v_d, v_q, m, T_load, slide)
    return _derivative(y_d, y_q, omega_e, theta_e, cos_theta, sin_theta, v_d, v_q, m, T_load, slide)


@called
def _derivative_once(
    y_d: float,
    y_q: float,
    omega_e: float,
    theta_e: float,
    cos_theta: float,
    sin_theta: float,
    v_d: float,
    v_q: float,
    m: Machine,
    T_load: float,
    slide: float,
) -> tuple[float, float, float, float, float]:
    return _derivative(y_d, y_q, omega_e, theta_e, cos_theta, sin_theta, v_d, v_q, m, T_load, slide)


@njit
def _derivative(
    y_d: float,
    y_q: float,
    omega_e: float,
    theta_e: float,
    cos_theta: float,
    sin_theta: float,
    v_d: float,
    v_q: float,
    m: Machine,
    T_load: float,
    slide: float,
) -> tuple[float, float, float, float, float]:
    i_d, i_q = currents_of(m.saturation, y_d, y_q)
    along, across = omega_e * m.k_d, omega_e * m.k_q
    dy_d = (v_d + along * y_q) - m.rho_d * i_d
    dy_q = (v_q - across * y_d) - (m.rho_q * i_q + omega_e * m.epsilon)
    g_d, g_q = flux_slope(m.harmonics, cos_theta, sin_theta)
    dy_d, dy_q = with_harmonic_emf(m.harmonics, dy_d, dy_q, omega_e, g_d, g_q, m.inv_L_d, m.inv_L_q)
    dy_d, dy_q = in_series(m.asymmetry, dy_d, dy_q, y_d, y_q, i_d, i_q, omega_e, cos_theta, sin_theta, m)
    domega = acceleration(y_d, y_q, i_d, i_q, omega_e, theta_e, cos_theta, sin_theta, g_d, g_q, m, T_load)
    domega = less_friction(m.friction, domega, omega_e, slide, m.gamma)
    return dy_d, dy_q, domega, along * v_q, -(across * v_d)


@njit
def acceleration(
    y_d: float,
    y_q: float,
    i_d: float,
    i_q: float,
    omega_e: float,
    theta_e: float,
    cos_theta: float,
    sin_theta: float,
    g_d: float,
    g_q: float,
    m: Machine,
    T_load: float,
) -> float:
    """Return the rate of omega_e without dry friction."""
    torque = _flux_cross_current(m.saturation, y_d, y_q, i_d, i_q, m.kappa, m.sigma, m.gamma * 1.5 * m.p)
    domega = torque - (m.beta * omega_e + m.gamma * T_load)
    domega = with_harmonic_torque(m.harmonics, domega, i_d, i_q, g_d, g_q, m.gamma * 1.5 * m.p)
    psi_d, psi_q = flux_linkages(m.saturation, y_d, y_q, m)
    domega = less_iron(m.iron, domega, psi_d, psi_q, omega_e, m.p, m.gamma)
    return less_cogging(m.cogging, domega, theta_e, cos_theta, sin_theta, m.gamma)


@njit
def acceleration_at(x: State, m: Machine, T_load: float) -> float:
    """Return the rate of omega_e in a state, without dry friction."""
    y_d, y_q = electrical(m.saturation, x)
    c, s = x.cos_theta, x.sin_theta
    g_d, g_q = flux_slope(m.harmonics, c, s)
    return acceleration(y_d, y_q, x.i_d, x.i_q, x.omega_e, x.theta_e, c, s, g_d, g_q, m, T_load)


@njit
def flux_linkages(saturation: Saturation | None, y_d: float, y_q: float, m: Machine) -> tuple[float, float]:
    """Return psi_d and psi_q of these electrical states, without harmonics."""
    if saturation is None:
        return m.L_d * y_d + m.psi_r, m.L_q * y_q
    return y_d, y_q


@njit
def scaled_voltage(x: State, u_alpha: float, u_beta: float, m: Machine) -> tuple[float, float]:
    """Return v_d = u_d / L_d and v_q = u_q / L_q of a stator voltage."""
    u_d = u_alpha * x.cos_theta + u_beta * x.sin_theta
    u_q = u_beta * x.cos_theta - u_alpha * x.sin_theta
    return u_d * m.inv_L_d, u_q * m.inv_L_q


@njit
def sliding_of(friction: Friction | None, x: State, m: Machine, T_load: float) -> float:
    """Return the direction in which the shaft slides, 1 or -1, and 0 while it sticks or has no friction."""
    if friction is None:
        return 0.0
    if x.omega_e != 0.0:
        return sliding(friction, x.omega_e, 0.0, m.gamma)
    return sliding(friction, x.omega_e, acceleration_at(x, m, T_load), m.gamma)


@njit
def step(x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float) -> State:
    """Return one Runge-Kutta step of `h` seconds under the constant voltage (u_alpha, u_beta)."""
    return _step_of(m.saturation, m.harmonics, m.asymmetry, x, u_alpha, u_beta, h, m, T_load)


@njit
def _step_of(
    saturation: Saturation | None,
    harmonics: Harmonics | None,
    asymmetry: Asymmetry | None,
    x: State,
    u_alpha: float,
    u_beta: float,
    h: float,
    m: Machine,
    T_load: float,
) -> State:
    """Return `step`, which is repeated at every call only where the machine is simple enough for that."""
    if saturation is not None:
        return _step_once(x, u_alpha, u_beta, h, m, T_load)
    if harmonics is not None:
        return _step_once(x, u_alpha, u_beta, h, m, T_load)
    if asymmetry is not None:
        return _step_once(x, u_alpha, u_beta, h, m, T_load)
    return _step(x, u_alpha, u_beta, h, m, T_load)


@called
def _step_once(x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float) -> State:
    return _step(x, u_alpha, u_beta, h, m, T_load)


@njit
def _step(x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float) -> State:
    after, _ = _through(x, u_alpha, u_beta, h, m, T_load)
    return after


@called
def step_through(
    x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float
) -> tuple[State, State]:
    """`step`, which returns the state half-way as well, to third order (Hairer, Norsett and Wanner, Solving
    ordinary differential equations I, II.6). Of machines without a drive train."""
    after, (y_d, y_q, omega_e, turn) = _through(x, u_alpha, u_beta, h, m, T_load)
    cos_theta, sin_theta = rotate(x.cos_theta, x.sin_theta, turn)
    middle = state_at(
        m.saturation, y_d, y_q, omega_e, x.theta_e + turn, x.theta_rest, cos_theta, sin_theta, x.far
    )
    return middle, after


@njit
def _through(
    x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float
) -> tuple[State, tuple[float, float, float, float]]:
    """Return `step`, and half-way the electrical states, the speed, and the angle turned by."""
    w, theta = x.omega_e, x.theta_e
    c, s = x.cos_theta, x.sin_theta
    y_d, y_q = electrical(m.saturation, x)
    v_d, v_q = scaled_voltage(x, u_alpha, u_beta, m)
    half = 0.5 * h
    contact = contact_of(m.train, x.far, w)
    T, a_far = beyond(m.train, x.far, w, theta, T_load, contact)
    slide = sliding_of(m.friction, x, m, T)

    a_d, a_q, a_w, a_vd, a_vq = _derivative_facing(y_d, y_q, w, theta, c, s, v_d, v_q, m, T, slide)

    w2 = w + half * a_w
    T, b_far = beyond(m.train, ahead(m.train, x.far, a_far, half), w2, theta + half * w, T_load, contact)
    c2, s2 = rotate(c, s, half * w)
    b_d, b_q, b_w, b_vd, b_vq = _derivative_facing(
        y_d + half * a_d,
        y_q + half * a_q,
        w2,
        theta + half * w,
        c2,
        s2,
        v_d + half * a_vd,
        v_q + half * a_vq,
        m,
        T,
        slide,
    )

    w3 = w + half * b_w
    T, c_far = beyond(m.train, ahead(m.train, x.far, b_far, half), w3, theta + half * w2, T_load, contact)
    c3, s3 = rotate(c, s, half * w2)
    c_d, c_q, c_w, c_vd, c_vq = _derivative_facing(
        y_d + half * b_d,
        y_q + half * b_q,
        w3,
        theta + half * w2,
        c3,
        s3,
        v_d + half * b_vd,
        v_q + half * b_vq,
        m,
        T,
        slide,
    )

    w4 = w + h * c_w
    T, d_far = beyond(m.train, ahead(m.train, x.far, c_far, h), w4, theta + h * w3, T_load, contact)
    c4, s4 = rotate(c, s, h * w3)
    d_d, d_q, d_w, _, _ = _derivative_facing(
        y_d + h * c_d,
        y_q + h * c_q,
        w4,
        theta + h * w3,
        c4,
        s4,
        v_d + h * c_vd,
        v_q + h * c_vq,
        m,
        T,
        slide,
    )

    sixth = h * (1.0 / 6.0)
    turn = sixth * (w + 2.0 * (w2 + w3) + w4)
    cos_theta, sin_theta = rotate(c, s, turn)
    theta, theta_rest = added(x.theta_e, x.theta_rest, turn)
    after = state_at(
        m.saturation,
        y_d + sixth * (a_d + 2.0 * (b_d + c_d) + d_d),
        y_q + sixth * (a_q + 2.0 * (b_q + c_q) + d_q),
        w + sixth * (a_w + 2.0 * (b_w + c_w) + d_w),
        theta,
        theta_rest,
        cos_theta,
        sin_theta,
        stepped(m.train, x.far, a_far, b_far, c_far, d_far, h),
    )
    part = 0.25 * sixth
    half_way = (
        y_d + part * (5.0 * a_d + 4.0 * (b_d + c_d) - d_d),
        y_q + part * (5.0 * a_q + 4.0 * (b_q + c_q) - d_q),
        w + part * (5.0 * a_w + 4.0 * (b_w + c_w) - d_w),
        part * (5.0 * w + 4.0 * (w2 + w3) - w4),
    )
    return after, half_way


@njit
def added(total: float, rest: float, increment: float) -> tuple[float, float]:
    """Compensated sum (Kahan): the total, and what its rounding left over for the next increment."""
    increment += rest
    new = total + increment
    return new, increment - (new - total)
