"""The machine: dq model of a permanent-magnet motor and its shaft, integrated under constant stator voltage.

Amplitude-invariant space vectors; the d axis lies on the rotor flux, which is along phase a at theta_e = 0.

    L_d d i_d/dt = u_d - R_s i_d + omega_e psi_q - e_d        psi_d = L_d i_d + psi_r
    L_q d i_q/dt = u_q - R_s i_q - omega_e psi_d - e_q        psi_q = L_q i_q
    J d omega_m/dt = T - T_cogging - B omega_m - T_friction - T_load
    T = 3/2 p (psi_d i_q - psi_q i_d) + harmonics

Between two switching edges the stator voltage is constant in alpha/beta, so in d/q it turns at -omega_e; it
is integrated along with the currents, in steps of the classical Runge-Kutta method of fourth order. The
direction of the rotor flux, (cos_theta, sin_theta), is carried along and turned by the angle of each step.

Harmonics of the flux, cogging, dry friction and the drive train beyond the rotor are optional parts of the
machine, in modules of their own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.cogging import (
    Cogging,
    cogging_stiffness,
    cogging_turning,
    less_cogging,
)
from benchtool.emulator.machine.coupling import Coupling, Play, distance, landed, meeting, part_until
from benchtool.emulator.machine.drive_train import (
    DriveTrain,
    Far,
    ahead,
    beyond,
    contact_of,
    fastest_omega,
    holds_rotor,
    slip_of,
    stepped,
    told,
    train_rate,
    train_turning,
)
from benchtool.emulator.machine.harmonics import (
    Harmonics,
    harmonic_turning,
    linkage,
    with_harmonic_emf,
    with_harmonic_torque,
)
from benchtool.emulator.machine.shaft import (
    Friction,
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
    epsilon: float  # psi_r / L_q, the back EMF; zero with open terminals
    gamma: float  # p / (J + J_load); zero with held speed, as are the three below
    kappa: float  # gamma 3/2 p psi_r
    sigma: float  # gamma 3/2 p (L_d - L_q)
    beta: float  # gamma B / p


class State(NamedTuple):
    """Currents, electrical speed and angle; `theta_e` never wraps, `theta_rest` is its rounding."""

    i_d: float
    i_q: float
    omega_e: float
    theta_e: float
    theta_rest: float
    cos_theta: float
    sin_theta: float
    far: Far


@njit
def place(i_d: float, i_q: float, omega_e: float, theta_e: float) -> State:
    """Return the state with its direction derived from the angle, and the load side at rest."""
    return State(i_d, i_q, omega_e, theta_e, 0.0, math.cos(theta_e), math.sin(theta_e), Far(0.0, 0.0, 0.0))


@njit
def facing(x: State, far: Far) -> State:
    """Return the state with another load side."""
    return State(x.i_d, x.i_q, x.omega_e, x.theta_e, x.theta_rest, x.cos_theta, x.sin_theta, far)


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
    return Machine(
        p,
        R_s,
        L_d,
        L_q,
        psi_r,
        J,
        B,
        harmonics,
        cogging,
        friction,
        J_load,
        train,
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
        m.harmonics,
        m.cogging,
        m.friction,
        m.J_load,
        train,
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
    rate = m.R_s * inv_L + math.sqrt(m.gamma * stiffness) + m.gamma * friction
    return rate + train_rate(m.train, m.gamma)


@njit
def turning_rate(m: Machine) -> float:
    """Return the rate in 1/s that every electrical rad/s adds to `fastest_rate`."""
    turning = max(1.0, m.k_d, m.k_q) + harmonic_turning(m.harmonics) + cogging_turning(m.cogging)
    return turning + train_turning(m.train, m.gamma)


@njit
def rate_at(x: State, at_rest: float, moving: float, m: Machine) -> float:
    """Return the sum of the machine's rates, of `fastest_rate` and `turning_rate`, at the speed of `x`."""
    return at_rest + moving * fastest_omega(m.train, x.far, x.omega_e)


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
    domega = acceleration(i_d, i_q, omega_e, theta_e, m, T_load)
    domega = less_friction(m.friction, domega, omega_e, slide, m.gamma)
    return di_d, di_q, domega, along * v_q, -(across * v_d)


