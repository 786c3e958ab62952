"""Thermometers of the emulated bench: lag, gain, offset, noise and steps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

from benchtool.emulator import thermometer
from benchtool.emulator.thermometer import EmulatedThermometer
from benchtool.profile import EmulatedTemperature, TemperatureSensor
from tests.physics.paper_machine import make_core


def at(winding_degC: float, ambient_degC: float, **errors: float) -> EmulatedThermometer:
    stated = EmulatedTemperature(winding_degC=winding_degC, ambient_degC=ambient_degC)
    return EmulatedThermometer(make_core(), stated, TemperatureSensor(**errors), seed=1)


def test_a_sound_thermometer_reads_what_is_there() -> None:
    sound = at(71.3, 22.0)
    sound.follow(3.0)
    assert sound.read() == (71.3, 22.0)


def test_the_reading_lags_behind_a_temperature_that_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    times = np.array([0.0, 0.5, 4.0, 4.1, 30.0, 47.0, 120.0])
    winding, ambient = np.array([25.0, 25.0, 60.0, 61.0, 90.0, 80.0, 80.0]), 25.0 + 0.01 * times
    now = iter(zip(winding, ambient, strict=True))
    monkeypatch.setattr(thermometer, "true_temperatures", lambda core, stated: next(now))
    lagging, read = at(0.0, 0.0, lag_s=12.0, gain=1.1, offset_K=-3.0), []
    for time in times[1:]:
        lagging.follow(time)
        read.append(lagging.read())
    for k, true in enumerate((winding, ambient)):
        grid = np.linspace(0.0, 120.0, 12_001)
        _, followed, _ = lsim(([1.0], [12.0, 1.0]), np.interp(grid, times, true) - 25.0, grid)
        expected = 1.1 * (np.interp(times[1:], grid, followed) + 25.0) - 3.0
        assert [each[k] for each in read] == pytest.approx(expected, abs=1e-6)


def test_noise_and_steps() -> None:
    noisy = at(60.0, 20.0, noise_K_rms=0.5)
    readings = np.array([noisy.read() for _ in range(2000)])
    assert readings.mean(axis=0) == pytest.approx([60.0, 20.0], abs=0.05)
    assert readings.std(axis=0) == pytest.approx([0.5, 0.5], rel=0.1)
    assert at(60.4, 20.26, resolution_K=0.5).read() == (60.5, 20.5)
