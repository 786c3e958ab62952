"""A signal that departs steadily from the angle that its periods are told by."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import Measurement, analyze_steady_state
from benchtool.analysis.phase.steady_departure import steady_departure
from benchtool.block import Block

PERIODS = np.arange(9.0)
FREQUENCY_Hz = 37.3


def test_a_line_of_the_phase_is_told_in_noise_that_is_much_less() -> None:
    random = np.random.default_rng(5)
    noise = 1e-5 * random.standard_normal((2, 9))
    found = steady_departure(3e-4 * PERIODS + noise[0], 5.0 + 5.0 * noise[1])
    assert found.rise_rad == pytest.approx(3e-4, rel=0.03)
    assert found.standard_rad == pytest.approx(1e-5 / math.sqrt(60.0), rel=0.5)  # sum of (k - mean k)^2


def test_an_amplitude_that_moves_on_its_own_is_no_noise_of_the_phase() -> None:
    phase_rad = 3e-4 * PERIODS + 1e-6 * np.cos(PERIODS**2)
    found = steady_departure(phase_rad, 1.0 + 0.05 * np.cos(PERIODS))
    assert found.rise_rad == pytest.approx(3e-4, rel=0.01)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_of_few_periods_the_amplitude_tells_the_noise_in_any_unit(unit: float) -> None:
    """Of five, three polynomials of the phase alone do not, and four of the amplitude besides do."""
    periods = PERIODS[:5]
    noise = 1e-5 * np.array([[0.6, -1.0, 1.3, -1.1, 0.4], [-0.8, 0.5, 0.9, -1.2, 0.6]])
    phase_rad = 1e-5 * periods + noise[0]
    found = steady_departure(phase_rad, unit * (1.0 + noise[1]))
    assert found.rise_rad == pytest.approx(1e-5, rel=0.4)
    assert steady_departure(phase_rad, unit * (1.0 + 1e3 * noise[1])).rise_rad == 0.0


@pytest.mark.parametrize(("noise", "most"), [(1e-3, 30), (1.0, 3)])
def test_noise_is_rarely_a_steady_departure_and_that_of_no_tone_hardly_ever(noise: float, most: int) -> None:
    """What noise does once in twenty records is doubted where it is little, and where it is much no slip."""
    random = np.random.default_rng(7)
    still = np.array([0.0, 1.0])[:, np.newaxis]
    found = [steady_departure(*still + noise * random.standard_normal((2, 9))).rise_rad for _ in range(300)]
    assert np.count_nonzero(found) <= most


def test_a_swing_of_the_phase_is_no_steady_departure() -> None:
    assert steady_departure(3e-3 * np.cos(PERIODS), np.ones(9)).rise_rad == 0.0


@pytest.mark.parametrize("slip", [1e-4, -1e-4])
def test_a_slip_too_little_to_follow_is_in_the_frequency(slip: float) -> None:
    """Two milliradians do no harm to amplitudes, and are far more than the angle alone leaves open."""
    rate_Hz, frequency_Hz, random = 10e3, 37.3, np.random.default_rng(3)
    theta_e = 2 * np.pi * frequency_Hz * np.arange(2_100) / rate_Hz
    current = np.cos(theta_e) + 0.03 * np.cos(5 * theta_e) + 3e-4 * random.standard_normal(len(theta_e))
    angle = np.mod((1.0 + slip) * theta_e / 3, 2 * np.pi)
    block = Block.from_arrays(rate_Hz, {"i_a": "A", "theta_m": "rad"}, i_a=current, theta_m=angle)
    found = analyze_steady_state(block, pole_pairs=3, torque_rated_Nm=1.0)["fundamental_frequency"]
    assert found.uncertainty is not None
    assert abs(found.value - frequency_Hz) < 1.3 * found.uncertainty.standard
    assert found.uncertainty.standard < abs(slip) * frequency_Hz


def _of_a_slip(slip: float, wobble_rad: float, noise: float, seed: int) -> Measurement:
    """Return the frequency of a current at 37.3 Hz, by an angle of three pole pairs that slips and wobbles
    twice in a revolution."""
    rate_Hz, random = 10e3, np.random.default_rng(seed)
    theta_e = 2 * np.pi * FREQUENCY_Hz * np.arange(3_217) / rate_Hz
    current = np.cos(theta_e) + 0.03 * np.cos(5 * theta_e) + noise * random.standard_normal(len(theta_e))
    angle = np.mod((1.0 + slip) * theta_e / 3 + wobble_rad * np.cos(2.0 * theta_e / 3), 2 * np.pi)
    block = Block.from_arrays(rate_Hz, {"i_a": "A", "theta_m": "rad"}, i_a=current, theta_m=angle)
    return analyze_steady_state(block, pole_pairs=3, torque_rated_Nm=1.0)["fundamental_frequency"]


@pytest.mark.parametrize(
    ("slip", "wobble_rad", "noise"),
    [
        pytest.param(7e-5, 0.0, 1e-2, id="noise nearly hides it"),
        pytest.param(3e-4, 2e-3, 2e-2, id="the angle's own error is followed"),
    ],
)
def test_an_exact_angle_does_not_state_a_slip_as_exact(slip: float, wobble_rad: float, noise: float) -> None:
    for seed in range(4):
        found = _of_a_slip(slip, wobble_rad, noise, seed)
        assert found.uncertainty is not None
        assert abs(found.value - FREQUENCY_Hz) < 2.5 * found.uncertainty.standard


def test_noise_without_a_tone_departs_nowhere() -> None:
    """Phases of noise are put together by the shorter way each, which leads on by chance."""
    random, departures = np.random.default_rng(3), 0
    for _ in range(2000):
        phasor = random.standard_normal(8) + 1j * random.standard_normal(8)
        departures += steady_departure(np.unwrap(np.angle(phasor)), np.abs(phasor)).rise_rad != 0.0
    assert departures < 3
