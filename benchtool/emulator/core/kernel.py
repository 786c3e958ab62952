"""The kernel: machine, sensors, control, capture, stream and transducer, tick after tick.

Drive tick n is at n T_s. A tick integrates the machine over one PWM period with the duties that were computed
a tick before that period began, then samples, controls and records.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.control.cycle import control_tick
from benchtool.emulator.core.capture_memory import take
from benchtool.emulator.core.stream_ring import stream_row
from benchtool.emulator.jit import entry, is_cached, njit
from benchtool.emulator.machine.freewheel import freewheel
from benchtool.emulator.machine.inverter import (
    NEVER,
    PowerStage,
    falling_edge,
    leg_voltages,
    phase_currents,
    rising_edge,
)
from benchtool.emulator.machine.plant import (
    Machine,
    State,
    fastest_rate,
    holding,
    place,
    step,
    substep,
    turning_rate,
)
from benchtool.emulator.machine.sensors import Sensing, measure
from benchtool.emulator.machine.transducer import sample
from benchtool.ticks import TICKS

# rad of the fastest process in one step: fourth order leaves less than 1e-8 of it
_TURN = 0.05
_TICKS_BETWEEN_DIRECTIONS = 64
_LAST_TICK = TICKS - 1


@entry
def run_ticks(
    ticks: int,
    memory: Any,
    memory_words: NDArray[np.uint32],
    memory_floats: NDArray[np.float32],
    commands: Any,
    controls: Any,
    stimuli: Any,
    measurements: Any,
    shafts: Any,
    loads: Any,
    machine: Machine,
    stage: PowerStage,
    sensing: Sensing,
    noise: NDArray[np.float32],
    captures: Any,
    channels: NDArray[np.uint32],
    rows: NDArray[np.uint32],
    streams: Any,
    streamed: NDArray[np.uint32],
    ring: NDArray[np.uint32],
    transducers: Any,
    torque: NDArray[np.float64],
) -> int:
    """Run up to `ticks` ticks; fewer, after the tick in which a new trip was raised. Returns how many."""
    drive, command, control = memory[0], commands[0], controls[0]
    measurement, shaft, load = measurements[0], shafts[0], loads[0]
    capture, stream, transducer, stimulus = captures[0], streams[0], transducers[0], stimuli[0]
    driven = holding(machine, load.held != 0, False)
    at_rest, moving = fastest_rate(driven), turning_rate(driven)
    for done in range(ticks):
        omega_m = load.omega_m_rad_s if load.held != 0 else shaft.omega_m
        x = _true_state(shaft, machine.p * omega_m, drive.tick)
        transducer.next_sample = 0
        if command.pwm_enabled != 0 and control.gated != 0:
            rate = at_rest + moving * abs(x.omega_e)
            x = _switch(x, rate, drive, control, shaft, stage, driven, load.torque_Nm, transducer, torque)
        else:
            shaft.high_a, shaft.high_b, shaft.high_c = 0, 0, 0
            shaft.u_dc = stage.u_dc
            x = freewheel(x, stage.u_dc, stage, driven, load.torque_Nm, transducer, torque)
        shaft.i_d, shaft.i_q, shaft.omega_m = x.i_d, x.i_q, x.omega_e / machine.p
        shaft.theta_e, shaft.cos_theta, shaft.sin_theta = x.theta_e, x.cos_theta, x.sin_theta
        if transducer.recording == 1 and transducer.filled >= torque.size:
            transducer.recording = 0
        drive.tick = (int(drive.tick) + 1) & _LAST_TICK
        measure(x, shaft.u_dc, machine.p, sensing, noise[done], measurement)
        tripped = control_tick(drive, command, control, stimulus, measurement)
        began = stimulus.began != 0
        take(capture, drive, memory_words, memory_floats, channels, rows, tripped, began)
        stream_row(stream, memory_words, streamed, ring)
        if tripped:
            return done + 1
    return ticks


def kernel_is_cached() -> bool:
    """Whether the first run will load the kernel within a second; else it compiles for some seconds."""
    return is_cached(run_ticks)


@njit
def _true_state(shaft: Any, omega_e: float, tick: int) -> State:
    """The machine's state; now and then its direction is derived from its angle, to hold both together."""
    if tick % _TICKS_BETWEEN_DIRECTIONS == 0:
        return place(shaft.i_d, shaft.i_q, omega_e, shaft.theta_e)
    return State(shaft.i_d, shaft.i_q, omega_e, shaft.theta_e, 0.0, shaft.cos_theta, shaft.sin_theta)


