"""Phases of a speed that settles, beyond the first and last period."""

import math

import numpy as np
import pytest

from benchtool.analysis.phase.settling_phase import settling_phase

COUNT, BEFORE, AFTER = 16, 0.6, 1.1
NOISE_RAD = 1e-3


def test_the_ends_of_a_speed_that_settles_are_told_with_their_error() -> None:
    rng = np.random.default_rng(3)
    size_rad, over_periods = 0.3, 1.6
    ends = np.array([-BEFORE, COUNT - 1.0 + AFTER])
    start_rad, end_rad = size_rad * np.exp(-ends / over_periods)
    # the mean of an exponential over a period
    of_mean = 2.0 * over_periods * math.sinh(0.5 / over_periods)
    places = np.arange(COUNT)
    ratios = []
    for _ in range(60):
        phase_rad = size_rad * of_mean * np.exp(-places / over_periods) + 0.2 * places
        found = settling_phase(phase_rad + rng.normal(0.0, NOISE_RAD, COUNT), NOISE_RAD**2)
        assert found is not None
        turned_rad, error2 = found.turned(BEFORE, AFTER)
        ratios.append((turned_rad - 0.2 * (ends[1] - ends[0]) - (end_rad - start_rad)) / math.sqrt(error2))
    assert float(np.sqrt(np.mean(np.square(ratios)))) == pytest.approx(1.0, abs=0.35)
    assert abs(float(np.mean(ratios))) < 0.5


@pytest.mark.parametrize("swing_rad", [0.0, 0.1])
def test_noise_and_a_swing_are_no_settling(swing_rad: float) -> None:
    rng = np.random.default_rng(5)
    places = np.arange(60)
    for _ in range(20):
        phase_rad = swing_rad * np.sin(places / 4.0) + rng.normal(0.0, NOISE_RAD, len(places))
        assert settling_phase(phase_rad, NOISE_RAD**2) is None


def test_a_settling_of_many_radians_is_as_exact_as_its_noise() -> None:
    """Rates a part in three hundred apart are ten times the noise at the ends."""
    rng = np.random.default_rng(6)
    size_rad, count = -13.0, 98
    places, ends = np.arange(count), np.array([-BEFORE, count - 1.0 + AFTER])
    for over_periods in np.linspace(44.0, 46.0, 7):
        start_rad, end_rad = size_rad * np.exp(-ends / over_periods)
        phase_rad = size_rad * np.exp(-places / over_periods) + rng.normal(0.0, NOISE_RAD / 10.0, count)
        found = settling_phase(phase_rad, (NOISE_RAD / 10.0) ** 2, are_means=False)
        assert found is not None
        turned_rad, error2 = found.turned(BEFORE, AFTER)
        assert abs(turned_rad - (end_rad - start_rad)) < 2.5 * math.sqrt(error2)
