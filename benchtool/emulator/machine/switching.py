"""One control period with the power stage on, from edge to edge, or by its mean where nothing asks for edges.

The dc link holds its voltage over the period; the charge that is drawn over it sets that of the next.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.accounts import Rails, account, finer
from benchtool.emulator.machine.asymmetry import Asymmetry
from benchtool.emulator.machine.averaging import SLOW_ENOUGH, averaged, can_rest
from benchtool.emulator.machine.carrier import NEVER, DoubleUpdate, ends_high, pulse, turns_on
from benchtool.emulator.machine.coefficients import Machine, largest_inverse_inductance
from benchtool.emulator.machine.diodes import HIGH, LOW, OFF, integrate_conduction
from benchtool.emulator.machine.drive_train import DriveTrain
from benchtool.emulator.machine.energies import Accounts
from benchtool.emulator.machine.inverter import (
    DeadTime,
    Devices,
    PowerStage,
    leg_voltages,
    phase_currents,
    quantised,
)
from benchtool.emulator.machine.iron import Iron
from benchtool.emulator.machine.plant import move, substep
from benchtool.emulator.machine.sampling import Sampling, observe
from benchtool.emulator.machine.saturation import Saturation
from benchtool.emulator.machine.state import State
from benchtool.emulator.machine.transducer import sample

# rad of the fastest process in one step: fourth order leaves less than 1e-8 of it
_TURN = 0.05


@njit
def switch(
    x: State,
    rate: float,
    drive: Any,
    control: Any,
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    """Integrate one control period. Returns the charge drawn from the dc link as well, in As."""
    duty_a = quantised(stage.timer, control.duty_a)
    duty_b = quantised(stage.timer, control.duty_b)
    duty_c = quantised(stage.timer, control.duty_c)
    update, tick = stage.double_update, drive.tick
    drive.switching_count += (
        turns_on(update, duty_a, tick, shaft.high_a)
        + turns_on(update, duty_b, tick, shaft.high_b)
        + turns_on(update, duty_c, tick, shaft.high_c)
    )
    rise_a, fall_a = pulse(update, duty_a, stage.T_s, tick)
    rise_b, fall_b = pulse(update, duty_b, stage.T_s, tick)
    rise_c, fall_c = pulse(update, duty_c, stage.T_s, tick)
    x, charge = _period(
        stage.dead_time,
        stage.devices,
        stage.sampling,
        update,
        stage.accounts,
        machine.saturation,
        machine.asymmetry,
        machine.iron,
        machine.train,
        x,
        rate,
        (duty_a, duty_b, duty_c),
        (rise_a, rise_b, rise_c),
        (fall_a, fall_b, fall_c),
        shaft,
        stage,
        machine,
        T_load,
        transducer,
        torque,
    )
    shaft.high_a = ends_high(update, duty_a, tick)
    shaft.high_b = ends_high(update, duty_b, tick)
    shaft.high_c = ends_high(update, duty_c, tick)
    return x, charge


@njit
def _period(
    dead_time: DeadTime | None,
    devices: Devices | None,
    sampling: Sampling | None,
    update: DoubleUpdate | None,
    accounts: Accounts | None,
    saturation: Saturation | None,
    asymmetry: Asymmetry | None,
    iron: Iron | None,
    train: DriveTrain | None,
    x: State,
    rate: float,
    duties: tuple[float, float, float],
    rise: tuple[float, float, float],
    fall: tuple[float, float, float],
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    if (
        dead_time is None
        and devices is None
        and sampling is None
        and update is None
        and accounts is None
        and saturation is None
        and asymmetry is None
        and iron is None
        and train is None
    ):
        watched = transducer.recording != 0
        slow = rate * stage.T_s <= SLOW_ENOUGH
        if slow and not watched and not can_rest(machine.friction, x, shaft.u_dc, stage.T_s, machine, T_load):
            return averaged(x, duties, shaft.u_dc, stage.T_s, machine, T_load, stage.metered)
    if dead_time is None:
        return _without_dead_time(x, rate, rise, fall, shaft, stage, machine, T_load, transducer, torque)
    return _with_dead_time(dead_time, x, rate, rise, fall, shaft, stage, machine, T_load, transducer, torque)


@njit
def _without_dead_time(
    x: State,
    rate: float,
    rise: tuple[float, float, float],
    fall: tuple[float, float, float],
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    rise_a, rise_b, rise_c = rise
    fall_a, fall_b, fall_c = fall
    charge, time = 0.0, 0.0
    while time < stage.T_s:
        until = min(
            _next_edge(time, rise_a, fall_a),
            _next_edge(time, rise_b, fall_b),
            _next_edge(time, rise_c, fall_c),
            stage.T_s,
        )
        high_a = rise_a <= time < fall_a
        high_b = rise_b <= time < fall_b
        high_c = rise_c <= time < fall_c
        x, drawn = _between_edges(
            x,
            rate,
            time,
            until,
            high_a,
            high_b,
            high_c,
            shaft.u_dc,
            stage,
            machine,
            T_load,
            transducer,
            torque,
        )
        charge += drawn
        time = until
    return x, charge


@njit
def _between_edges(
    x: State,
    rate: float,
    time: float,
    until: float,
    high_a: bool,
    high_b: bool,
    high_c: bool,
    u_dc: float,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    """Integrate while no leg switches."""
    u_alpha, u_beta = leg_voltages(high_a, high_b, high_c, x, u_dc, stage)
    charge = 0.0
    while time < until:
        whole = substep(until - time, rate, finer(stage.accounts, _TURN, 0.4))
        before = x
        x, h = move(x, u_alpha, u_beta, whole, machine, T_load)
        if _changes_sign(stage.devices, before, x):
            h = whole  # a shaft that comes to rest ends a step that may have next to no length
            x, drawn = _across_zero(
                stage.devices,
                before,
                HIGH if high_a else LOW,
                HIGH if high_b else LOW,
                HIGH if high_c else LOW,
                time,
                h,
                rate,
                u_dc,
                stage,
                machine,
                T_load,
                transducer,
                torque,
            )
            charge += drawn
            u_alpha, u_beta = leg_voltages(high_a, high_b, high_c, x, u_dc, stage)
        else:
            sample(time, h, before, x, u_alpha, u_beta, machine, T_load, transducer, torque)
            rails = Rails(
                u_dc if high_a else 0.0, u_dc if high_b else 0.0, u_dc if high_c else 0.0, False, False, False
            )
            account(stage.accounts, h, before, x, u_alpha, u_beta, u_dc, rails, machine, T_load, transducer)
            observe(stage.sampling, time, h, before, x, u_alpha, u_beta, machine, T_load)
            if stage.metered:
                start = _link_current(high_a, high_b, high_c, before)
                charge += 0.5 * h * (start + _link_current(high_a, high_b, high_c, x))
        time = time + h if h < until - time else until
    return x, charge


@njit
def _changes_sign(devices: Devices | None, before: State, after: State) -> bool:
    """Return whether a current gets to zero or through it, where forward voltages make that a matter."""
    if devices is None:
        return False
    a0, b0, c0 = phase_currents(before)
    a1, b1, c1 = phase_currents(after)
    return a0 * a1 <= 0.0 or b0 * b1 <= 0.0 or c0 * c1 <= 0.0


@njit
def _across_zero(
    devices: Devices | None,
    x: State,
    mode_a: int,
    mode_b: int,
    mode_c: int,
    time: float,
    h: float,
    rate: float,
    u_dc: float,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    if devices is None:
        return x, 0.0
    return integrate_conduction(
        x, mode_a, mode_b, mode_c, time, time + h, rate, u_dc, stage, machine, T_load, transducer, torque
    )


class Leg(NamedTuple):
    """A leg with dead time: what its switches are told, and until when neither is on."""

    rise: float
    fall: float
    high: bool
    blank: float


@njit
def _with_dead_time(
    dead_time: DeadTime,
    x: State,
    rate: float,
    rise: tuple[float, float, float],
    fall: tuple[float, float, float],
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
    transducer: Any,
    torque: NDArray[np.float64],
) -> tuple[State, float]:
    """Return from one change of a leg's mode to the next, those that the period before left over among them.

    While neither switch is on the current holds the leg at a rail; only where it is so small that it may
    reach zero within the dead time the diodes are followed.
    """
    leg_a = Leg(rise[0], fall[0], shaft.high_a != 0, shaft.blank_a)
    leg_b = Leg(rise[1], fall[1], shaft.high_b != 0, shaft.blank_b)
    leg_c = Leg(rise[2], fall[2], shaft.high_c != 0, shaft.blank_c)
    inv_L = largest_inverse_inductance(machine.saturation, machine, x)
    small = 2.0 * dead_time.duration * inv_L * (shaft.u_dc + machine.psi_r * abs(x.omega_e))
    charge, time = 0.0, 0.0
    while time < stage.T_s:
        i_a, i_b, i_c = phase_currents(x)
        leg_a, leg_b, leg_c = (
            _told(leg_a, time, dead_time),
            _told(leg_b, time, dead_time),
            _told(leg_c, time, dead_time),
        )
        mode_a, mode_b, mode_c = (
            _mode(leg_a, time, i_a, small),
            _mode(leg_b, time, i_b, small),
            _mode(leg_c, time, i_c, small),
        )
        until = min(
            _next_change(leg_a, time, mode_a),
            _next_change(leg_b, time, mode_b),
            _next_change(leg_c, time, mode_c),
            stage.T_s,
        )
        if mode_a == OFF or mode_b == OFF or mode_c == OFF:
            x, drawn = integrate_conduction(
                x,
                mode_a,
                mode_b,
                mode_c,
                time,
                until,
                rate,
                shaft.u_dc,
                stage,
                machine,
                T_load,
                transducer,
                torque,
            )
        else:
            x, drawn = _between_edges(
                x,
                rate,
                time,
                until,
                mode_a == HIGH,
                mode_b == HIGH,
                mode_c == HIGH,
                shaft.u_dc,
                stage,
                machine,
                T_load,
                transducer,
                torque,
            )
        charge += drawn
        time = until
    shaft.blank_a = max(leg_a.blank - stage.T_s, 0.0)
    shaft.blank_b = max(leg_b.blank - stage.T_s, 0.0)
    shaft.blank_c = max(leg_c.blank - stage.T_s, 0.0)
    return x, charge


@njit
def _told(leg: Leg, time: float, dead_time: DeadTime) -> Leg:
    """Return the leg as its switches are told at `time`: a change of it begins a dead time."""
    high = leg.rise <= time < leg.fall
    if high == leg.high:
        return leg
    return Leg(leg.rise, leg.fall, high, time + dead_time.duration)


@njit
def _mode(leg: Leg, time: float, current: float, small: float) -> int:
    if time >= leg.blank:
        return HIGH if leg.high else LOW
    if abs(current) <= small:
        return OFF
    return LOW if current > 0.0 else HIGH


@njit
def _next_change(leg: Leg, time: float, mode: int) -> float:
    """Return when the leg's mode may change next: at an edge, or where a dead time ends that has an
    effect."""
    change = _next_edge(time, leg.rise, leg.fall)
    if time < leg.blank and mode != (HIGH if leg.high else LOW):
        change = min(change, leg.blank)
    return change


@njit
def _next_edge(time: float, rise: float, fall: float) -> float:
    """Return the edge of a leg that comes next after `time`, or never.

    Chosen without a branch, as are the legs' states, because their order is unpredictable to a processor.
    """
    second = fall if fall > time else NEVER
    return rise if rise > time else second


@njit
def _link_current(high_a: bool, high_b: bool, high_c: bool, x: State) -> float:
    """Return the current that the legs which are high draw from the dc link."""
    i_a, i_b, i_c = phase_currents(x)
    return (i_a if high_a else 0.0) + (i_b if high_b else 0.0) + (i_c if high_c else 0.0)
