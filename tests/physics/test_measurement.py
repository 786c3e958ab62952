"""Converter, encoder and noise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.emulator.machine.encoder import encoder_count
from benchtool.emulator.machine.sensor_truth import CurrentTruth, SensorTruth, VoltageTruth
from benchtool.emulator.machine.sensors import Noise, measure
from benchtool.emulator.machine.state import State, place
from benchtool.emulator.machine.truth import InverterTruth
from benchtool.emulator.memory import CONTROL, MEASUREMENT, SENSOR
from benchtool.errors import ValueRefused

TRUTH = SensorTruth(i_full_scale_A=15.0, u_full_scale_V=500.0)
STEP = 30.0 / 1024
RMS = (0.1, 0.1, 0.1, 0.1)


def read(i_d: float, i_q: float = 0.0, truth: SensorTruth = TRUTH, u_dc: float = 122.5) -> np.record:
    record = np.zeros(1, MEASUREMENT)
    sample(place(i_d, i_q, 0.0, 0.0), u_dc, truth, np.zeros(4, np.float32), record[0])
    value: np.record = record[0]
    return value


def sample(x: State, u_dc: float, truth: SensorTruth, noise: NDArray[np.float32], record: np.record) -> None:
    """One measurement with the power stage off."""
    stage = InverterTruth(u_dc_V=122.5).power_stage(1e-4, truth.sampling(1e-4))
    sensor, control = np.zeros(1, SENSOR)[0], np.zeros(1, CONTROL)[0]
    measure(x, u_dc, 4.0, False, control, stage, truth.sensing(1e-4), sensor, noise, record)


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
        i_a=CurrentTruth(gain=1.02),
        i_b=CurrentTruth(offset_A=0.1),
        i_c=CurrentTruth(offset_A=-0.1),
    )
    got = read(10.0, truth=spoiled)
    assert (got.i_a, got.i_b, got.i_c) == pytest.approx((10.2, -4.9, -5.1), abs=1e-5)


def test_each_phase_has_a_gain_an_offset_and_a_noise_of_its_own() -> None:
    gains, offsets, noise = (1.02, 0.97, 1.05), (0.3, -0.2, 0.1), (0.01, 0.02, -0.04)
    a, b, c = (CurrentTruth(gain=g, offset_A=o) for g, o in zip(gains, offsets, strict=True))
    truth = SensorTruth(i_full_scale_A=15.0, u_full_scale_V=500.0, adc_bits=24, i_a=a, i_b=b, i_c=c)
    record = np.zeros(1, MEASUREMENT)
    sample(place(3.0, 8.0, 0.0, 0.4), 122.5, truth, np.array([*noise, 0.0], np.float32), record[0])
    phases = [
        (complex(3.0, 8.0) * np.exp(1j * (0.4 - turn))).real for turn in (0.0, 2 * np.pi / 3, 4 * np.pi / 3)
    ]
    expected = [g * i + o + n for g, i, o, n in zip(gains, phases, offsets, noise, strict=True)]
    assert (record[0].i_a, record[0].i_b, record[0].i_c) == pytest.approx(expected, abs=1e-5)


def test_a_phase_and_the_dc_link_that_are_stuck_read_the_same_whatever_is_there() -> None:
    truth = SensorTruth(
        i_full_scale_A=15.0,
        u_full_scale_V=500.0,
        adc_bits=24,
        current_noise_A_rms=0.1,
        warm_up_K=10.0,
        i_b=CurrentTruth(gain=2.0, offset_drift_A_K=1.0, stuck_A=-3.0),
        u_dc=VoltageTruth(gain=1.5, offset_V=2.0, noise_V_rms=1.0, stuck_V=48.0),
    )
    assert truth.noise_rms == (0.1, 0.0, 0.1, 0.0)
    for current, u_dc in ((0.0, 10.0), (7.0, 300.0)):
        got = read(current, truth=truth, u_dc=u_dc)
        assert (got.i_b, got.u_dc) == pytest.approx((-3.0, 48.0), abs=1e-4)
        assert got.i_a == pytest.approx(current, abs=1e-5)


def test_gain_and_offset_of_the_dc_link() -> None:
    truth = SensorTruth(
        i_full_scale_A=15.0,
        u_full_scale_V=500.0,
        adc_bits=24,
        u_dc=VoltageTruth(gain=0.98, offset_V=1.5),
    )
    assert read(0.0, truth=truth, u_dc=200.0).u_dc == pytest.approx(197.5, abs=1e-4)
    assert read(0.0, truth=truth, u_dc=700.0).u_dc_saturated == 1


def test_dc_link_uses_the_whole_range_from_zero() -> None:
    assert abs(read(0.0).u_dc - 122.5) <= 500.0 / 1024 / 2
    assert read(0.0, u_dc=900.0).u_dc == pytest.approx(500.0 - 500.0 / 1024)


def test_encoder_counts_down_to_the_edge() -> None:
    encoder, sensor = TRUTH.sensing(1e-4).encoder, np.zeros(1, SENSOR)[0]
    step = 2 * math.pi / 10_000
    for count in (0, 1, 4999, 9999):
        assert encoder_count((count + 0.01) * step, encoder, sensor) == count
        assert encoder_count((count + 0.99) * step - 2 * math.pi * 7, encoder, sensor) == count
    shifted = SensorTruth(i_full_scale_A=15.0, u_full_scale_V=500.0, encoder_offset_rad=10.5 * step)
    assert encoder_count(0.0, shifted.sensing(1e-4).encoder, sensor) == 10


def test_noise_is_gaussian_and_does_not_depend_on_how_ticks_are_taken() -> None:
    whole, parts = Noise(RMS, seed=5), Noise(RMS, seed=5)
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


def test_each_channel_has_a_noise_of_its_own_that_may_change_in_the_middle_of_a_batch() -> None:
    noise, undisturbed = Noise((0.1, 0.2, 0.0, 0.0), seed=5), Noise((0.1, 0.2, 0.0, 3.0), seed=5)
    before = noise.ahead()[:1000].copy()
    noise.use(1000)
    noise.set_rms((0.1, 0.4, 0.05, 2.0))
    after, same = noise.ahead().copy(), undisturbed.ahead()
    assert np.array_equal(before[:, :3], same[:1000, :3])
    assert np.array_equal(after[:, 0], same[1000:, 0])
    assert np.array_equal(after[:, 1], 2.0 * same[1000:, 1])
    assert after[:, 3] == pytest.approx(same[1000:, 3] * 2.0 / 3.0, rel=1e-6)
    assert after.std(axis=0) == pytest.approx([0.1, 0.4, 0.05, 2.0], rel=0.05)
    assert np.abs(np.corrcoef(after.T) - np.eye(4)).max() < 0.08


def test_no_noise_is_none() -> None:
    assert not Noise((0.0, 0.0, 0.0, 0.0), seed=1).ahead().any()


@pytest.mark.parametrize(
    "change", [{"i_full_scale_A": 0.0}, {"adc_bits": 0}, {"current_noise_A_rms": -1.0}, {"encoder_lines": 0}]
)
def test_impossible_sensors_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValueRefused, match=next(iter(change))):
        SensorTruth(**{"i_full_scale_A": 15.0, "u_full_scale_V": 500.0, **change})  # type: ignore[arg-type]  # ints and floats mixed
