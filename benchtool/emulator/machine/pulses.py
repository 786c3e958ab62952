"""A PWM period of real legs by its mean and the moments of its ripple: dead time and forward voltages.

`averaging` takes a period's pulses for centred and its mean voltage for known. Those of real legs are
neither: a dead time moves an edge by the sign of the current, a forward voltage turns with it, and a current
that comes to zero rests there where no device carries it on. So one step under the mean voltage of currents
that keep their signs gives a smooth course of the currents (`course`), and along it is seen whether they do.
Then the moments of the ripple have closed forms; else the legs are followed one change after the other
(`changes`).

The course decides only when a current is zero, where little hangs on it: an error of the current makes one of
the voltage by the share that two forward voltages have in what drives it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.averaging import link_current, overlaps
from benchtool.emulator.machine.changes import followed, sign_of
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.course import Course, Ripple, course_of, currents_at, with_ripple
from benchtool.emulator.machine.harmonics import linkage
from benchtool.emulator.machine.inverter import PowerStage, clarke, forward_voltage, phase_currents
from benchtool.emulator.machine.legs import duration_of
from benchtool.emulator.machine.plant import step_through
from benchtool.emulator.machine.state import State

_RIPPLE = 0.05  # of u_dc T_s / L, a usual ripple: smooth currents below it will change sign with it


class Pulse(NamedTuple):
    """What a leg makes while its current keeps its sign: u_dc from `rise` to `fall`, which is `mean` in the
    mean of the period."""

    rise: float
    fall: float
    mean: float
    sign: float


@called
def pulsed(
    x: State,
    duties: tuple[float, float, float],
    rise: tuple[float, float, float],
    fall: tuple[float, float, float],
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
) -> tuple[State, float, bool]:
    """Integrate one PWM period, with what dead time and devices make of pulses with these edges.

    Returns the charge drawn from the dc link as well, in As, and whether the period could be computed so:
    where two currents rest at zero at once it is to be integrated from edge to edge, and nothing has changed.
    """
    T_s, u_dc = stage.T_s, shaft.u_dc
    dead_time, drop = duration_of(stage.dead_time), forward_voltage(stage.devices)
    i_a, i_b, i_c = phase_currents(x)
    a = _pulse(duties[0], rise[0], fall[0], i_a, u_dc, dead_time, T_s)
    b = _pulse(duties[1], rise[1], fall[1], i_b, u_dc, dead_time, T_s)
    c = _pulse(duties[2], rise[2], fall[2], i_c, u_dc, dead_time, T_s)
    mean_alpha, mean_beta = clarke(a.mean - a.sign * drop, b.mean - b.sign * drop, c.mean - c.sign * drop)
    middle, end = step_through(x, mean_alpha, mean_beta, T_s, machine, T_load)
    course = course_of(x, middle, end, T_s, machine)
    small = dead_time * _steepest(x, u_dc, drop, machine)
    within_a = _within(a, dead_time, T_s, shaft.high_a, shaft.blank_a)
    within_b = _within(b, dead_time, T_s, shaft.high_b, shaft.blank_b)
    within_c = _within(c, dead_time, T_s, shaft.high_c, shaft.blank_c)
    j_a, j_b, j_c = phase_currents(middle)
    k_a, k_b, k_c = phase_currents(end)
    least = min(a.sign * i_a, b.sign * i_b, c.sign * i_c, a.sign * j_a, b.sign * j_b, c.sign * j_c)
    least = min(least, a.sign * k_a, b.sign * k_b, c.sign * k_c)
    if least > _RIPPLE * course.G * u_dc * T_s and within_a and within_b and within_c:
        rise_a, fall_a = _seen(course, a, b, c, a.rise, u_dc), _seen(course, a, b, c, a.fall, u_dc)
        rise_b, fall_b = _seen(course, a, b, c, b.rise, u_dc), _seen(course, a, b, c, b.fall, u_dc)
        rise_c, fall_c = _seen(course, a, b, c, c.rise, u_dc), _seen(course, a, b, c, c.fall, u_dc)
        switched = min(rise_a[0], fall_a[0], rise_b[1], fall_b[1], rise_c[2], fall_c[2])
        others = min(rise_a[1], rise_a[2], fall_a[1], fall_a[2], rise_b[0], rise_b[2], fall_b[0], fall_b[2])
        others = min(others, rise_c[0], rise_c[1], fall_c[0], fall_c[1])
        if switched > small and (drop == 0.0 or others > 0.0):
            ripple = _ripple(a, b, c, u_dc, T_s, machine)
            charge = _charge(x, middle, end, course, ripple, a, b, c, u_dc, T_s) if stage.metered else 0.0
            shaft.blank_a, shaft.blank_b, shaft.blank_c = 0.0, 0.0, 0.0
            return with_ripple(middle, end, ripple, mean_alpha, mean_beta, T_s, machine, T_load), charge, True
    return followed(
        x, middle, end, course, mean_alpha, mean_beta, small, rise, fall, shaft, stage, machine, T_load
    )


@njit
def _pulse(
    duty: float, rise: float, fall: float, current: float, u_dc: float, dead_time: float, T_s: float
) -> Pulse:
    """Return the pulse of a leg: a current out of it has it rise late, one into it has it fall late."""
    sign = sign_of(current)
    if duty <= 0.0 or duty >= 1.0:
        return Pulse(0.0, 0.0, u_dc * duty, sign)
    rise += dead_time if sign > 0.0 else 0.0
    fall += dead_time if sign < 0.0 else 0.0
    return Pulse(rise, fall, u_dc * (fall - rise) / T_s, sign)


@njit
def _steepest(x: State, u_dc: float, drop: float, machine: Machine) -> float:
    """Return a bound of the rate of a phase's current, in A/s."""
    current = abs(x.i_d) + abs(x.i_q)
    psi = machine.psi_r + linkage(machine.harmonics) + 2.0 * max(machine.L_d, machine.L_q) * current
    u = (2.0 / 3.0) * (u_dc + 2.0 * drop) + abs(x.omega_e) * psi + machine.R_s * current
    return 1.1 * max(machine.inv_L_d, machine.inv_L_q) * u


