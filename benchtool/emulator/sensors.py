"""Measurement: what the converter and the encoder make of the machine's true state."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from benchtool.emulator.inverter import phase_currents
from benchtool.emulator.jit import njit
from benchtool.emulator.plant import State


class Sensing(NamedTuple):
    """Coefficients: gain and offset per phase, noise, converter steps, encoder counts per revolution."""

    gain_a: float
    gain_b: float
    gain_c: float
    offset_a: float
    offset_b: float
    offset_c: float
    noise: float
    i_step: float
    half_codes: float
    u_step: float
    counts: int
    encoder_offset: float


@njit
def code_of(value: float, step: float, lowest: float, highest: float) -> float:
    """Code of a mid-tread converter: the nearest step, held within its range."""
    return min(max(math.floor(value / step + 0.5), lowest), highest)


@njit
def encoder_count(theta_m: float, sensing: Sensing) -> int:
    """Position within a revolution, floor((theta_m + offset) counts / 2 pi) modulo counts."""
    count = math.floor((theta_m + sensing.encoder_offset) * sensing.counts / (2.0 * math.pi))
    return int(count - math.floor(count / sensing.counts) * sensing.counts)


@njit
def measure(
    x: State, u_dc: float, p: float, sensing: Sensing, noise: np.random.Generator, measurement: Any
) -> None:
    """Sample currents, dc link and position into the record `measurement`.

    `saturated` counts the currents that read either end of the converter's range.
    """
    i_a, i_b, i_c = phase_currents(x)
    i_a = sensing.gain_a * i_a + sensing.offset_a
    i_b = sensing.gain_b * i_b + sensing.offset_b
    i_c = sensing.gain_c * i_c + sensing.offset_c
    if sensing.noise > 0.0:
        i_a += sensing.noise * noise.standard_normal()
        i_b += sensing.noise * noise.standard_normal()
        i_c += sensing.noise * noise.standard_normal()
    lowest, highest = -sensing.half_codes, sensing.half_codes - 1.0
    code_a = code_of(i_a, sensing.i_step, lowest, highest)
    code_b = code_of(i_b, sensing.i_step, lowest, highest)
    code_c = code_of(i_c, sensing.i_step, lowest, highest)
    saturated = 0
    for code in (code_a, code_b, code_c):
        if code in (lowest, highest):
            saturated += 1
    measurement.i_a = code_a * sensing.i_step
    measurement.i_b = code_b * sensing.i_step
    measurement.i_c = code_c * sensing.i_step
    measurement.u_dc = code_of(u_dc, sensing.u_step, 0.0, 2.0 * sensing.half_codes - 1.0) * sensing.u_step
    measurement.count = encoder_count(x.theta_e / p, sensing)
    measurement.saturated = saturated
