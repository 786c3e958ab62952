"""A signal that departs steadily from the angle that its periods are told by."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis import analyze_steady_state
from benchtool.analysis.phase.steady_departure import steady_departure
from benchtool.block import Block

PERIODS = np.arange(9.0)


def test_a_line_of_the_phase_is_told_in_noise_that_is_much_less() -> None:
    random = np.random.default_rng(5)
    noise = 1e-5 * random.standard_normal((2, 9))
    assert steady_departure(3e-4 * PERIODS + noise[0], 5.0 + 5.0 * noise[1]) == pytest.approx(3e-4, rel=0.03)


def test_an_amplitude_that_moves_on_its_own_is_no_noise_of_the_phase() -> None:
    phase_rad = 3e-4 * PERIODS + 1e-6 * np.cos(PERIODS**2)
    assert steady_departure(phase_rad, 1.0 + 0.05 * np.cos(PERIODS)) == pytest.approx(3e-4, rel=0.01)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_of_few_periods_the_amplitude_tells_the_noise_in_any_unit(unit: float) -> None:
    """Of five, three polynomials of the phase alone do not, and four of the amplitude besides do."""
    periods = PERIODS[:5]
    noise = 1e-5 * np.array([[0.6, -1.0, 1.3, -1.1, 0.4], [-0.8, 0.5, 0.9, -1.2, 0.6]])
    phase_rad = 4.5e-5 * periods + noise[0]
    assert steady_departure(phase_rad, unit * (1.0 + noise[1])) == pytest.approx(4.5e-5, rel=0.1)
    assert steady_departure(phase_rad, unit * (1.0 + 1e3 * noise[1])) == 0.0


def test_noise_and_a_swing_of_the_phase_are_no_steady_departure() -> None:
    random = np.random.default_rng(7)
    found = [
        steady_departure(*np.array([0.0, 1.0])[:, np.newaxis] + 1e-3 * random.standard_normal((2, 9)))
        for _ in range(300)
    ]
    assert np.count_nonzero(found) <= 3
    assert steady_departure(3e-3 * np.cos(PERIODS), np.ones(9)) == 0.0


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
