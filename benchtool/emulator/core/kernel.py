"""The kernel: machine, sensors, control, capture, stream and transducer, tick after tick.

Drive tick n is at n T_s. A tick integrates the machine over one PWM period with the duties that were computed
a tick before that period began, then samples, controls and records.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.control.cycle import control_tick
from benchtool.emulator.core.capture_memory import capture_row
from benchtool.emulator.core.stream_ring import stream_row
from benchtool.emulator.jit import is_cached, njit, parts_of, specialised
from benchtool.emulator.machine.coefficients import (
    MOST_TURN,
    Machine,
    fastest_rate,
    holding,
    turning_rate,
    warmed,
)
from benchtool.emulator.machine.dc_link import supplied
from benchtool.emulator.machine.diodes import freewheel
from benchtool.emulator.machine.heat import warm
from benchtool.emulator.machine.inverter import PowerStage
from benchtool.emulator.machine.saturation import Flux, Saturation
from benchtool.emulator.machine.sensors import Sensing, measure
from benchtool.emulator.machine.state import State, flux_of, place
from benchtool.emulator.machine.switching import switch
from benchtool.ticks import TICKS

_TICKS_BETWEEN_DIRECTIONS = 64
_LAST_TICK = TICKS - 1


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
    sensors: Any,
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
    """Run up to `ticks` ticks. Returns how many.

    There are fewer after the tick in which a new trip was raised, and before one in which the machine would
    turn too fast to be computed.
    """
    drive, command, control = memory[0], commands[0], controls[0]
    measurement, shaft, load, sensor = measurements[0], shafts[0], loads[0], sensors[0]
    capture, stream, transducer, stimulus = captures[0], streams[0], transducers[0], stimuli[0]
    cold = holding(machine, load.held != 0, False)
    for done in range(ticks):
        omega_m = load.omega_m_rad_s if load.held != 0 else shaft.omega_m
        driven = warmed(stage.heat, cold, shaft.T_winding, shaft.T_magnet)
        x = _true_state(driven.saturation, shaft, machine.p * omega_m, drive.tick)
        moving = turning_rate(driven)
        rate = fastest_rate(driven, x) + moving * abs(x.omega_e)
        gain = (
            moving * driven.gamma * abs(load.torque_Nm) * stage.T_s
        )  # of the rate, by the load, in a period
        if not (rate + gain) * stage.T_s <= MOST_TURN:  # nor is what is no number
            return done
        transducer.next_sample = 0
        copper, iron = transducer.E_copper, transducer.E_iron
        switching = command.pwm_enabled != 0 and control.gated != 0
        if switching:
            x, charge = switch(
                x, rate, drive, control, shaft, stage, driven, load.torque_Nm, transducer, torque
            )
        else:
            shaft.high_a, shaft.high_b, shaft.high_c = 0, 0, 0
            shaft.blank_a, shaft.blank_b, shaft.blank_c = 0.0, 0.0, 0.0
            x, charge = freewheel(x, shaft.u_dc, stage, driven, load.torque_Nm, transducer, torque)
        shaft.u_dc = supplied(
            stage.link, shaft, stage.u_dc, stage.R_dc, charge, drive.tick * stage.T_s, stage.T_s
        )
        shaft.i_d, shaft.i_q, shaft.omega_m = x.i_d, x.i_q, x.omega_e / machine.p
        shaft.theta_e, shaft.cos_theta, shaft.sin_theta = x.theta_e, x.cos_theta, x.sin_theta
        _keep(x.flux, shaft)
        warm(stage.heat, shaft, transducer.E_copper - copper, transducer.E_iron - iron, stage.T_s)
        if transducer.recording == 1 and transducer.filled >= torque.size:
            transducer.recording = 0
        drive.tick = (int(drive.tick) + 1) & _LAST_TICK
        measure(
            x,
            shaft.u_dc,
            machine.p,
            switching,
            control,
            stage,
            sensing,
            sensor,
            noise[done],
            measurement,
        )
        tripped = control_tick(drive, command, control, stimulus, measurement)
        began = stimulus.began != 0
        capture_row(capture, drive, memory_words, memory_floats, channels, rows, tripped, began)
        stream_row(stream, memory_words, streamed, ring)
        if tripped:
            return done + 1
    return ticks


class Truth(NamedTuple):
    """What the kernel knows of the bench beside its state."""

    machine: Machine
    stage: PowerStage
    sensing: Sensing


def kernel_of(truth: Truth) -> Callable[..., int]:
    """`run_ticks` compiled for the parts that this bench has."""
    return specialised(run_ticks, frozenset(parts_of(truth)))


def kernel_is_cached(truth: Truth) -> bool:
    """Return whether the first run will load the kernel within a second; else it compiles for some
    seconds."""
    return is_cached(kernel_of(truth))


@njit
def _true_state(saturation: Saturation | None, shaft: Any, omega_e: float, tick: int) -> State:
    """Return machine's state; now and then its direction is derived from its angle, to hold both together."""
    flux = flux_of(saturation, shaft.i_d, shaft.i_q, Flux(shaft.psi_d, shaft.psi_q))
    if tick % _TICKS_BETWEEN_DIRECTIONS == 0:
        return place(shaft.i_d, shaft.i_q, omega_e, shaft.theta_e, flux)
    return State(shaft.i_d, shaft.i_q, omega_e, shaft.theta_e, 0.0, shaft.cos_theta, shaft.sin_theta, flux)


@njit
def _keep(flux: Flux | None, shaft: Any) -> None:
    """Keep the flux linkages of a machine that has them as states."""
    if flux is None:
        return
    shaft.psi_d, shaft.psi_q = flux.psi_d, flux.psi_q