@njit
def _within(pulse: Pulse, dead_time: float, T_s: float, high: int, blank: float) -> bool:
    """Return whether a leg's pulse and its dead times lie within the period; `high` and `blank` are what the
    period before left over."""
    inside = 0.0 < pulse.rise < pulse.fall < T_s - dead_time
    return inside and high == 0 and blank == 0.0


@njit
def _seen(
    course: Course, a: Pulse, b: Pulse, c: Pulse, time: float, u_dc: float
) -> tuple[float, float, float]:
    """Return the currents of the phases at `time`, positive while they keep their signs."""
    w_a, n_a = _of_pulse(a, time, u_dc)
    w_b, n_b = _of_pulse(b, time, u_dc)
    w_c, n_c = _of_pulse(c, time, u_dc)
    w_alpha, w_beta = clarke(w_a, w_b, w_c)
    n_alpha, n_beta = clarke(n_a, n_b, n_c)
    i_a, i_b, i_c = currents_at(course, time, w_alpha, w_beta, n_alpha, n_beta)
    return a.sign * i_a, b.sign * i_b, c.sign * i_c


@njit
def _of_pulse(pulse: Pulse, time: float, u_dc: float) -> tuple[float, float]:
    """Return the integral of a pulse less its mean up to `time`, and the integral of that."""
    high, low = max(time - pulse.rise, 0.0), max(time - pulse.fall, 0.0)
    w = u_dc * (high - low) - pulse.mean * time
    return w, 0.5 * (u_dc * (high * high - low * low) - pulse.mean * time * time)


@njit
def _ripple(a: Pulse, b: Pulse, c: Pulse, u_dc: float, T_s: float, machine: Machine) -> Ripple:
    """Return the ripple at the end of the period, where it is zero, with its moments."""
    a_0, a_1 = _moments(a, u_dc, T_s)
    b_0, b_1 = _moments(b, u_dc, T_s)
    c_0, c_1 = _moments(c, u_dc, T_s)
    alpha_0, beta_0 = clarke(a_0, b_0, c_0)
    alpha_1, beta_1 = clarke(a_1, b_1, c_1)
    aa, bb, ab = 0.0, 0.0, 0.0
    if machine.sigma != 0.0:  # to second order in what dead times move the pulses by
        aa, bb, ab = overlaps((a.mean / u_dc, b.mean / u_dc, c.mean / u_dc))
        whole = u_dc * u_dc * T_s * T_s * T_s
        aa, bb, ab = whole * aa, whole * bb, whole * ab
    return Ripple(0.0, 0.0, alpha_0, beta_0, alpha_1, beta_1, aa, bb, ab)


@njit
def _moments(pulse: Pulse, u_dc: float, T_s: float) -> tuple[float, float]:
    """Return the integrals of w and (t - T_s / 2) w over the period, w as in `_of_pulse`."""
    high, low, width = T_s - pulse.rise, T_s - pulse.fall, pulse.fall - pulse.rise
    second = high * high - low * low
    third = high * high * high - low * low * low
    return (
        u_dc * 0.5 * (second - width * T_s),
        u_dc * (0.25 * T_s * second - (1.0 / 6.0) * third - (1.0 / 12.0) * width * T_s * T_s),
    )


@njit
def _charge(
    x: State,
    middle: State,
    end: State,
    course: Course,
    ripple: Ripple,
    a: Pulse,
    b: Pulse,
    c: Pulse,
    u_dc: float,
    T_s: float,
) -> float:
    """Return what the legs draw from the dc link.

    That is the duties times the integrals of the smooth currents, by Simpson's rule, and of their energy what
    pulses that are not centred meet: integrated by parts, the mean voltage with the ripple's current, and the
    ripple with the rate of the smooth one.
    """
    duties = (a.mean / u_dc, b.mean / u_dc, c.mean / u_dc)
    drawn = link_current(duties, x) + 4.0 * link_current(duties, middle) + link_current(duties, end)
    u_alpha, u_beta = clarke(a.mean, b.mean, c.mean)
    alpha_1 = course.alpha_1 + 2.0 * course.middle * course.alpha_2
    beta_1 = course.beta_1 + 2.0 * course.middle * course.beta_2
    energy = (course.G * u_alpha - alpha_1) * ripple.alpha_0 + (course.G * u_beta - beta_1) * ripple.beta_0
    energy -= 2.0 * (course.alpha_2 * ripple.alpha_1 + course.beta_2 * ripple.beta_1)
    energy += (course.c * u_alpha + course.s * u_beta) * ripple.alpha_0
    energy += (course.s * u_alpha - course.c * u_beta) * ripple.beta_0
    return T_s * (1.0 / 6.0) * drawn + 1.5 * energy / u_dc
