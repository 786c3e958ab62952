"""A PWM period of real legs followed from one change of a leg to the next, without a step of the machine.

While its current keeps its sign a leg is high for one time of the period, whatever its switches are told:
the dead time delays one edge of that. So the potentials are known beforehand, and along the course of the
currents under a mean voltage a current is a quadratic function of time from one change to the next. A current
that comes to zero ends an interval there; it goes on with the other sign where a device carries it, and else
rests, as the leg floats at the potential that leaves it none.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.course import (
    Course,
    Moments,
    Products,
    ahead,
    products_ahead,
    ripple_of,
    slopes_of,
    with_ripple,
)
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
_NEVER = 1e3  # s, beyond any period
_LEAST = 1e-300  # instead of zero, where zero is divided by it
_PARTS = 16  # of a period, in which a leg that floats is looked at again


@called
def followed(
    x: State,
    middle: State,
    end: State,
    course: Course,
    mean_alpha: float,
    mean_beta: float,
    rise: tuple[float, float, float],
    fall: tuple[float, float, float],
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
) -> tuple[State, float, bool]:
    """Return the end of a period from `x` whose course is that of a mean voltage, through `middle` to `end`.

    Returns the charge drawn from the dc link as well, in As, and whether the period could be followed so:
    where two currents rest at zero at once it could not, and nothing has changed.
    """
    T_s, u_dc = stage.T_s, shaft.u_dc
    dead_time, drop = duration_of(stage.dead_time), forward_voltage(stage.devices)
    i_a, i_b, i_c = phase_currents(x)
    sign_a, sign_b, sign_c = sign_of(i_a), sign_of(i_b), sign_of(i_c)
    told_a = _told(rise[0], fall[0], shaft.high_a, shaft.blank_a, dead_time)
    told_b = _told(rise[1], fall[1], shaft.high_b, shaft.blank_b, dead_time)
    told_c = _told(rise[2], fall[2], shaft.high_c, shaft.blank_c, dead_time)
    a, b, c = _NOT_HIGH, _NOT_HIGH, _NOT_HIGH
    moments, products = Moments(0.0, 0.0, 0.0, 0.0, 0.0, 0.0), Products(0.0, 0.0, 0.0)
    charge, time, changes, known_until = 0.0, 0.0, 0, 0.0
    while time < T_s:
        changes += 1
        if changes > _MOST_CHANGES:
            return x, 0.0, False
        if time >= known_until:
            a = _high(told_a, sign_a, time, dead_time)
            b = _high(told_b, sign_b, time, dead_time)
            c = _high(told_c, sign_c, time, dead_time)
            known_until = min(_left_over(told_a, time), _left_over(told_b, time), _left_over(told_c, time))
        until = min(_next(a, time), _next(b, time), _next(c, time), T_s)
        rail_a, rail_b, rail_c = _rail(a, time), _rail(b, time), _rail(c, time)
        v_a, v_b, v_c = (
            u_dc * rail_a - sign_a * drop,
            u_dc * rail_b - sign_b * drop,
            u_dc * rail_c - sign_c * drop,
        )
        if sign_a * sign_b * sign_c == 0.0:
            if abs(sign_a) + abs(sign_b) + abs(sign_c) < 2.0:
                return x, 0.0, False
            phase = 0 if sign_a == 0.0 else (1 if sign_b == 0.0 else 2)
            told = told_a if phase == 0 else (told_b if phase == 1 else told_c)
            off, rail, change = _switches(told, time, dead_time)
            until = min(until, change, time + T_s / _PARTS)
            v_a, v_b, v_c = _put(phase, u_dc * rail, v_a, v_b, v_c)
            current = i_a if phase == 0 else (i_b if phase == 1 else i_c)
            carries, found = _floating(
                phase,
                current,
                v_a,
                v_b,
                v_c,
                off,
                time,
                until - time,
                course,
                moments.alpha,
                moments.beta,
                mean_alpha,
                mean_beta,
                u_dc,
                drop,
            )
            if carries != 0.0:
                sign_a, sign_b, sign_c = _put(phase, carries, sign_a, sign_b, sign_c)
                known_until = time
                continue
            v_a, v_b, v_c = _put(phase, u_dc * rail + found, v_a, v_b, v_c)
        h = until - time
        u_alpha, u_beta = clarke(v_a, v_b, v_c)
        d_alpha, d_beta = u_alpha - mean_alpha, u_beta - mean_beta
        k, bend = slopes_of(course, time, moments.alpha, moments.beta, d_alpha, d_beta)
        j_a, j_b, j_c = (
            _after(i_a, k[0], bend[0], h),
            _after(i_b, k[1], bend[1], h),
            _after(i_c, k[2], bend[2], h),
        )
        if min(sign_a * j_a, sign_b * j_b, sign_c * j_c) < 0.0:
            h_a, h_b, h_c = (
                crossing(sign_a, i_a, k[0], bend[0], j_a),
                crossing(sign_b, i_b, k[1], bend[1], j_b),
                crossing(sign_c, i_c, k[2], bend[2], j_c),
            )
            phase = 0 if h_a <= min(h_b, h_c) else (1 if h_b <= h_c else 2)
            h = min(h_a, h_b, h_c, h)
            until = time + h
            j_a, j_b, j_c = _put(
                phase,
                0.0,
                _after(i_a, k[0], bend[0], h),
                _after(i_b, k[1], bend[1], h),
                _after(i_c, k[2], bend[2], h),
            )
            sign_a, sign_b, sign_c = _put(phase, 0.0, sign_a, sign_b, sign_c)
            known_until = until
        if stage.metered:
            charge += 0.5 * h * (rail_a * (i_a + j_a) + rail_b * (i_b + j_b) + rail_c * (i_c + j_c))
        if machine.sigma != 0.0:
            products = products_ahead(products, moments.alpha, moments.beta, d_alpha, d_beta, h)
        moments = ahead(moments, d_alpha, d_beta, h, time - 0.5 * T_s)
        i_a, i_b, i_c = j_a, j_b, j_c
        time = until
    shaft.blank_a = _blank_after(told_a, T_s, dead_time)
    shaft.blank_b = _blank_after(told_b, T_s, dead_time)
    shaft.blank_c = _blank_after(told_c, T_s, dead_time)
    ripple = ripple_of(moments, products, T_s)
    end = with_ripple(middle, end, ripple, mean_alpha, mean_beta, T_s, machine, T_load)
    return _without(end, sign_a, sign_b, sign_c, machine), charge, True


@njit
def sign_of(current: float) -> float:
    """Return 1 or -1, and 0 for no current."""
    return math.copysign(1.0, current) * (abs(current) > _ZERO)


class _Told(NamedTuple):
    """When a leg is told to be high, and until when neither switch is on by what the period before left.

    A leg that is told to be high from the start rises as early as leaves it the dead time that it has.
    """

    rise: float
    fall: float
    left_over: float


@njit
def _told(rise: float, fall: float, was_high: int, blank: float, dead_time: float) -> _Told:
    starts_high = rise <= 0.0
    if starts_high != (was_high != 0):
        blank = dead_time
    if starts_high:
        return _Told(blank - dead_time, min(fall, _NEVER), 0.0)
    if rise >= _NEVER:
        return _Told(_NEVER, _NEVER, blank)
    return _Told(rise, fall, blank)


@njit
def _blank_after(told: _Told, T_s: float, dead_time: float) -> float:
    """Return the dead time that the end of the period leaves over."""
    since = told.fall if told.fall < T_s else (told.rise if told.rise < T_s else told.left_over - dead_time)
    return max(since + dead_time - T_s, 0.0)


class _High(NamedTuple):
    """From when until when a leg is high."""

    start: float
    stop: float


_NOT_HIGH = _High(_NEVER, _NEVER)


@njit
def _high(told: _Told, sign: float, time: float, dead_time: float) -> _High:
    """Return when from `time` on a leg is high whose current keeps its sign: of one without, never."""
    if sign > 0.0:
        return _High(told.rise + dead_time, told.fall)
    if sign == 0.0:
        return _High(_NEVER, _NEVER)
    if time < told.left_over:
        return _High(-1.0, told.left_over)
    return _High(told.rise, told.fall + dead_time)


@njit
def _left_over(told: _Told, time: float) -> float:
    """Return when the dead time ends that the period before has left over, if it has not."""
    return told.left_over if time < told.left_over else _NEVER


# What follows is computed without a branch, because the order of the legs' changes is unpredictable to a
# processor.


@njit
def _next(high: _High, time: float) -> float:
    """Return when a leg changes next after `time`."""
    second = high.stop if high.stop > time else _NEVER
    return high.start if high.start > time else second


@njit
def _rail(high: _High, time: float) -> float:
    """Return the rail that a leg is at, 1 or 0."""
    return 1.0 if (time >= high.start) & (time < high.stop) else 0.0


@njit
def _after(i: float, k: float, bend: float, h: float) -> float:
    return i + h * (k + h * bend)


@njit
def crossing(sign: float, i: float, k: float, bend: float, after: float) -> float:
    """Return when a current i + h k + h^2 bend first comes to zero whose sign is another in `after`, at the
    end of an interval; else never."""
    if sign * after >= 0.0:
        return _NEVER
    start, slope, curve = max(sign * i, 0.0), sign * k, sign * bend
    root = math.sqrt(max(slope * slope - 4.0 * curve * start, 0.0))
    if slope > 0.0 and curve < 0.0:
        return (slope + root) / (-2.0 * curve)
    return 2.0 * start / max(root - slope, _LEAST)


@njit
def _put(phase: int, value: float, a: float, b: float, c: float) -> tuple[float, float, float]:
    """Return the phases with the value of one replaced."""
    return value if phase == 0 else a, value if phase == 1 else b, value if phase == 2 else c


@njit
def _switches(told: _Told, time: float, dead_time: float) -> tuple[float, float, float]:
    """Return whether neither switch of a leg is on, 1 or 0, the rail that it is at, half-way between them
    where neither is on, and when that changes next."""
    blank = told.left_over
    change = blank if blank > time else _NEVER
    high = 0.0
    if time < told.rise:
        change = min(change, told.rise)
    elif time < told.fall:
        high, blank = 1.0, told.rise + dead_time
        change = min(told.fall, blank if blank > time else _NEVER)
    elif told.fall < _NEVER:
        blank = told.fall + dead_time
        change = blank if blank > time else _NEVER
    if time < blank:
        return 1.0, 0.5, change
    return 0.0, high, change


@called
def _floating(
    phase: int,
    current: float,
    v_a: float,
    v_b: float,
    v_c: float,
    off: float,
    time: float,
    h: float,
    course: Course,
    w_alpha: float,
    w_beta: float,
    mean_alpha: float,
    mean_beta: float,
    u_dc: float,
    drop: float,
) -> tuple[float, float]:
    """Return whether a device carries the current of a leg that has none, its sign or 0, and by how much the
    potential at which it else floats for the next `h` seconds is above that of the phases given."""
    n_alpha = 1.0 if phase == 0 else -0.5
    n_beta = 0.0 if phase == 0 else (0.5 * SQRT3 if phase == 1 else -0.5 * SQRT3)
    u_alpha, u_beta = clarke(v_a, v_b, v_c)
    k, bend = slopes_of(course, time, w_alpha, w_beta, u_alpha - mean_alpha, u_beta - mean_beta)
    k_n = k[0] if phase == 0 else (k[1] if phase == 1 else k[2])
    bend_n = bend[0] if phase == 0 else (bend[1] if phase == 1 else bend[2])
    at = course.turning * (time + h - course.middle)
    c, s = course.c - at * course.s, course.s + at * course.c
    G = course.G + c * (n_alpha * n_alpha - n_beta * n_beta) + 2.0 * s * n_alpha * n_beta
    either = drop + 0.5 * u_dc * off
    change = -1.5 * _after(current, k_n, bend_n, h) / (h * G - 0.5 * h * h * course.loss)
    if abs(change) > either:
        return math.copysign(1.0, -change), 0.0
    return 0.0, change


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
