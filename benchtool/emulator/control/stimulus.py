"""The stimulus: a test signal that the drive plays by itself, one value in every tick.

The shapes are functions of the tick k within one repetition of N ticks, and of amplitude 1.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from benchtool.emulator.jit import njit


class StimulusState(IntEnum):
    """Object `stimulus_state`."""

    IDLE = 0
    RUNNING = 1
    DONE = 2


class Quantity(IntEnum):
    """Object `stimulus_quantity`: what the stimulus is added to."""

    TORQUE = 0
    SPEED = 1
    D_CURRENT = 2
    VOLTAGE = 3
    CURRENT = 4


class Shape(IntEnum):
    """Object `stimulus_shape`."""

    CONSTANT = 0
    STEP = 1
    STAIRCASE = 2
    RAMP = 3
    SINE = 4
    CHIRP_LINEAR = 5
    CHIRP_LOGARITHMIC = 6
    PRBS = 7


class Frame(IntEnum):
    """Object `stimulus_frame`: what the direction of a voltage or current is fixed to."""

    STATOR = 0
    ROTOR = 1


_IDLE, _RUNNING, _DONE = int(StimulusState.IDLE), int(StimulusState.RUNNING), int(StimulusState.DONE)
_CONSTANT, _STEP, _STAIRCASE = int(Shape.CONSTANT), int(Shape.STEP), int(Shape.STAIRCASE)
_RAMP, _SINE, _LINEAR = int(Shape.RAMP), int(Shape.SINE), int(Shape.CHIRP_LINEAR)
_LOGARITHMIC, _PRBS = int(Shape.CHIRP_LOGARITHMIC), int(Shape.PRBS)

# Exponents of a primitive polynomial x^n + ... + 1 for each register length n, besides 0 and n.
_EXPONENTS: Mapping[int, tuple[int, ...]] = {
    2: (1,),
    3: (2,),
    4: (3,),
    5: (3,),
    6: (5,),
    7: (6,),
    8: (7, 6, 1),
    9: (5,),
    10: (7,),
    11: (9,),
    12: (11, 10, 4),
    13: (12, 11, 8),
    14: (13, 12, 2),
    15: (14,),
    16: (15, 13, 4),
    17: (14,),
    18: (11,),
    19: (18, 17, 14),
    20: (17,),
}


def feedback(length: int) -> int:
    """Return mask of the bits whose parity is the next one of a maximum-length sequence of 2 to 20 bits."""
    return 1 | sum(1 << exponent for exponent in _EXPONENTS[length])


@njit
def shifted(register: int, mask: int, length: int) -> int:
    """Return the register one bit on; bit 0 is the present bit of the sequence."""
    parity = register & mask
    parity ^= parity >> 16
    parity ^= parity >> 8
    parity ^= parity >> 4
    parity ^= parity >> 2
    parity ^= parity >> 1
    return (register >> 1) | ((parity & 1) << (length - 1))


@njit
def chirp_cycles(k: int, ticks: int, f_start: float, f_end: float, T_s: float, logarithmic: bool) -> float:
    """Return the phase of a chirp at tick k in cycles since its start, in closed form.

    Linear: the frequency grows by (f_end - f_start) / N per tick; logarithmic: by the factor
    (f_end / f_start)^(1/N).
    """
    t, duration = k * T_s, ticks * T_s
    if logarithmic and f_start != f_end:
        growth = math.log(f_end / f_start)
        return f_start * duration * math.expm1(growth * (k / ticks)) / growth
    return (f_start + 0.5 * (f_end - f_start) * (k / ticks)) * t


@njit
def waveform(shape: int, k: int, ticks: int, steps: int, f_start: float, f_end: float, T_s: float) -> float:
    """Return every shape but the binary sequence at tick k of `ticks`, within [-1, 1].

    A step is 1 in the first half and 0 in the second; the staircase's j-th of `steps` levels is j / steps; a
    ramp would reach 1 at tick `ticks`; sines and chirps begin at phase zero.
    """
    if shape == _CONSTANT:
        return 1.0
    if shape == _STEP:
        return 1.0 if 2 * k < ticks else 0.0
    if shape == _STAIRCASE:
        return (k * steps // ticks + 1) / steps
    if shape == _RAMP:
        return k / ticks
    cycles = f_start * (k * T_s)
    if shape != _SINE:
        cycles = chirp_cycles(k, ticks, f_start, f_end, T_s, shape == _LOGARITHMIC)
    return math.sin(2.0 * math.pi * (cycles - math.floor(cycles)))


@njit
def play(stimulus: Any, tick: int) -> float:
    """Return the value in this tick, 0 unless one is running; moves the stimulus one tick on."""
    stimulus.began = 0
    if stimulus.state != _RUNNING:
        return 0.0
    if stimulus.played == stimulus.repetitions:
        stimulus.state = _DONE
        return 0.0
    k = stimulus.k
    if k == 0:
        stimulus.register = stimulus.seed
        if stimulus.played == 0:
            stimulus.began = 1
            stimulus.start_tick = tick
    elif stimulus.kind == _PRBS and k % stimulus.clock == 0:
        stimulus.register = shifted(stimulus.register, stimulus.mask, stimulus.length)
    if stimulus.kind == _PRBS:
        unit = 1.0 if stimulus.register & 1 else -1.0
    else:
        unit = waveform(
            stimulus.kind,
            k,
            stimulus.ticks,
            stimulus.steps,
            stimulus.f_start,
            stimulus.f_end,
            stimulus.T_s,
        )
    stimulus.k = k + 1
    if stimulus.k == stimulus.ticks:
        stimulus.k = 0
        stimulus.played += 1
    value: float = stimulus.offset + stimulus.amplitude * unit
    return value


@njit
def direction_of(stimulus: Any, cos_theta: float, sin_theta: float) -> tuple[float, float]:
    """Return the direction (cosine, sine) of a voltage or current in the tick that was played last.

    It is that of the rotor flux, (cos_theta, sin_theta), or the stimulus's angle, which turns if it is told
    to and stays where it is when the stimulus ends.
    """
    if stimulus.in_rotor_frame != 0:
        return cos_theta, sin_theta
    if stimulus.turn != 0.0 and stimulus.state == _RUNNING:
        n = stimulus.played * stimulus.ticks + stimulus.k - 1
        total = stimulus.repetitions * stimulus.ticks
        angle = stimulus.angle + stimulus.turn * turned_ticks(n, stimulus.turn_ticks, total)
        stimulus.cos_angle, stimulus.sin_angle = math.cos(angle), math.sin(angle)
    return stimulus.cos_angle, stimulus.sin_angle


@njit
def turned_ticks(n: int, ramp: int, total: int) -> float:
    """Return the ticks' worth of turning at full speed, n ticks after a start whose speed rises over `ramp`
    ticks, and falls to zero over the last `ramp` of `total` where these are twice as many."""
    if n < ramp:
        return 0.5 * n * n / ramp
    turned = n - 0.5 * ramp
    falling = n - (total - ramp)
    if falling > 0 and total >= 2 * ramp and ramp > 0:
        turned -= 0.5 * falling * falling / ramp
    return turned


def halt(stimulus: Any) -> None:
    """Stop a running stimulus, for the firmware, before the next tick."""
    stimulus.began = 0
    if stimulus.state == _RUNNING:
        stimulus.state = _IDLE
