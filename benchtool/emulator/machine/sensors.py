"""Measurement: from the machine's true state to what the drive reads.

A current passes its sensor (bandwidth, delay, gain, offset, drift, noise), is read at a moment of the PWM
period, through a shunt or not, and is converted. The dc link passes the same without a moment: its voltage
holds for a period. The encoder is read at the control tick.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.encoder import Encoder, encoder_count
from benchtool.emulator.machine.inverter import PowerStage, phase_currents
from benchtool.emulator.machine.sampling import sampled
from benchtool.emulator.machine.shunts import Shunts, readable, reconstructed, through_shunts
from benchtool.emulator.machine.state import State


class Drift(NamedTuple):
    """Changes per kelvin of the current sensors' gains and offsets, and how they warm up from power-up.

    In a control period they go the part `share` of the way that is left to `rise` K.
    """

    gain_a: float
    gain_b: float
    gain_c: float
    offset_a: float
    offset_b: float
    offset_c: float
    rise: float
    share: float


class VoltageLag(NamedTuple):
    """Part of the way to a new voltage that the sensor of the dc link goes in a control period."""

    share: float


class Sensing(NamedTuple):
    """Coefficients: gains and offsets of the three phases and of the dc link, converter steps, encoder."""

    gain_a: float
    gain_b: float
    gain_c: float
    offset_a: float
    offset_b: float
    offset_c: float
    gain_u: float
    offset_u: float
    i_step: float
    half_codes: float
    u_step: float
    encoder: Encoder
    drift: Drift | None
    shunts: Shunts | None
    u_lag: VoltageLag | None


@njit
def code_of(value: float, steps_per_unit: float, lowest: float, highest: float) -> float:
    """Return the code of a mid-tread converter: the nearest step, held within its range."""
    return min(max(math.floor(value * steps_per_unit + 0.5), lowest), highest)


@njit
def measure(
    x: State,
    u_dc: float,
    p: float,
    switching: bool,
    control: Any,
    stage: PowerStage,
    sensing: Sensing,
    sensor: Any,
    noise: NDArray[np.float32],
    measurement: Any,
) -> None:
    """Sample currents, dc link and position into the record `measurement`, once in each control tick.

    `switching` says whether the power stage was on in the period that ends, with the duties of `control`.
    `sensor` is the state of the sensors. `noise`, shape (4,), is added to the currents in A and to the dc
    link in V. `saturated` counts the currents that are read at either end of the converter's range,
    `u_dc_saturated` is set where the dc link is read at the upper one.
    """
    i_a, i_b, i_c = phase_currents(x)
    i_a, i_b, i_c = sampled(stage.sampling, i_a, i_b, i_c)
    i_a, i_b, i_c = through_shunts(sensing.shunts, switching, i_a, i_b, i_c)
    i_a, i_b, i_c = _read(sensing.drift, sensing, sensor, i_a, i_b, i_c)
    i_a, i_b, i_c = i_a + noise[0], i_b + noise[1], i_c + noise[2]
    lowest, highest = -sensing.half_codes, sensing.half_codes - 1.0
    steps_per_A, steps_per_V = 1.0 / sensing.i_step, 1.0 / sensing.u_step
    code_a = code_of(i_a, steps_per_A, lowest, highest)
    code_b = code_of(i_b, steps_per_A, lowest, highest)
    code_c = code_of(i_c, steps_per_A, lowest, highest)
    seen_a, seen_b, seen_c = readable(sensing.shunts, switching, control, stage, sensor)
    saturated = 0
    for code, seen in ((code_a, seen_a), (code_b, seen_b), (code_c, seen_c)):
        if seen and code in (lowest, highest):
            saturated += 1
    measurement.i_a, measurement.i_b, measurement.i_c = reconstructed(
        sensing.shunts,
        (seen_a, seen_b, seen_c),
        (code_a * sensing.i_step, code_b * sensing.i_step, code_c * sensing.i_step),
        (measurement.i_a, measurement.i_b, measurement.i_c),
    )
    top = 2.0 * sensing.half_codes - 1.0
    u_dc = sensing.gain_u * _lagged(sensing.u_lag, u_dc, sensor) + sensing.offset_u + noise[3]
    code_u = code_of(u_dc, steps_per_V, 0.0, top)
    measurement.u_dc = code_u * sensing.u_step
    measurement.count = encoder_count(x.theta_e / p, sensing.encoder, sensor)
    measurement.saturated = saturated
    measurement.u_dc_saturated = 1 if code_u == top else 0


@njit
def _read(
    drift: Drift | None, sensing: Sensing, sensor: Any, i_a: float, i_b: float, i_c: float
) -> tuple[float, float, float]:
    """Return what the sensors make of the currents, without noise."""
    if drift is None:
        return (
            sensing.gain_a * i_a + sensing.offset_a,
            sensing.gain_b * i_b + sensing.offset_b,
            sensing.gain_c * i_c + sensing.offset_c,
        )
    sensor.warm_K += drift.share * (drift.rise - sensor.warm_K)
    warm: float = sensor.warm_K
    return (
        (sensing.gain_a + drift.gain_a * warm) * i_a + sensing.offset_a + drift.offset_a * warm,
        (sensing.gain_b + drift.gain_b * warm) * i_b + sensing.offset_b + drift.offset_b * warm,
        (sensing.gain_c + drift.gain_c * warm) * i_c + sensing.offset_c + drift.offset_c * warm,
    )


@njit
def _lagged(lag: VoltageLag | None, u_dc: float, sensor: Any) -> float:
    """Return the dc link as its sensor follows it; its voltage has held for the period."""
    if lag is None:
        return u_dc
    sensor.u_dc += lag.share * (u_dc - sensor.u_dc)
    u: float = sensor.u_dc
    return u


class Noise:
    """Gaussian noise of the sensors of phases a, b, c and of the dc link, drawn ahead in batches, so that the
    same seed gives the same samples whichever ticks are run together.

    Args:
        rms: standard deviations, three in A and one in V.
        seed: of the generators, of which the dc link has one of its own.
    """

    BATCH = 4096

    def __init__(self, rms: tuple[float, float, float, float], seed: int) -> None:
        self._currents = np.random.Generator(np.random.PCG64(seed))
        self._dc_link = np.random.Generator(np.random.PCG64([seed, 1]))
        self._rms = np.asarray(rms, np.float32)
        self._used = self.BATCH
        self._of_currents = np.zeros((self.BATCH, 3), np.float32)  # of unit standard deviation, as below
        self._of_dc_link = np.zeros(self.BATCH, np.float32)
        self._samples = np.zeros((self.BATCH, 4), np.float32)
        self._drawn = [False, False]  # what this batch has: currents, dc link

    def set_rms(self, rms: tuple[float, float, float, float]) -> None:
        """Take other standard deviations from the next sample on."""
        self._rms = np.asarray(rms, np.float32)
        if self._used < self.BATCH:
            self._draw()

    def ahead(self) -> NDArray[np.float32]:
        """Return the samples of the ticks to come, shape (n, 4) with n of at least 1."""
        if self._used == self.BATCH:
            self._used = 0
            self._drawn = [False, False]
            self._draw()
        return self._samples[self._used :]

    def use(self, ticks: int) -> None:
        """Discard the first `ticks` samples, which were used."""
        self._used += ticks

    def _draw(self) -> None:
        """Draw what is not drawn yet and has an effect, which spares the others their time."""
        if self._rms[:3].any() and not self._drawn[0]:
            self._currents.standard_normal(dtype=np.float32, out=self._of_currents)
            self._drawn[0] = True
        if self._rms[3] and not self._drawn[1]:
            self._dc_link.standard_normal(dtype=np.float32, out=self._of_dc_link)
            self._drawn[1] = True
        # column by column: numpy takes four times as long for rows of four by four
        for column, drawn in enumerate((*self._of_currents.T, self._of_dc_link)):
            np.multiply(drawn, self._rms[column], out=self._samples[:, column])
