"""Bursts of noise in a transient: found by what a prediction leaves, not made of what the transient does."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement, analyze_step
from benchtool.analysis.steps.bursts import noise_and_levels
from benchtool.analysis.steps.smoothing import Noise, fitted_smoothers
from benchtool.block import Block

Floats = NDArray[np.float64]

_ROWS = np.arange(2000.0)


@pytest.mark.parametrize("cycles", [0.0, 0.006, 0.02, 0.09, 0.2])
def test_an_answer_in_steady_noise_has_no_burst(cycles: float) -> None:
    random = np.random.default_rng(7)
    answer = 1.0 - np.exp(-_ROWS / 60.0) * np.cos(2.0 * np.pi * cycles * _ROWS)
    at_rest = Noise.of(3e-3 * random.standard_normal(1000))
    _, levels = noise_and_levels(answer + 3e-3 * random.standard_normal(2000), at_rest)
    assert np.mean(levels > 1.0) < 0.02


def test_a_burst_has_its_own_level() -> None:
    random = np.random.default_rng(8)
    noise = 3e-3 * random.standard_normal(2000)
    noise[400:480] *= 9.0
    answer = 1.0 - np.exp(-_ROWS / 100.0) * np.cos(2.0 * np.pi * _ROWS / 300.0)
    _, levels = noise_and_levels(answer + noise, Noise.of(noise[1000:]))
    assert 5.0 < np.median(levels[410:470]) < 15.0
    assert np.all(levels[:360] == 1.0)
    assert np.all(levels[520:] == 1.0)


def test_the_edge_of_a_pulse_is_no_burst() -> None:
    noise = 3e-3 * np.random.default_rng(9).standard_normal(2000)
    _, levels = noise_and_levels(np.where(_ROWS < 700, 1.0, 0.0) + noise, Noise.of(noise[1000:]))
    assert np.all(levels == 1.0)


def test_noise_that_has_bursts_at_rest_is_calm_between_them() -> None:
    """The noise at rest is known from a piece with a burst: neither calm nor as loud as that."""
    random, level = np.random.default_rng(10), np.full(2200, 2e-3)
    for begin in (500, 900, 1300, 2080):
        level[begin : begin + 44] = 1.4e-2
    noise = level * random.standard_normal(2200)
    at_rest = Noise.of(noise[:200], noise[-200:])
    calm, levels = noise_and_levels(noise[200:], at_rest)
    levels *= calm.rms
    assert np.median(levels) == pytest.approx(2e-3, rel=0.2)
    for begin in (300, 700, 1100, 1880):
        assert np.median(levels[begin : begin + 44]) == pytest.approx(1.4e-2, rel=0.5)


@pytest.mark.parametrize("cycles", [0.0, 0.02, 0.2])
def test_a_level_that_jumps_at_random_is_no_burst(cycles: float) -> None:
    random = np.random.default_rng(11)
    answer = 1.0 - np.exp(-_ROWS / 60.0) * np.cos(2.0 * np.pi * cycles * _ROWS)
    for _ in range(20):
        jumps = np.where(np.cumsum(random.random(2200) < 0.02) % 2, 3e-3, -3e-3)
        noise = jumps + 1e-3 * random.standard_normal(2200)
        at_rest = Noise.of(noise[:200], noise[-200:])
        found, levels = noise_and_levels(answer + noise[200:], at_rest)
        assert found is at_rest
        assert np.max(levels) == 1.0


def test_windows_beside_a_burst_stay_as_long() -> None:
    """What is loud is in all windows that reach it, and contradicts none of them."""
    random, levels = np.random.default_rng(12), np.ones(2000)
    levels[1000:1044] = 9.0
    at_rest = Noise(np.array([1e-6]))
    longest = []
    for _ in range(10):
        noise = 1e-3 * levels * random.standard_normal(2000)
        smoother, _ = fitted_smoothers(1.0 - np.exp(-_ROWS / 40.0) + noise, at_rest, levels)
        longest.append(smoother.half[960:1080].min())
    assert np.median(longest) >= 30


def _settling(noise: Floats, load: Floats | float = 0.0) -> Measurement:
    """Of a lag of 40 rows after 200 rows at rest."""
    since = np.maximum(np.arange(-200.0, len(noise) - 200.0), 0.0)
    y = 1.0 - np.exp(-since / 40.0) + load + noise
    r = (np.arange(len(y)) >= 200).astype(np.float64)
    block = Block.from_arrays(1.0, {"y": "Nm", "r": "Nm"}, y=y, r=r)
    found = analyze_step(block, "y", "r", held=True).measurements
    return next(each for each in found if each.name == "settling_time")


def test_bursts_late_in_a_record_take_no_answer_out_of_its_band() -> None:
    random, relative = np.random.default_rng(13), []
    for begins in ((900,), (1250, 1400), (600, 1700), (1990, 1500), (100, 1950)):
        level = np.full(2200, 1.6e-3)
        for begin in begins:
            level[begin : begin + 44] = 1.07e-2
        found = _settling(level * random.standard_normal(2200))
        assert found.uncertainty is not None
        assert found.uncertainty.standard < 30.0
        relative.append((found.value - 40.0 * np.log(50.0)) / found.uncertainty.standard)
    assert np.max(np.abs(relative)) < 3.0


def test_a_load_late_in_bursts_does_take_it_out() -> None:
    random, level = np.random.default_rng(14), np.full(2200, 1.6e-3)
    level[900:944] = level[2050:2094] = 1.07e-2
    since = np.maximum(np.arange(2200.0) - 1400.0, 0.0)
    load = -0.15 * np.exp(-since / 100.0) * (1.0 - np.exp(-since / 10.0))
    assert _settling(level * random.standard_normal(2200), load).value > 1350.0
