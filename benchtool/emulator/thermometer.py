"""Thermometers of the emulated bench: what they make of the true temperatures."""

from __future__ import annotations

import math

import numpy as np

from benchtool.emulator.core.core import Core
from benchtool.emulator.machine.sampling import weights
from benchtool.profile import EmulatedTemperature, TemperatureSensor


def true_temperatures(core: Core, stated: EmulatedTemperature) -> tuple[float, float]:
    """Return the true temperatures of winding and surroundings in degrees Celsius.

    They are what the profile states: the machine of `core` has no thermal model.
    """
    return stated.winding_degC, stated.ambient_degC


class EmulatedThermometer:
    """Thermometers of the winding and of the surroundings, of one kind.

    Each follows its temperature with a first-order lag, exact for one that changes evenly between two looks
    at it, and reads gain times that plus offset and noise, in steps of its resolution.

    Args:
        core: the machine.
        stated: temperatures that the profile states.
        sensor: their errors.
        seed: of their noise.

    Attributes:
        sensor: their errors, which may change.
    """

    def __init__(self, core: Core, stated: EmulatedTemperature, sensor: TemperatureSensor, seed: int) -> None:
        self._core, self._stated = core, stated
        self.sensor = sensor
        self._noise = np.random.Generator(np.random.PCG64([seed, 2]))
        self._true = self._followed = true_temperatures(core, stated)
        self._now_s = 0.0

    def follow(self, now_s: float) -> None:
        """Have time pass until `now_s`, drive time."""
        true = true_temperatures(self._core, self._stated)
        if self.sensor.lag_s > 0.0:
            a = (now_s - self._now_s) / self.sensor.lag_s
            w_0, w_1, _, _ = weights(a)
            winding, ambient = (
                math.exp(-a) * y + w_0 * before + w_1 * (after - before)
                for y, before, after in zip(self._followed, self._true, true, strict=True)
            )
            self._followed = winding, ambient
        else:
            self._followed = true
        self._true, self._now_s = true, now_s

    def read(self) -> tuple[float, float]:
        """Return the readings for winding and surroundings in degrees Celsius."""
        winding, ambient = (self._reading(each) for each in self._followed)
        return winding, ambient

    def _reading(self, degC: float) -> float:
        sensor = self.sensor
        reading = sensor.gain * degC + sensor.offset_K
        if sensor.noise_K_rms > 0.0:
            reading += sensor.noise_K_rms * float(self._noise.standard_normal())
        if sensor.resolution_K > 0.0:
            reading = round(reading / sensor.resolution_K) * sensor.resolution_K
        return reading
