"""A swing that explains nearly all of a series is no noise of its mean."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.statistics.scatter import mean_of_periods
from benchtool.analysis.statistics.slow_swing import slow_swing

Array = NDArray[np.float64]


def swinging(count: int, cycles: float, noise: float, random: np.random.Generator) -> Array:
    place = (np.arange(count) + 0.5) / count
    swing = np.cos(2.0 * np.pi * (cycles * place + random.uniform()))
    return np.asarray(3.0 + 0.2 * swing + noise * random.standard_normal(count))


@pytest.mark.parametrize(
    ("count", "cycles", "noise"),
    [(30, 1.4, 0.02), (50, 3.3, 0.02), (50, 9.6, 0.02), (400, 2.7, 0.02), (50, 4.5, 0.07), (60, 2.4, 0.06)],
)
def test_the_mean_is_about_the_swing_and_scatters_by_the_rest(
    count: int, cycles: float, noise: float
) -> None:
    random = np.random.default_rng(7)
    relative = []
    for _ in range(60):
        mean, error = mean_of_periods(swinging(count, cycles, noise, random))
        relative.append((mean - 3.0) / error.standard)
    assert 0.7 < np.sqrt(np.mean(np.square(relative))) < 1.3


@pytest.mark.parametrize("count", [24, 60, 150])
def test_a_random_walk_is_no_swing(count: int) -> None:
    random = np.random.default_rng(8)
    assert not any(slow_swing(np.cumsum(random.standard_normal(count))) for _ in range(60))


def test_red_noise_that_one_sinusoid_explains_in_part_leaves_neighbours_alike() -> None:
    random, found = np.random.default_rng(8), 0
    shape = 1.0 / np.maximum(1.0, np.arange(401.0)) ** 0.75
    for _ in range(200):
        bins = shape * (random.standard_normal(401) + 1j * random.standard_normal(401))
        found += slow_swing(np.fft.irfft(bins)[:50]) is not None
    assert found <= 1


@pytest.mark.parametrize(
    ("count", "cycles"), [(20, 3.3), (60, 0.6), (60, 20.3)], ids=["few values", "part of a cycle", "fast"]
)
def test_what_is_not_told_from_the_mean_or_from_noise_is_none(count: int, cycles: float) -> None:
    assert slow_swing(swinging(count, cycles, 1e-3, np.random.default_rng(9))) is None


def test_values_that_are_all_alike_do_not_swing() -> None:
    assert slow_swing(np.full(50, 1.5)) is None
    mean, error = mean_of_periods(np.full(50, 1.5))
    assert (mean, error.standard) == (1.5, 0.0)