@njit
def acceleration(i_d: float, i_q: float, omega_e: float, theta_e: float, m: Machine, T_load: float) -> float:
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
    contact = contact_of(m.train, x.far, w)
    T, a_far = beyond(m.train, x.far, w, theta, T_load, contact)
    slide = sliding(m.friction, w, acceleration(i_d, i_q, w, theta, m, T), m.gamma)

    a_d, a_q, a_w, a_vd, a_vq = derivative(i_d, i_q, w, theta, v_d, v_q, m, T, slide)

    w2 = w + half * a_w
    T, b_far = beyond(m.train, ahead(m.train, x.far, a_far, half), w2, theta + half * w, T_load, contact)
    b_d, b_q, b_w, b_vd, b_vq = derivative(
        i_d + half * a_d,
        i_q + half * a_q,
        w2,
        theta + half * w,
        v_d + half * a_vd,
        v_q + half * a_vq,
        m,
        T,
        slide,
    )

    w3 = w + half * b_w
    T, c_far = beyond(m.train, ahead(m.train, x.far, b_far, half), w3, theta + half * w2, T_load, contact)
    c_d, c_q, c_w, c_vd, c_vq = derivative(
        i_d + half * b_d,
        i_q + half * b_q,
        w3,
        theta + half * w2,
        v_d + half * b_vd,
        v_q + half * b_vq,
        m,
        T,
        slide,
    )

    w4 = w + h * c_w
    T, d_far = beyond(m.train, ahead(m.train, x.far, c_far, h), w4, theta + h * w3, T_load, contact)
    d_d, d_q, d_w, _, _ = derivative(
        i_d + h * c_d, i_q + h * c_q, w4, theta + h * w3, v_d + h * c_vd, v_q + h * c_vq, m, T, slide
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
        stepped(m.train, x.far, a_far, b_far, c_far, d_far, h),
    )


@njit
def move(x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float) -> tuple[State, float]:
    """`step` that ends early where dry friction brings the shaft to rest, or where faces of a coupling meet
    or part. Returns its length as well."""
    after = step(x, u_alpha, u_beta, h, m, T_load)
    part = part_until_rest(m.friction, x.omega_e, after.omega_e)
    if part < 1.0:
        h = part * h
        y = step(x, u_alpha, u_beta, h, m, T_load)
        after = State(y.i_d, y.i_q, 0.0, y.theta_e, y.theta_rest, y.cos_theta, y.sin_theta, y.far)
    return _until_contact(m.train, x, after, u_alpha, u_beta, h, m, T_load)


@njit
def _until_contact(
    train: DriveTrain | None,
    x: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    h: float,
    m: Machine,
    T_load: float,
) -> tuple[State, float]:
    """Return state and length of a step that ends where faces of a coupling meet or part, if it has play."""
    if train is None:
        return after, h
    return _until_faces(train.coupling, train, x, after, u_alpha, u_beta, h, m, T_load)


@njit
def _until_faces(
    coupling: Coupling | None,
    train: DriveTrain,
    x: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    h: float,
    m: Machine,
    T_load: float,
) -> tuple[State, float]:
    if coupling is None:
        return after, h
    return _until_meeting(coupling.play, coupling, train, x, after, u_alpha, u_beta, h, m, T_load)


@njit
def _until_meeting(
    play: Play | None,
    coupling: Coupling,
    train: DriveTrain,
    x: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    h: float,
    m: Machine,
    T_load: float,
) -> tuple[State, float]:
    if play is None:
        return after, h
    slip, slip_after = slip_of(train, x.far, x.omega_e), slip_of(train, after.far, after.omega_e)
    contact = contact_of(train, x.far, x.omega_e)
    what = meeting(play, coupling, x.far.twist, slip, after.far.twist, slip_after, contact)
    if not what.happens:
        return after, h
    start = distance(play, coupling, what, x.far.twist, slip)
    at = distance(play, coupling, what, after.far.twist, slip_after)
    whole, part, slope = h, 1.0, at - start
    for _ in range(3):
        part = part_until(what, part - at / slope)
        h = part * whole
        after = step(x, u_alpha, u_beta, h, m, T_load)
        at = distance(play, coupling, what, after.far.twist, slip_of(train, after.far, after.omega_e))
    far = Far(after.far.omega, landed(play, what, after.far.twist), after.far.torque)
    return facing(after, far), h


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
        h = substep(remaining, rate_at(x, at_rest, moving, m), turn)
        x, h = move(x, u_alpha, u_beta, h, m, T_load)
        remaining, rest = added(remaining, rest, -h)
    return x


@njit
def added(total: float, rest: float, increment: float) -> tuple[float, float]:
    """Compensated sum (Kahan): the total, and what its rounding left over for the next increment."""
    increment += rest
    new = total + increment
    return new, increment - (new - total)
