"""Noise of samples at rest, and windows for noise that is a line wherever the signal stays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis.steps.smoothing import Noise, fitted_smoothers

OF_COUNTS = Noise(np.array([1.0, -0.5]) / 6.0, as_line=0.55)


def test_a_piece_of_one_reading_beside_a_short_one_has_normal_noise() -> None:
    few = np.repeat([0.0, 1.0], 4)
    found = Noise.of(few, np.full(300, 5.0))
    assert 0.0 < found.rms < 0.1
    assert found.innovations is None


def test_a_line_in_noise_is_not_heavy_at_the_ends_of_its_piece() -> None:
    """Its memory is longer than the piece: whitened, the first and the last samples are far off."""
    random = np.random.default_rng(8)
    row = np.arange(1400)
    lines = [
        0.02 * np.cos(0.46 * row + random.uniform(0.0, 2.0 * np.pi)) + 0.002 * random.standard_normal(1400)
        for _ in range(20)
    ]
    assert sum(Noise.of(each).innovations is not None for each in lines) <= 4
    heavy = [random.standard_t(4, 1400) for _ in range(20)]
    assert sum(Noise.of(each).innovations is not None for each in heavy) == 20


def counted(speed: np.ndarray) -> np.ndarray:
    """Return how many counts come in each row, of a shaft that turns by so many."""
    return np.diff(np.floor(np.concatenate([[0.4], 0.4 + np.cumsum(speed)])))


def test_a_line_at_rest_does_not_shorten_windows() -> None:
    row = np.arange(800.0)
    speed = 71.7 - 65.2 * np.exp(-row / 50.0)
    smoother, _ = fitted_smoothers(counted(speed), OF_COUNTS)
    assert smoother.half[-1] >= 32
    error = smoother.apply(counted(speed)) - speed
    assert np.std(error[100:700]) < 0.05


def test_a_mode_that_is_small_against_a_count_shortens_them() -> None:
    row = np.arange(800.0)
    ring = 3.0 * np.exp(-row / 90.0) * np.cos(2.0 * np.pi * row / 31.0)
    speed = 71.7 - 62.0 * np.exp(-row / 40.0) - ring
    for noise in (OF_COUNTS, replace(OF_COUNTS, as_line=0.0)):
        smoother, _ = fitted_smoothers(counted(speed), noise)
        assert np.max(smoother.half[60:160]) <= 10


def test_a_sum_without_what_goes_with_the_first_sample() -> None:
    """By draws: what is left of the sum once the first sample tells of it what it can."""
    decay = np.exp(-0.1 * np.arange(60.0))
    weights = np.exp(-np.arange(80) / 20.0)
    for offset in (0.0, 0.8):
        noise = Noise(decay, offset)
        drawn = noise.draw(np.random.default_rng(3), (20_000, 80))
        sums, first = drawn @ weights, drawn[:, 0]
        left = sums - first * float(first @ sums) / float(first @ first)
        assert noise.of_sum_after_first(weights) == pytest.approx(float(np.std(left)), rel=0.03)
        assert noise.of_sum_after_first(weights) < 0.9 * noise.of_sum(weights)
    assert Noise(np.zeros(1)).of_sum_after_first(weights) == 0.0
