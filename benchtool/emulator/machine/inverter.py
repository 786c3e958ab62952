"""The two-level inverter: PWM edges from duties, leg voltages from switch states.

A leg is high for duty * T_s, centred in the period. During dead time neither switch of a leg is on and the
current holds the leg: out of the leg (i > 0) through the lower diode, so its rising edge comes late; into the
leg through the upper diode, so its falling edge comes late. The sign that counts is that of the current at
the start of the period for the rising edge, and at the rising edge for the falling one. A conducting device
takes a constant voltage against its current.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.plant import State

NEVER = math.inf
SQRT3 = math.sqrt(3.0)


class PowerStage(NamedTuple):
    """True coefficients; `u_dc` is the voltage behind the dc link's resistance `R_dc`."""

    T_s: float
    u_dc: float
    R_dc: float
    dead_time: float
    drop: float


@njit
def phase_currents(x: State) -> tuple[float, float, float]:
    """Currents of the three phases, out of the legs into the motor."""
    i_alpha = x.i_d * x.cos_theta - x.i_q * x.sin_theta
    i_beta = x.i_d * x.sin_theta + x.i_q * x.cos_theta
    return i_alpha, -0.5 * i_alpha + 0.5 * SQRT3 * i_beta, -0.5 * i_alpha - 0.5 * SQRT3 * i_beta


@njit
def clarke(a: float, b: float, c: float) -> tuple[float, float]:
    """Amplitude-invariant alpha and beta of three phase quantities."""
    return (2.0 * a - b - c) * (1.0 / 3.0), (b - c) * (1.0 / SQRT3)


@njit
def rising_edge(duty: float, current: float, stage: PowerStage) -> float:
    """When a leg goes high, in s from the start of the period: 0 for the whole period, never for duty 0."""
    if duty <= 0.0:
        return NEVER
    if duty >= 1.0:
        return 0.0
    edge = 0.5 * (1.0 - duty) * stage.T_s
    if current > 0.0:
        edge = min(edge + stage.dead_time, falling_edge(duty, current, stage))
    return edge


@njit
def falling_edge(duty: float, current: float, stage: PowerStage) -> float:
    """When a leg that has gone high goes low, in s from the start of the period."""
    if duty >= 1.0:
        return NEVER
    edge = 0.5 * (1.0 + duty) * stage.T_s
    return min(edge + stage.dead_time, stage.T_s) if current < 0.0 else edge


@njit
def leg_voltages(
    high_a: bool, high_b: bool, high_c: bool, x: State, u_dc: float, stage: PowerStage
) -> tuple[float, float]:
    """Stator voltage (alpha, beta) of a switch state, less the drop of the conducting devices."""
    v_a = u_dc if high_a else 0.0
    v_b = u_dc if high_b else 0.0
    v_c = u_dc if high_c else 0.0
    if stage.drop > 0.0:
        i_a, i_b, i_c = phase_currents(x)
        v_a -= math.copysign(stage.drop, i_a)
        v_b -= math.copysign(stage.drop, i_b)
        v_c -= math.copysign(stage.drop, i_c)
    return clarke(v_a, v_b, v_c)
