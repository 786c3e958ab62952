"""A PWM period of real legs followed from one change of a leg to the next, without a step of the machine.

Along the course of the currents under a mean voltage each leg's potential is known from what its switches are
told and the sign of its current. A current that comes to zero ends an interval there; it goes on with the
other sign where a device carries it, and else rests, as the leg floats at the potential that leaves it none.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.course import Course, Ripple, ahead, currents_after, with_ripple
from benchtool.emulator.machine.inverter import (
    SQRT3,
    PowerStage,
    clarke,
    forward_voltage,
    phase_currents,
)
from benchtool.emulator.machine.legs import duration_of
from benchtool.emulator.machine.state import State, with_currents

_ZERO = 1e-9  # A, below which a phase has no current
_MOST_CHANGES = 64  # in a period: one that has more is left to the steps between edges
_NEVER = 1e3  # s, beyond any period; not infinite, as zero times that is nothing
_PARTS = 16  # of a period, in which a leg that floats is looked at again


@called
def followed(
    x: State,
    middle: State,
    end: State,
    course: Course,
    mean_alpha: float,
    mean_beta: float,
    small: float,
    rise: tuple[float, float, float],
    fall: tuple[float, float, float],
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
) -> tuple[State, float, bool]:
    """Return the end of a period from `x` whose course is that of a mean voltage, through `middle` to `end`.

    `small` is the current beyond which none ends within a dead time.

    Returns the charge drawn from the dc link as well, in As, and whether the period could be followed so:
    where two currents rest at zero at once it could not, and nothing has changed.
    """
    T_s, u_dc = stage.T_s, shaft.u_dc
    dead_time, drop = duration_of(stage.dead_time), forward_voltage(stage.devices)
    i_a, i_b, i_c = phase_currents(x)
    a = _at_the_start(rise[0], fall[0], shaft.high_a, shaft.blank_a, dead_time)
    b = _at_the_start(rise[1], fall[1], shaft.high_b, shaft.blank_b, dead_time)
    c = _at_the_start(rise[2], fall[2], shaft.high_c, shaft.blank_c, dead_time)
    sign_a, sign_b, sign_c = sign_of(i_a), sign_of(i_b), sign_of(i_c)
    ripple = Ripple(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    charge, time, changes = 0.0, 0.0, 0
    # without forward voltages a current passes zero as the switches are: their edges count
    beyond = dead_time if drop > 0.0 else 0.0
    while time < T_s:
        changes += 1
        resting = sign_a * sign_b * sign_c == 0.0
        if changes > _MOST_CHANGES or (resting and abs(sign_a) + abs(sign_b) + abs(sign_c) < 2.0):
            return x, 0.0, False
        a, b, c = (
            _told(a, time, dead_time),
            _told(b, time, dead_time),
            _told(c, time, dead_time),
        )
        off_a, rail_a, change_a = _rail(a, time, sign_a, i_a, small, beyond)
        off_b, rail_b, change_b = _rail(b, time, sign_b, i_b, small, beyond)
        off_c, rail_c, change_c = _rail(c, time, sign_c, i_c, small, beyond)
        until = min(change_a, change_b, change_c, T_s)
        if resting:
            until = min(until, time + T_s / _PARTS)
        h = until - time
        v_a, v_b, v_c = (
            u_dc * rail_a - sign_a * drop,
            u_dc * rail_b - sign_b * drop,
            u_dc * rail_c - sign_c * drop,
        )
        if resting:
            v_a, v_b, v_c, sign_a, sign_b, sign_c = _resting(
                (v_a, v_b, v_c),
                (sign_a, sign_b, sign_c),
                (off_a, off_b, off_c),
                h,
                time,
                course,
                ripple,
                mean_alpha,
                mean_beta,
                u_dc,
                drop,
            )
        u_alpha, u_beta = clarke(v_a, v_b, v_c)
        d_alpha, d_beta = u_alpha - mean_alpha, u_beta - mean_beta
        j_a, j_b, j_c = currents_after(course, until, ripple, d_alpha, d_beta, h)
        if drop == 0.0 and min(sign_a * j_a, sign_b * j_b, sign_c * j_c) < 0.0:
            # a switch that is on carries currents of both signs alike
            sign_a = -sign_a if sign_a * j_a < 0.0 and off_a == 0.0 else sign_a
            sign_b = -sign_b if sign_b * j_b < 0.0 and off_b == 0.0 else sign_b
            sign_c = -sign_c if sign_c * j_c < 0.0 and off_c == 0.0 else sign_c
        if min(sign_a * j_a, sign_b * j_b, sign_c * j_c) < 0.0:
            part_a, part_b, part_c = (
                _crossing(sign_a, i_a, j_a),
                _crossing(sign_b, i_b, j_b),
                _crossing(sign_c, i_c, j_c),
            )
            part = min(part_a, part_b, part_c)
            phase = 0 if part == part_a else (1 if part == part_b else 2)
            whole = h
            slope = _of(phase, j_a, j_b, j_c) - _of(phase, i_a, i_b, i_c)
            for _ in range(3):
                h = part * whole
                j_a, j_b, j_c = currents_after(course, time + h, ripple, d_alpha, d_beta, h)
                part = min(max(part - _of(phase, j_a, j_b, j_c) / slope, 0.0), 1.0)
            until = time + h
            sign_a, j_a = (0.0, 0.0) if phase == 0 else (sign_a, j_a)
            sign_b, j_b = (0.0, 0.0) if phase == 1 else (sign_b, j_b)
            sign_c, j_c = (0.0, 0.0) if phase == 2 else (sign_c, j_c)
        if stage.metered:
            drawn = _drawn(off_a, a.high, i_a + j_a) + _drawn(off_b, b.high, i_b + j_b)
            charge += 0.5 * h * (drawn + _drawn(off_c, c.high, i_c + j_c))
        ripple = ahead(ripple, d_alpha, d_beta, h, time - 0.5 * T_s, machine.sigma != 0.0)
        i_a, i_b, i_c = j_a, j_b, j_c
        time = until
    a, b, c = _told(a, T_s, dead_time), _told(b, T_s, dead_time), _told(c, T_s, dead_time)
    shaft.blank_a = max(a.blank - T_s, 0.0)
    shaft.blank_b = max(b.blank - T_s, 0.0)
    shaft.blank_c = max(c.blank - T_s, 0.0)
    end = with_ripple(middle, end, ripple, mean_alpha, mean_beta, T_s, machine, T_load)
    return _without(end, sign_a, sign_b, sign_c, machine), charge, True


@njit
def sign_of(current: float) -> float:
    """Return 1 or -1, and 0 for no current."""
    return math.copysign(1.0, current) * (abs(current) > _ZERO)


class _Leg(NamedTuple):
    """Whether a leg is told to be high, 1 or 0, its next two edges, and until when neither switch is on."""

    high: float
    edge: float
    following: float
    blank: float


@njit
def _at_the_start(rise: float, fall: float, was_high: int, blank: float, dead_time: float) -> _Leg:
    """Return a leg at the start of a period, where what it is told may change."""
    rise, fall = min(rise, _NEVER), min(fall, _NEVER)
    starts_high = rise <= 0.0
    if starts_high != (was_high != 0):
        blank = dead_time
    if starts_high:
        return _Leg(1.0, fall, _NEVER, blank)
    return _Leg(0.0, rise, fall, blank)


# What follows is computed without a branch, because the order of the legs' changes is unpredictable to a
# processor: whether is 1 or 0.


@njit
def _told(leg: _Leg, time: float, dead_time: float) -> _Leg:
    """Return the leg at `time`, which is at its next edge at the latest: a change begins a dead time."""
    passed = 1.0 * (time >= leg.edge)
    kept = 1.0 - passed
    return _Leg(
        leg.high + passed * (1.0 - 2.0 * leg.high),
        kept * leg.edge + passed * leg.following,
        kept * leg.following + passed * _NEVER,
        kept * leg.blank + passed * (leg.edge + dead_time),
    )


@njit
def _rail(
    leg: _Leg, time: float, sign: float, current: float, small: float, beyond: float
) -> tuple[float, float, float]:
    """Return whether neither switch is on, the rail that the leg is at, 1 or 0, half-way between them where
    nothing decides, and when that may change next.

    An edge that leaves a leg where the current holds it changes nothing until the dead time that it begins
    has passed, `beyond`.
    """
    off = 1.0 * (time < leg.blank)
    rail = off * (0.5 - 0.5 * sign) + (1.0 - off) * leg.high
    ends = off * (1.0 * ((rail != leg.high) | (abs(current) <= small)))  # of a dead time that has an effect
    held = 1.0 * ((rail == 0.5 - 0.5 * sign) & (leg.following > leg.edge + beyond))
    return off, rail, min(leg.edge + held * beyond, ends * leg.blank + (1.0 - ends) * _NEVER)


@called
def _resting(
    v: tuple[float, float, float],
    sign: tuple[float, float, float],
    off: tuple[float, float, float],
    h: float,
    time: float,
    course: Course,
    ripple: Ripple,
    mean_alpha: float,
    mean_beta: float,
    u_dc: float,
    drop: float,
) -> tuple[float, float, float, float, float, float]:
    """Return potentials and signs of the currents with those of the leg that has none for the next `h`
    seconds: a sign if a device carries a current, or 0 where it floats at the potential that leaves it
    none."""
    (v_a, v_b, v_c), (sign_a, sign_b, sign_c) = v, sign
    phase, n_alpha, n_beta, is_off, found = 0, 1.0, 0.0, off[0], v_a
    if sign_b == 0.0:
        phase, n_alpha, n_beta, is_off, found = 1, -0.5, 0.5 * SQRT3, off[1], v_b
    elif sign_c == 0.0:
        phase, n_alpha, n_beta, is_off, found = 2, -0.5, -0.5 * SQRT3, off[2], v_c
    u_alpha, u_beta = clarke(v_a, v_b, v_c)
    d_alpha, d_beta = u_alpha - mean_alpha, u_beta - mean_beta
    i_a, i_b, i_c = currents_after(course, time + h, ripple, d_alpha, d_beta, h)
    at = course.turning * (time + h - course.middle)
    c, s = course.c - at * course.s, course.s + at * course.c
    G = course.G + c * (n_alpha * n_alpha - n_beta * n_beta) + 2.0 * s * n_alpha * n_beta
    either = drop + 0.5 * u_dc * is_off
    change = -1.5 * _of(phase, i_a, i_b, i_c) / (h * G - 0.5 * h * h * course.loss)
    carries = 0.0
    if abs(change) > either:
        carries, change = math.copysign(1.0, -change), math.copysign(either, change)
    found += change
    if phase == 0:
        return found, v_b, v_c, carries, sign_b, sign_c
    if phase == 1:
        return v_a, found, v_c, sign_a, carries, sign_c
    return v_a, v_b, found, sign_a, sign_b, carries


@njit
def _crossing(sign: float, before: float, after: float) -> float:
    """Return the part of an interval after which a current is zero, by the secant; 1 if it keeps its sign."""
    start = max(sign * before, 0.0)
    return start / (start - sign * after) if sign * after < 0.0 else 1.0


@njit
def _of(phase: int, a: float, b: float, c: float) -> float:
    if phase == 0:
        return a
    return b if phase == 1 else c


@njit
def _drawn(off: float, high: float, current: float) -> float:
    """Return what a leg draws from the dc link; one that is off feeds it."""
    return off * min(current, 0.0) + (1.0 - off) * high * current


@njit
def _without(x: State, sign_a: float, sign_b: float, sign_c: float, machine: Machine) -> State:
    """Return the state without current in a phase that rests."""
    n_alpha, n_beta = 1.0, 0.0
    if sign_b == 0.0:
        n_alpha, n_beta = -0.5, 0.5 * SQRT3
    elif sign_c == 0.0:
        n_alpha, n_beta = -0.5, -0.5 * SQRT3
    elif sign_a != 0.0:
        return x
    n_d = n_alpha * x.cos_theta + n_beta * x.sin_theta
    n_q = n_beta * x.cos_theta - n_alpha * x.sin_theta
    along = x.i_d * n_d + x.i_q * n_q
    return with_currents(machine.saturation, x, x.i_d - along * n_d, x.i_q - along * n_q)
