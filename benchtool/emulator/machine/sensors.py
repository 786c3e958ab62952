"""Measurement: converter and encoder models applied to the machine's true state."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.inverter import phase_currents
from benchtool.emulator.machine.state import State


class Sensing(NamedTuple):
    """Coefficients: gain and offset per phase, converter steps, encoder counts per revolution."""

    gain_a: float
    gain_b: float
    gain_c: float
    offset_a: float
    offset_b: float
    offset_c: float
    i_step: float
    half_codes: float
    u_step: float
    counts: int
    encoder_offset: float


@njit
def code_of(value: float, steps_per_unit: float, lowest: float, highest: float) -> float:
    """Return the code of a mid-tread converter: the nearest step, held within its range."""
    return min(max(math.floor(value * steps_per_unit + 0.5), lowest), highest)


@njit
def encoder_count(theta_m: float, sensing: Sensing) -> int:
    """Return the position within a revolution, floor((theta_m + offset) counts / 2 pi) modulo counts."""
    count = math.floor((theta_m + sensing.encoder_offset) * sensing.counts / (2.0 * math.pi))
    return int(count - math.floor(count / sensing.counts) * sensing.counts)


@njit
def measure(
    x: State, u_dc: float, p: float, sensing: Sensing, noise: NDArray[np.float32], measurement: Any
) -> None:
    """Sample currents, dc link and position into the record `measurement`.

    `noise`, shape (3,), is added to the currents in A. `saturated` counts the currents that read either end
    of the converter's range, `u_dc_saturated` is set where the dc link reads the upper one.
    """
    i_a, i_b, i_c = phase_currents(x)
    i_a = sensing.gain_a * i_a + sensing.offset_a + noise[0]
    i_b = sensing.gain_b * i_b + sensing.offset_b + noise[1]
    i_c = sensing.gain_c * i_c + sensing.offset_c + noise[2]
    lowest, highest = -sensing.half_codes, sensing.half_codes - 1.0
    steps_per_A, steps_per_V = 1.0 / sensing.i_step, 1.0 / sensing.u_step
    code_a = code_of(i_a, steps_per_A, lowest, highest)
    code_b = code_of(i_b, steps_per_A, lowest, highest)
    code_c = code_of(i_c, steps_per_A, lowest, highest)
    saturated = 0
    for code in (code_a, code_b, code_c):
        if code in (lowest, highest):
            saturated += 1
    measurement.i_a = code_a * sensing.i_step
    measurement.i_b = code_b * sensing.i_step
    measurement.i_c = code_c * sensing.i_step
    top = 2.0 * sensing.half_codes - 1.0
    code_u = code_of(u_dc, steps_per_V, 0.0, top)
    measurement.u_dc = code_u * sensing.u_step
    measurement.count = encoder_count(x.theta_e / p, sensing)
    measurement.saturated = saturated
    measurement.u_dc_saturated = 1 if code_u == top else 0


class Noise:
    """Gaussian noise of the three current sensors, drawn ahead in batches, so that the same seed gives the
    same samples whichever ticks are run together.

    Args:
        rms_A: its standard deviation.
        seed: of the generator.
    """

    BATCH = 4096

    def __init__(self, rms_A: float, seed: int) -> None:
        self._rms_A = rms_A
        self._generator = np.random.Generator(np.random.PCG64(seed))
        self._used = self.BATCH
        self._samples = np.zeros((self.BATCH, 3), np.float32)

    def ahead(self) -> NDArray[np.float32]:
        """Return the samples of the ticks to come, shape (n, 3) with n of at least 1."""
        if self._used == self.BATCH:
            self._used = 0
            if self._rms_A > 0.0:
                self._generator.standard_normal(dtype=np.float32, out=self._samples)
                self._samples *= self._rms_A
        return self._samples[self._used :]

    def use(self, ticks: int) -> None:
        """Discard the first `ticks` samples, which were used."""
        self._used += ticks
