"""Bursts of noise in a transient: found by what a prediction leaves, not made of what the transient does."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.steps.bursts import noise_levels
from benchtool.analysis.steps.smoothing import Noise

_ROWS = np.arange(2000.0)


@pytest.mark.parametrize("cycles", [0.0, 0.006, 0.02, 0.09, 0.2])
def test_an_answer_in_steady_noise_has_no_burst(cycles: float) -> None:
    random = np.random.default_rng(7)
    answer = 1.0 - np.exp(-_ROWS / 60.0) * np.cos(2.0 * np.pi * cycles * _ROWS)
    at_rest = Noise.of(3e-3 * random.standard_normal(1000))
    levels = noise_levels(answer + 3e-3 * random.standard_normal(2000), at_rest)
    assert np.mean(levels > 1.0) < 0.02


def test_a_burst_has_its_own_level() -> None:
    random = np.random.default_rng(8)
    noise = 3e-3 * random.standard_normal(2000)
    noise[400:480] *= 9.0
    answer = 1.0 - np.exp(-_ROWS / 100.0) * np.cos(2.0 * np.pi * _ROWS / 300.0)
    levels = noise_levels(answer + noise, Noise.of(noise[1000:]))
    assert 5.0 < np.median(levels[410:470]) < 15.0
    assert np.all(levels[:360] == 1.0)
    assert np.all(levels[520:] == 1.0)


def test_the_edge_of_a_pulse_is_no_burst() -> None:
    noise = 3e-3 * np.random.default_rng(9).standard_normal(2000)
    levels = noise_levels(np.where(_ROWS < 700, 1.0, 0.0) + noise, Noise.of(noise[1000:]))
    assert np.all(levels == 1.0)
