"""What the steps of a converter leave in a mean of readings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.sensors.mean_reading import MeanReading
from benchtool.block import Channel

STEP_V, RATE_HZ = 0.5, 1e3
U_DC = Channel("u_dc", "V")


def read(values_V: np.ndarray) -> MeanReading:
    return MeanReading.of(U_DC, STEP_V * np.round(values_V / STEP_V), RATE_HZ)


@pytest.mark.parametrize("value_V", [0.0, 122.6])
def test_readings_that_are_all_the_same_do_not_show_their_steps(value_V: float) -> None:
    found = MeanReading.of(U_DC, np.full(200, value_V) * (1.0 + 1e-14 * np.arange(200)), RATE_HZ)
    assert not found.is_resolved
    assert found.unresolved == (U_DC,)
    assert found.line() == ()


def test_readings_without_steps_are_off_by_none() -> None:
    found = MeanReading.of(U_DC, 122.6 + np.random.default_rng(0).standard_normal(2000), RATE_HZ)
    assert found.is_resolved
    assert found.line() == ()


def test_noise_of_a_step_leaves_little_of_it() -> None:
    noise = STEP_V * np.random.default_rng(1).standard_normal(4000)
    (line,) = read(122.6 + noise).line(2.0)
    assert line.name == "resolution of u_dc"
    assert line.evaluation == "B"
    assert line.standard < 0.1 * STEP_V


def test_a_reading_or_two_on_the_next_level_are_of_a_value_near_the_edge() -> None:
    values_V = np.full(400, 122.5)
    values_V[[70, 220]] += STEP_V
    (line,) = read(values_V).line()
    assert STEP_V / math.sqrt(12.0) < line.standard < 0.5 * STEP_V


@pytest.mark.parametrize("size", [0.8, 2.3])
def test_a_ripple_leaves_more_than_noise_of_its_power(size: float) -> None:
    """Rms of error over u where the mean is anywhere between two levels."""
    random, angle = np.random.default_rng(3), 2.0 * math.pi * 17.3 * np.arange(2000) / 2000.0
    over_u = []
    for level in random.uniform(120.0, 121.0, 24):
        found = read(level + STEP_V * size * np.sin(angle + random.uniform(0.0, 6.0)))
        whole = level + STEP_V * size * float(np.mean(np.sin(angle)))
        over_u.append((found.mean - whole) / found.of_steps)
    assert 0.5 < math.sqrt(np.mean(np.square(over_u))) < 1.8
