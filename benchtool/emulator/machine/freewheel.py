"""The machine with all six switches off: its currents run through the diodes to zero and stay there.

A phase whose current is not zero is held by a diode, at the lower rail for a current out of the leg and at
the upper one for a current into it; a phase that has reached zero floats. Currents would start again only by
rectification of a line EMF above the dc link, which is not modelled: keep sqrt(3) psi_r omega_e below u_dc.
"""

from __future__ import annotations

from typing import Any

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.inverter import SQRT3, PowerStage, clarke, phase_currents
from benchtool.emulator.machine.plant import Machine, State, advance, holding, step
from benchtool.emulator.machine.transducer import sample

_ZERO = 1e-9  # A, below which a phase has no current
_PARTS = 50  # steps of a PWM period: the diodes are looked at once a step
_COASTING_TURN = 0.05


@njit
def freewheel(
    x: State,
    u_dc: float,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: Any,
) -> State:
    """Integrate one PWM period with the power stage off."""
    time, h = 0.0, stage.T_s / _PARTS
    while _flows(x) and time < stage.T_s:
        h = min(h, stage.T_s - time)
        time_before, before = time, x
        u_alpha, u_beta = _diode_voltage(x, u_dc, stage.drop)
        x = step(x, u_alpha, u_beta, h, machine, T_load)
        part, phase = _first_crossing(before, x)
        taken = part * h
        if part < 1.0:
            x = step(before, u_alpha, u_beta, taken, machine, T_load)
        x = _without_extinct(before, x, phase)
        sample(time_before, taken, before, x, u_alpha, u_beta, machine, T_load, transducer, torque)
        time = time_before + taken if taken < stage.T_s - time_before else stage.T_s
    rest = stage.T_s - time
    if rest > 0.0:
        before = x
        open_machine = holding(machine, False, True)
        x = advance(x, 0.0, 0.0, rest, _COASTING_TURN, open_machine, T_load)
        sample(time, rest, before, x, 0.0, 0.0, open_machine, T_load, transducer, torque)
    return x


@njit
def _flows(x: State) -> bool:
    return abs(x.i_d) > _ZERO or abs(x.i_q) > _ZERO


@njit
def _diode_voltage(x: State, u_dc: float, drop: float) -> tuple[float, float]:
    """Voltage (alpha, beta) of the conducting diodes; a floating leg takes the mean of the others."""
    i_a, i_b, i_c = phase_currents(x)
    v_a, v_b, v_c = _rail(i_a, u_dc, drop), _rail(i_b, u_dc, drop), _rail(i_c, u_dc, drop)
    if abs(i_a) <= _ZERO:
        v_a = 0.5 * (v_b + v_c)
    if abs(i_b) <= _ZERO:
        v_b = 0.5 * (v_c + v_a)
    if abs(i_c) <= _ZERO:
        v_c = 0.5 * (v_a + v_b)
    return clarke(v_a, v_b, v_c)


@njit
def _rail(current: float, u_dc: float, drop: float) -> float:
    return -drop if current > 0.0 else u_dc + drop


@njit
def _first_crossing(before: State, after: State) -> tuple[float, int]:
    """Part of the step after which the first current is zero, by the secant, and its phase; else 1 and -1."""
    a0, b0, c0 = phase_currents(before)
    a1, b1, c1 = phase_currents(after)
    part_a, part_b, part_c = _crossing(a0, a1), _crossing(b0, b1), _crossing(c0, c1)
    part = min(part_a, part_b, part_c)
    if part >= 1.0:
        return 1.0, -1
    if part == part_a:
        return part, 0
    return part, 1 if part == part_b else 2


@njit
def _crossing(before: float, after: float) -> float:
    if abs(before) <= _ZERO or before * after >= 0.0:
        return 1.0
    return before / (before - after)


@njit
def _without_extinct(before: State, x: State, phase: int) -> State:
    """The state with no current in the phases that floated before and the one that just reached zero."""
    a0, b0, c0 = phase_currents(before)
    extinct_a = abs(a0) <= _ZERO or phase == 0
    extinct_b = abs(b0) <= _ZERO or phase == 1
    extinct_c = abs(c0) <= _ZERO or phase == 2
    extinct = int(extinct_a) + int(extinct_b) + int(extinct_c)
    if extinct == 0:
        return x
    if extinct > 1:
        return State(0.0, 0.0, x.omega_e, x.theta_e, x.theta_rest, x.cos_theta, x.sin_theta)
    n_alpha, n_beta = 1.0, 0.0
    if extinct_b:
        n_alpha, n_beta = -0.5, 0.5 * SQRT3
    if extinct_c:
        n_alpha, n_beta = -0.5, -0.5 * SQRT3
    n_d = n_alpha * x.cos_theta + n_beta * x.sin_theta
    n_q = n_beta * x.cos_theta - n_alpha * x.sin_theta
    along = x.i_d * n_d + x.i_q * n_q
    return State(
        x.i_d - along * n_d,
        x.i_q - along * n_q,
        x.omega_e,
        x.theta_e,
        x.theta_rest,
        x.cos_theta,
        x.sin_theta,
    )
