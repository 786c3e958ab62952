"""The kernel: machine, sensors, control, capture, stream and transducer, tick after tick.

Drive tick n is at n T_s. A tick integrates the machine over one control period with the duties that were
computed a tick before that period began, then samples, controls and records.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.control.cycle import control_tick
from benchtool.emulator.control.observer import shift
from benchtool.emulator.core.capture_memory import capture_row
from benchtool.emulator.core.stream_ring import stream_row
from benchtool.emulator.in_place import in_place, renewed
from benchtool.emulator.jit import njit
from benchtool.emulator.machine.coefficients import (
    MOST_TURN,
    Machine,
    driven_by,
    fastest_rate,
    rate_at,
    turning_rate,
    warmed,
)
from benchtool.emulator.machine.dc_link import supplied
from benchtool.emulator.machine.diodes import freewheel
from benchtool.emulator.machine.drive_train import (
    Far,
    acceleration_of,
    asked_torque,
    holds_rotor,
    is_ideal,
)
from benchtool.emulator.machine.encoder import found
from benchtool.emulator.machine.energies import keep_energies
from benchtool.emulator.machine.flange import follow
from benchtool.emulator.machine.heat import Heat, warm
from benchtool.emulator.machine.inverter import PowerStage
from benchtool.emulator.machine.saturation import Flux, Saturation
from benchtool.emulator.machine.sensors import Sensing, measure
from benchtool.emulator.machine.state import State, facing, flux_of, place
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
    energies: NDArray[np.float64],
) -> int:
    """Run up to `ticks` ticks. Returns how many.

    There are fewer after the tick in which a new trip was raised, and before one in which the machine would
    turn too fast to be computed.
    """
    drive, command, control = memory[0], commands[0], controls[0]
    measurement, shaft, load, sensor = measurements[0], shafts[0], loads[0], sensors[0]
    capture, stream, transducer, stimulus = captures[0], streams[0], transducers[0], stimuli[0]
    held = load.held != 0
    stage, sensing = in_place(stage), in_place(sensing)
    cold = driven_by(machine, held, load.omega_m_rad_s)
    driven = in_place(cold)
    at_rest = fastest_rate(driven, _true_state(driven.saturation, shaft, load, driven, drive.tick))
    moving = turning_rate(driven)
    for done in range(ticks):
        driven = renewed(stage.heat, driven, warmed(stage.heat, cold, shaft.T_winding, shaft.T_magnet))
        x = _true_state(driven.saturation, shaft, load, driven, drive.tick)
        T_load = asked_torque(driven.train, load, stage.T_s)
        at_rest, moving = _rates(stage.heat, driven.saturation, at_rest, moving, driven, x)
        rate = rate_at(x, at_rest, moving, driven)
        gain = moving * acceleration_of(driven.train, x.far, x.omega_e, driven.gamma, T_load) * stage.T_s
        if not (rate + gain) * stage.T_s <= MOST_TURN:  # nor is what is no number
            return done
        transducer.next_sample = 0
        dc, copper, iron = transducer.E_dc, transducer.E_copper, transducer.E_iron
        follow(driven.train, x, driven, T_load, transducer, stage.T_s)
        switching = command.pwm_enabled != 0 and control.gated != 0
        if switching:
            x, charge = switch(x, rate, drive, control, shaft, stage, driven, T_load, transducer, torque)
        else:
            shaft.high_a, shaft.high_b, shaft.high_c = 0, 0, 0
            shaft.blank_a, shaft.blank_b, shaft.blank_c = 0.0, 0.0, 0.0
            x, charge = freewheel(x, shaft.u_dc, stage, driven, T_load, transducer, torque)
        shaft.u_dc = supplied(
            stage.link,
            stage.accounts,
            shaft,
            stage.u_dc,
            stage.R_dc,
            charge,
            transducer.E_dc - dc,
            drive.tick * stage.T_s,
            stage.T_s,
            transducer,
        )
        shaft.i_d, shaft.i_q, shaft.omega_m = x.i_d, x.i_q, x.omega_e / machine.p
        shaft.theta_e, shaft.cos_theta, shaft.sin_theta = x.theta_e, x.cos_theta, x.sin_theta
        shaft.omega_load, shaft.twist, shaft.load_torque = x.far.omega, x.far.twist, x.far.torque
        _keep(driven.saturation, x.flux, shaft)
        warm(stage.heat, shaft, transducer.E_copper - copper, transducer.E_iron - iron, stage.T_s)
        keep_energies(stage.accounts, transducer, energies)
        if transducer.recording == 1 and transducer.filled >= torque.shape[0]:
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
        shift(found(sensing.encoder.counter, sensor), drive, control)
        tripped = control_tick(drive, command, control, stimulus, measurement)
        began = stimulus.began != 0
        capture_row(capture, drive, memory_words, memory_floats, channels, rows, tripped, began)
        stream_row(stream, memory_words, streamed, ring)
        if tripped:
            return done + 1
    return ticks


@njit
def _rates(
    heat: Heat | None, saturation: Saturation | None, at_rest: float, moving: float, m: Machine, x: State
) -> tuple[float, float]:
    """Return the machine's rates of now; they stay as they were where neither heat nor saturation moves
    them."""
    if heat is None and saturation is None:
        return at_rest, moving
    return fastest_rate(m, x), turning_rate(m)


@njit
def _true_state(saturation: Saturation | None, shaft: Any, load: Any, machine: Machine, tick: int) -> State:
    """Return the state, with what is held at the speed that it is held at.

    Now and then its direction is derived from its angle, to hold both together.
    """
    held = load.held != 0
    omega_m = load.omega_m_rad_s if held and holds_rotor(machine.train) else shaft.omega_m
    omega_load = load.omega_m_rad_s if held and is_ideal(machine.train) else shaft.omega_load
    far = Far(omega_load, shaft.twist, shaft.load_torque)
    flux = flux_of(saturation, shaft.i_d, shaft.i_q, Flux(shaft.psi_d, shaft.psi_q))
    if tick % _TICKS_BETWEEN_DIRECTIONS == 0:
        return facing(place(shaft.i_d, shaft.i_q, machine.p * omega_m, shaft.theta_e, flux), far)
    return State(
        shaft.i_d,
        shaft.i_q,
        machine.p * omega_m,
        shaft.theta_e,
        0.0,
        shaft.cos_theta,
        shaft.sin_theta,
        far,
        flux,
    )


@njit
def _keep(saturation: Saturation | None, flux: Flux, shaft: Any) -> None:
    """Keep the flux linkages of a machine that has them as states."""
    if saturation is None:
        return
    shaft.psi_d, shaft.psi_q = flux.psi_d, flux.psi_q
