"""Devices that conduct or not: the diodes of a leg with both switches off, and forward voltages.

A current out of a leg takes the lowest potential at which a device of the leg carries it, a current into it
the highest; between the two the leg has no current and floats, at the potential at which that stays so. With
both switches off these are a forward voltage beyond the rails, with one switch on a forward voltage to either
side of its rail. So currents run out to zero, rest there for what is left of a dead time, and flow again
where a line EMF above the dc link is rectified.

Potentials are counted from the lower rail.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.in_place import in_place, value_of
from benchtool.emulator.jit import called, njit, separately
from benchtool.emulator.machine.accounts import Rails, account, finer
from benchtool.emulator.machine.coefficients import (
    Machine,
    fastest_rate,
    holding,
    rate_at,
    turning_rate,
)
from benchtool.emulator.machine.energies import Accounts
from benchtool.emulator.machine.harmonics import linkage
from benchtool.emulator.machine.inverter import (
    SQRT3,
    PowerStage,
    clarke,
    forward_voltage,
    phase_currents,
)
from benchtool.emulator.machine.plant import (
    advance,
    current_rates,
    move,
    step,
    substep,
)
from benchtool.emulator.machine.sampling import observe
from benchtool.emulator.machine.state import State, with_currents
from benchtool.emulator.machine.terminals import inverse_inductance, open_circuit_voltage
from benchtool.emulator.machine.transducer import coasts, sample

LOW, HIGH, OFF = 0, 1, 2  # modes of a leg: lower or upper switch on, or neither
NONE = -1  # of the phases

_ZERO = 1e-9  # A, below which a phase has no current
_PARTS = 50  # short steps of a control period
_TURN = 0.05  # rad of the fastest process in one step


class Window(NamedTuple):
    """Potentials between which a leg carries no current."""

    low: float
    high: float


class Potentials(NamedTuple):
    """Of the three legs, and which of them float."""

    a: float
    b: float
    c: float
    floats_a: bool
    floats_b: bool
    floats_c: bool


@separately
def freewheel(
    x: State,
    u_dc: float,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    """Integrate one control period with the power stage off. Returns as `integrate_conduction`."""
    rate = rate_at(x, fastest_rate(machine, x), turning_rate(machine), machine)
    return integrate_conduction(
        x, OFF, OFF, OFF, 0.0, stage.T_s, rate, u_dc, stage, machine, T_load, transducer, torque
    )


@called
def integrate_conduction(
    x: State,
    mode_a: int,
    mode_b: int,
    mode_c: int,
    start: float,
    end: float,
    rate: float,
    u_dc: float,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    """Integrate from `start` to `end`, in s of the control period, with legs in these modes.

    `rate` is the machine's fastest, in 1/s. While a leg floats it is looked at in short steps; a current that
    ends is found within a long one. Returns the charge drawn from the dc link as well, in As.
    """
    time = start
    drop = forward_voltage(stage.devices)
    leg_a, leg_b, leg_c = (
        _window(mode_a, u_dc, drop),
        _window(mode_b, u_dc, drop),
        _window(mode_c, u_dc, drop),
    )
    all_off = mode_a == OFF and mode_b == OFF and mode_c == OFF
    rails = Rails(
        u_dc if mode_a == HIGH else 0.0,
        u_dc if mode_b == HIGH else 0.0,
        u_dc if mode_c == HIGH else 0.0,
        mode_a == OFF,
        mode_b == OFF,
        mode_c == OFF,
    )
    short = finer(stage.accounts, stage.T_s / _PARTS, 0.15)
    charge = 0.0
    while time < end:
        v = _potentials(x, leg_a, leg_b, leg_c, machine)
        silent = v.floats_a and v.floats_b and v.floats_c
        before = x
        if silent:
            open_machine = in_place(holding(value_of(machine), False, True))
            if all_off and _below(x, leg_a.high - leg_a.low, machine) and coasts(machine.train, transducer):
                x = _coast(stage.accounts, x, end - time, open_machine, T_load, transducer)
                sample(time, end - time, before, x, 0.0, 0.0, open_machine, T_load, transducer, torque)
                observe(stage.sampling, time, end - time, before, x, 0.0, 0.0, open_machine, T_load)
                return x, charge
            h = min(short, substep(end - time, rate, _TURN))
            x, h = move(x, 0.0, 0.0, h, open_machine, T_load)
            sample(time, h, before, x, 0.0, 0.0, open_machine, T_load, transducer, torque)
            account(stage.accounts, h, before, x, 0.0, 0.0, u_dc, rails, open_machine, T_load, transducer)
            observe(stage.sampling, time, h, before, x, 0.0, 0.0, open_machine, T_load)
        else:
            u_alpha, u_beta = clarke(v.a, v.b, v.c)
            h = substep(end - time, rate, finer(stage.accounts, _TURN, 0.4))
            if v.floats_a or v.floats_b or v.floats_c:
                h = min(short, h)
                u_alpha, u_beta = _holding_zero(x, v, u_alpha, u_beta, h, machine, T_load)
            x, h = move(x, u_alpha, u_beta, h, machine, T_load)
            phase = _first_to_end(before, x, leg_a, leg_b, leg_c)
            if phase != NONE:
                after, whole, part = x, h, 1.0
                for _ in range(3):
                    part -= _current(x, phase) / (_current(after, phase) - _current(before, phase))
                    part = min(max(part, 0.0), 1.0)
                    h = part * whole
                    x = step(before, u_alpha, u_beta, h, machine, T_load)
            x = _without_current(
                x, v.floats_a or phase == 0, v.floats_b or phase == 1, v.floats_c or phase == 2, machine
            )
            sample(time, h, before, x, u_alpha, u_beta, machine, T_load, transducer, torque)
            account(stage.accounts, h, before, x, u_alpha, u_beta, u_dc, rails, machine, T_load, transducer)
            observe(stage.sampling, time, h, before, x, u_alpha, u_beta, machine, T_load)
            drawn = _drawn(before, mode_a, mode_b, mode_c) + _drawn(x, mode_a, mode_b, mode_c)
            charge += 0.5 * h * drawn
        time = time + h if h < end - time else end
    return x, charge


@njit
def _coast(
    accounts: Accounts | None, x: State, duration: float, machine: Machine, T_load: float, record: Any
) -> State:
    """Integrate without any current; accounts are kept step by step."""
    if accounts is None:
        return advance(x, 0.0, 0.0, duration, _TURN, machine, T_load)
    return _coast_by_steps(accounts, x, duration, machine, T_load, record)


@called
def _coast_by_steps(
    accounts: Accounts, x: State, duration: float, machine: Machine, T_load: float, record: Any
) -> State:
    rate = rate_at(x, fastest_rate(machine, x), turning_rate(machine), machine)
    rails = Rails(0.0, 0.0, 0.0, True, True, True)
    remaining = duration
    while remaining > 0.0:
        before = x
        x, h = move(x, 0.0, 0.0, substep(remaining, rate, finer(accounts, _TURN, 0.4)), machine, T_load)
        account(accounts, h, before, x, 0.0, 0.0, 0.0, rails, machine, T_load, record)
        remaining = remaining - h if h < remaining else 0.0
    return x


@njit
def _window(mode: int, u_dc: float, drop: float) -> Window:
    if mode == OFF:
        return Window(-drop, u_dc + drop)
    v = u_dc if mode == HIGH else 0.0
    return Window(v - drop, v + drop)


@njit
def _potentials(x: State, leg_a: Window, leg_b: Window, leg_c: Window, machine: Machine) -> Potentials:
    i_a, i_b, i_c = phase_currents(x)
    no_a, no_b, no_c = abs(i_a) <= _ZERO, abs(i_b) <= _ZERO, abs(i_c) <= _ZERO
    v_a, v_b, v_c = _carrying(leg_a, i_a), _carrying(leg_b, i_b), _carrying(leg_c, i_c)
    if int(no_a) + int(no_b) + int(no_c) >= 2:
        # No current anywhere. It stays so where one potential of the star point has all legs within their
        # windows; else the two that are furthest apart begin to conduct.
        e_a, e_b, e_c = _phase_emf(x, machine)
        lowest = max(leg_a.low - e_a, leg_b.low - e_b, leg_c.low - e_c)
        highest = min(leg_a.high - e_a, leg_b.high - e_b, leg_c.high - e_c)
        if lowest <= highest:
            return Potentials(v_a, v_b, v_c, True, True, True)
        no_a = leg_a.low - e_a != lowest and leg_a.high - e_a != highest
        no_b = leg_b.low - e_b != lowest and leg_b.high - e_b != highest
        no_c = leg_c.low - e_c != lowest and leg_c.high - e_c != highest
        v_a = leg_a.low if leg_a.low - e_a == lowest else leg_a.high
        v_b = leg_b.low if leg_b.low - e_b == lowest else leg_b.high
        v_c = leg_c.low if leg_c.low - e_c == lowest else leg_c.high
    floats_a, floats_b, floats_c = False, False, False
    if no_a:
        v_a, floats_a = _floating(x, 1.0, 0.0, leg_a, v_b, v_c, machine)
    elif no_b:
        v_b, floats_b = _floating(x, -0.5, 0.5 * SQRT3, leg_b, v_c, v_a, machine)
    elif no_c:
        v_c, floats_c = _floating(x, -0.5, -0.5 * SQRT3, leg_c, v_a, v_b, machine)
    return Potentials(v_a, v_b, v_c, floats_a, floats_b, floats_c)


@njit
def _carrying(leg: Window, current: float) -> float:
    """Return the potential of a leg that carries this current."""
    return leg.low if current > 0.0 else leg.high


@njit
def _phase_emf(x: State, machine: Machine) -> tuple[float, float, float]:
    """Return the voltages of the phases at which no current begins to flow."""
    e_d, e_q = open_circuit_voltage(x, machine)
    e_alpha = e_d * x.cos_theta - e_q * x.sin_theta
    e_beta = e_d * x.sin_theta + e_q * x.cos_theta
    return e_alpha, -0.5 * e_alpha + 0.5 * SQRT3 * e_beta, -0.5 * e_alpha - 0.5 * SQRT3 * e_beta


@njit
def _floating(
    x: State, n_alpha: float, n_beta: float, leg: Window, v_1: float, v_2: float, machine: Machine
) -> tuple[float, bool]:
    """Return the potential of the one leg without current, and whether it floats: at an end of its window it
    conducts.

    (n_alpha, n_beta) is its phase's axis, and the other two legs are at `v_1` and `v_2`.
    """
    v = 0.5 * (leg.low + leg.high)  # a guess: its current changes by a rate in proportion to what it is off
    along, across = (2.0 * v - v_1 - v_2) * (1.0 / 3.0), (v_1 - v_2) * (1.0 / SQRT3)
    u_alpha, u_beta = along * n_alpha - across * n_beta, along * n_beta + across * n_alpha
    n_d = n_alpha * x.cos_theta + n_beta * x.sin_theta
    n_q = n_beta * x.cos_theta - n_alpha * x.sin_theta
    di_d, di_q = current_rates(x, u_alpha, u_beta, machine)
    rate = (di_d - x.omega_e * x.i_q) * n_d + (di_q + x.omega_e * x.i_d) * n_q  # of its current
    G = inverse_inductance(x, machine)
    per_volt = (n_d * n_d * G.dd + 2.0 * n_d * n_q * G.dq + n_q * n_q * G.qq) * (2.0 / 3.0)
    v -= rate / per_volt
    if v >= leg.high:
        return leg.high, False
    if v <= leg.low:
        return leg.low, False
    return v, True


@called
def _holding_zero(
    x: State, v: Potentials, u_alpha: float, u_beta: float, h: float, machine: Machine, T_load: float
) -> tuple[float, float]:
    """Return the voltage (alpha, beta) with the leg that floats at the potential that has it without current
    after a step of `h` seconds, from the one at which it has none at first."""
    phase, n_alpha, n_beta = 2, -0.5, -0.5 * SQRT3
    if v.floats_a:
        phase, n_alpha, n_beta = 0, 1.0, 0.0
    elif v.floats_b:
        phase, n_alpha, n_beta = 1, -0.5, 0.5 * SQRT3
    off = _current(step(x, u_alpha, u_beta, h, machine, T_load), phase)
    n_d = n_alpha * x.cos_theta + n_beta * x.sin_theta
    n_q = n_beta * x.cos_theta - n_alpha * x.sin_theta
    G = inverse_inductance(x, machine)
    u = off / (h * (n_d * n_d * G.dd + 2.0 * n_d * n_q * G.dq + n_q * n_q * G.qq))
    return u_alpha - u * n_alpha, u_beta - u * n_beta


@njit
def _below(x: State, u: float, machine: Machine) -> bool:
    """Return whether no line EMF can come above this voltage in a control period of coasting."""
    return SQRT3 * (machine.psi_r + 2.0 * linkage(machine.harmonics)) * abs(x.omega_e) < 0.99 * u


@njit
def _first_to_end(before: State, after: State, leg_a: Window, leg_b: Window, leg_c: Window) -> int:
    """Return the phase whose current is zero first within a step, by the secant, or `NONE`.

    A leg whose window is of one point carries currents of both signs alike.
    """
    a0, b0, c0 = phase_currents(before)
    a1, b1, c1 = phase_currents(after)
    part_a = _crossing(a0, a1) if leg_a.low < leg_a.high else 1.0
    part_b = _crossing(b0, b1) if leg_b.low < leg_b.high else 1.0
    part_c = _crossing(c0, c1) if leg_c.low < leg_c.high else 1.0
    part = min(part_a, part_b, part_c)
    if part >= 1.0:
        return NONE
    if part == part_a:
        return 0
    return 1 if part == part_b else 2


@njit
def _crossing(before: float, after: float) -> float:
    if abs(before) <= _ZERO or before * after >= 0.0:
        return 1.0
    return before / (before - after)


@njit
def _current(x: State, phase: int) -> float:
    i_a, i_b, i_c = phase_currents(x)
    if phase == 0:
        return i_a
    return i_b if phase == 1 else i_c


@njit
def _without_current(x: State, none_a: bool, none_b: bool, none_c: bool, machine: Machine) -> State:
    """Return the state with no current in these phases."""
    phases = int(none_a) + int(none_b) + int(none_c)
    if phases == 0:
        return x
    if phases > 1:
        return with_currents(machine.saturation, x, 0.0, 0.0)
    n_alpha, n_beta = 1.0, 0.0
    if none_b:
        n_alpha, n_beta = -0.5, 0.5 * SQRT3
    if none_c:
        n_alpha, n_beta = -0.5, -0.5 * SQRT3
    n_d = n_alpha * x.cos_theta + n_beta * x.sin_theta
    n_q = n_beta * x.cos_theta - n_alpha * x.sin_theta
    along = x.i_d * n_d + x.i_q * n_q
    return with_currents(machine.saturation, x, x.i_d - along * n_d, x.i_q - along * n_q)


@njit
def _drawn(x: State, mode_a: int, mode_b: int, mode_c: int) -> float:
    """Return the current that the legs draw from the dc link; a leg that is off draws none, it feeds."""
    i_a, i_b, i_c = phase_currents(x)
    return _of_leg(mode_a, i_a) + _of_leg(mode_b, i_b) + _of_leg(mode_c, i_c)


@njit
def _of_leg(mode: int, current: float) -> float:
    if mode == OFF:
        return min(current, 0.0)
    return current if mode == HIGH else 0.0
