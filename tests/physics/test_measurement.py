"""Converter, encoder and noise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.emulator.machine.sensors import Noise, encoder_count, measure
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.truth import SensorTruth
from benchtool.emulator.memory import MEASUREMENT
from benchtool.errors import ValueRefused

TRUTH = SensorTruth(i_full_scale_A=15.0, u_full_scale_V=500.0)
STEP = 30.0 / 1024


def read(i_d: float, i_q: float = 0.0, truth: SensorTruth = TRUTH, u_dc: float = 122.5) -> np.record:
    record = np.zeros(1, MEASUREMENT)
    measure(place(i_d, i_q, 0.0, 0.0), u_dc, 4.0, truth.sensing(), np.zeros(3, np.float32), record[0])
    value: np.record = record[0]
    return value


def test_currents_are_within_half_a_step() -> None:
    for current in np.linspace(-14.9, 14.9, 101):
        assert abs(read(current).i_a - current) <= STEP / 2 + 1e-12
        assert read(current).i_a / STEP == pytest.approx(round(read(current).i_a / STEP))


def test_ends_of_the_range_are_held_and_counted() -> None:
    assert read(40.0).i_a == pytest.approx(15.0 - STEP)
    assert read(-40.0).i_a == pytest.approx(-15.0)
    assert read(40.0).saturated == 3  # b and c read -20 A
    assert read(18.0).saturated == 1
    assert read(10.0).saturated == 0


def test_gain_and_offset_of_a_phase() -> None:
    spoiled = SensorTruth(
        i_full_scale_A=15.0,
        u_full_scale_V=500.0,
        adc_bits=24,
        current_gain=(1.02, 1.0, 1.0),
        current_offset_A=(0.0, 0.1, -0.1),
    )
    sample = read(10.0, truth=spoiled)
    assert (sample.i_a, sample.i_b, sample.i_c) == pytest.approx((10.2, -4.9, -5.1), abs=1e-5)


def test_each_phase_has_a_gain_an_offset_and_a_noise_of_its_own() -> None:
    gains, offsets, noise = (1.02, 0.97, 1.05), (0.3, -0.2, 0.1), (0.01, 0.02, -0.04)
    truth = SensorTruth(
        i_full_scale_A=15.0,
        u_full_scale_V=500.0,
        adc_bits=24,
        current_gain=gains,
        current_offset_A=offsets,
    )
    record = np.zeros(1, MEASUREMENT)
    measure(place(3.0, 8.0, 0.0, 0.4), 122.5, 4.0, truth.sensing(), np.array(noise, np.float32), record[0])
    phases = [
        (complex(3.0, 8.0) * np.exp(1j * (0.4 - turn))).real for turn in (0.0, 2 * np.pi / 3, 4 * np.pi / 3)
    ]
    expected = [g * i + o + n for g, i, o, n in zip(gains, phases, offsets, noise, strict=True)]
    assert (record[0].i_a, record[0].i_b, record[0].i_c) == pytest.approx(expected, abs=1e-5)


def test_dc_link_uses_the_whole_range_from_zero() -> None:
    assert abs(read(0.0).u_dc - 122.5) <= 500.0 / 1024 / 2
    assert read(0.0, u_dc=900.0).u_dc == pytest.approx(500.0 - 500.0 / 1024)


def test_encoder_counts_down_to_the_edge() -> None:
    sensing = TRUTH.sensing()
    step = 2 * math.pi / 10_000
    for count in (0, 1, 4999, 9999):
        assert encoder_count((count + 0.01) * step, sensing) == count
        assert encoder_count((count + 0.99) * step - 2 * math.pi * 7, sensing) == count
    shifted = SensorTruth(i_full_scale_A=15.0, u_full_scale_V=500.0, encoder_offset_rad=10.5 * step)
    assert encoder_count(0.0, shifted.sensing()) == 10


def test_noise_is_gaussian_and_does_not_depend_on_how_ticks_are_taken() -> None:
    whole, parts = Noise(0.1, seed=5), Noise(0.1, seed=5)
    taken = []
    for ticks in (1, 4000, 95, 500, 3596):
        left = ticks
        while left:
            ahead = parts.ahead()
            now = min(left, len(ahead))
            taken.append(ahead[:now].copy())
            parts.use(now)
            left -= now
    first = whole.ahead().copy()
    whole.use(len(first))
    expected = np.concatenate([first, whole.ahead()])
    assert np.array_equal(np.concatenate(taken), expected)
    assert expected.std() == pytest.approx(0.1, rel=0.03)
    assert abs(expected.mean()) < 0.003


def test_no_noise_is_none() -> None:
    assert not Noise(0.0, seed=1).ahead().any()


@pytest.mark.parametrize(
    "change", [{"i_full_scale_A": 0.0}, {"adc_bits": 0}, {"current_noise_A_rms": -1.0}, {"encoder_lines": 0}]
)
def test_impossible_sensors_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValueRefused, match=next(iter(change))):
        SensorTruth(**{"i_full_scale_A": 15.0, "u_full_scale_V": 500.0, **change})  # type: ignore[arg-type]  # ints and floats mixed