@njit
def _switch(
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
) -> State:
    """Integrate one PWM period from edge to edge.

    The dc link holds its voltage over the period; the mean current of the period sets that of the next.
    """
    duty_a, duty_b, duty_c = control.duty_a, control.duty_b, control.duty_c
    i_a, i_b, i_c = phase_currents(x)
    rise_a, fall_a = rising_edge(duty_a, i_a, stage), falling_edge(duty_a, 0.0, stage)
    rise_b, fall_b = rising_edge(duty_b, i_b, stage), falling_edge(duty_b, 0.0, stage)
    rise_c, fall_c = rising_edge(duty_c, i_c, stage), falling_edge(duty_c, 0.0, stage)
    drive.switching_count += _turn_on(duty_a, shaft.high_a) + _turn_on(duty_b, shaft.high_b)
    drive.switching_count += _turn_on(duty_c, shaft.high_c)
    u_dc = shaft.u_dc
    charge = 0.0
    time = 0.0
    while time < stage.T_s:
        if stage.dead_time > 0.0:  # now that a leg rises its current tells when it will fall
            i_a, i_b, i_c = phase_currents(x)
            fall_a = falling_edge(duty_a, i_a, stage) if rise_a == time else fall_a
            fall_b = falling_edge(duty_b, i_b, stage) if rise_b == time else fall_b
            fall_c = falling_edge(duty_c, i_c, stage) if rise_c == time else fall_c
        until = min(
            _next_edge(time, rise_a, fall_a),
            _next_edge(time, rise_b, fall_b),
            _next_edge(time, rise_c, fall_c),
            stage.T_s,
        )
        high_a = rise_a <= time < fall_a
        high_b = rise_b <= time < fall_b
        high_c = rise_c <= time < fall_c
        u_alpha, u_beta = leg_voltages(high_a, high_b, high_c, x, u_dc, stage)
        while time < until:
            h = substep(until - time, rate, _TURN)
            before = x
            x = step(x, u_alpha, u_beta, h, machine, T_load)
            sample(time, h, before, x, u_alpha, u_beta, machine, T_load, transducer, torque)
            if stage.R_dc > 0.0:
                start = _link_current(high_a, high_b, high_c, before)
                charge += 0.5 * h * (start + _link_current(high_a, high_b, high_c, x))
            time = time + h if h < until - time else until
    shaft.high_a, shaft.high_b, shaft.high_c = duty_a >= 1.0, duty_b >= 1.0, duty_c >= 1.0
    shaft.u_dc = stage.u_dc - stage.R_dc * charge / stage.T_s
    return x


@njit
def _next_edge(time: float, rise: float, fall: float) -> float:
    """Edge of a leg that comes next after `time`, or never.

    Chosen without a branch, as are the legs' states: their order is what a processor cannot foresee.
    """
    second = fall if fall > time else NEVER
    return rise if rise > time else second


@njit
def _turn_on(duty: float, was_high: int) -> int:
    """1 if the leg's upper switch turns on in a period of this duty."""
    return 1 if duty > 0.0 and (duty < 1.0 or was_high == 0) else 0


@njit
def _link_current(high_a: bool, high_b: bool, high_c: bool, x: State) -> float:
    """Current that the legs which are high draw from the dc link."""
    i_a, i_b, i_c = phase_currents(x)
    return (i_a if high_a else 0.0) + (i_b if high_b else 0.0) + (i_c if high_c else 0.0)
