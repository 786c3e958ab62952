"""Steps of the machine, as many as the time asks for; one ends early where dry friction brings the shaft to
rest, or where faces of a coupling meet or part."""

from __future__ import annotations

import math

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.coefficients import Machine, fastest_rate, rate_at, turning_rate
from benchtool.emulator.machine.coupling import Coupling, Play, distance, landed, meeting, part_until
from benchtool.emulator.machine.drive_train import DriveTrain, Far, contact_of, slip_of
from benchtool.emulator.machine.plant import added, step
from benchtool.emulator.machine.shaft import part_until_rest
from benchtool.emulator.machine.state import State, facing


@njit
def move(x: State, u_alpha: float, u_beta: float, h: float, m: Machine, T_load: float) -> tuple[State, float]:
    """`step` that ends early where dry friction brings the shaft to rest, or where faces of a coupling meet
    or part. Returns its length as well."""
    after = step(x, u_alpha, u_beta, h, m, T_load)
    part = part_until_rest(m.friction, x.omega_e, after.omega_e)
    if part < 1.0:
        h = part * h
        y = step(x, u_alpha, u_beta, h, m, T_load)
        after = State(y.i_d, y.i_q, 0.0, y.theta_e, y.theta_rest, y.cos_theta, y.sin_theta, y.far, y.flux)
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
    at_rest, moving = fastest_rate(m, x), turning_rate(m)
    remaining, rest = duration, 0.0
    while remaining > 0.0:
        h = substep(remaining, rate_at(x, at_rest, moving, m), turn)
        x, h = move(x, u_alpha, u_beta, h, m, T_load)
        remaining, rest = added(remaining, rest, -h)
    return x
