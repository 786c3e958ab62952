"""How much the largest of maxima scatters."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from benchtool.analysis.statistics.excesses import scatter_of_largest
from benchtool.analysis.statistics.maxima import (
    ends_before_normal,
    is_no_heavier_than_normal,
    scatter_of_heap,
    scatter_of_largest_maximum,
    scatter_of_largest_normal,
)

Draw = Callable[[np.random.Generator, tuple[int, ...]], np.ndarray]


def _normal(random: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return random.standard_normal(shape)


def _ended(random: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Near a crest, uniform noise ends with the power 3/2 of the distance from the largest value."""
    return 1.0 - random.random(shape) ** (2.0 / 3.0)


@pytest.mark.parametrize(
    ("draw", "within", "periods"),
    [(_normal, 1, 30), (_normal, 100, 30), (_normal, 20, 200), (_normal, 50, 8), (_ended, 50, 40)],
)
def test_the_largest_of_maxima_scatters_as_stated(draw: Draw, within: int, periods: int) -> None:
    maxima = np.max(draw(np.random.default_rng(4), (300, periods, within)), axis=2)
    stated = np.array([scatter_of_largest_maximum(each) for each in maxima])
    largest = np.max(maxima, axis=1)
    error = (largest - np.mean(largest)) / stated
    assert 0.7 < np.sqrt(np.mean(error**2)) < 1.4


def test_of_a_tail_that_ends_it_is_far_less_than_of_an_exponential_one() -> None:
    maxima = np.max(_ended(np.random.default_rng(5), (40, 50)), axis=1)
    assert scatter_of_largest_maximum(maxima) < 0.6 * scatter_of_largest(maxima)
    assert scatter_of_largest_maximum(np.ones(10), 0.3) == 0.3
    assert scatter_of_largest_maximum(maxima, 2.0) == 2.0


def test_the_largest_of_normal_values_scatters_as_stated_and_a_tail_that_ends_is_none() -> None:
    random = np.random.default_rng(6)
    largest = np.max(random.standard_normal((500, 1000)), axis=1)
    stated = scatter_of_largest_normal(2.0 * random.standard_normal(20_000), 1000)
    assert stated == pytest.approx(2.0 * np.std(largest), rel=0.1)
    with_edges = np.append(random.standard_normal(20_000), [50.0, -80.0])
    assert scatter_of_largest_normal(with_edges, 1000) == pytest.approx(np.std(largest), rel=0.1)
    for other in (random.uniform(-1.0, 1.0, 20_000), np.zeros(10)):
        assert scatter_of_largest_normal(other, 1000) == 0.0


def test_a_tail_heavier_than_normal_is_told() -> None:
    random = np.random.default_rng(5)
    assert is_no_heavier_than_normal(random.uniform(-1.0, 1.0, 20_000))
    assert not is_no_heavier_than_normal(random.laplace(size=20_000))
    assert not is_no_heavier_than_normal(np.zeros(10))


def test_what_a_control_bounds_ends_before_normal_noise_does() -> None:
    random = np.random.default_rng(14)
    normal = [ends_before_normal(random.standard_normal(5000)) for _ in range(200)]
    assert 0.05 < np.mean(normal) < 0.3  # by one standard deviation: 0.16
    bounded = [ends_before_normal(np.clip(random.standard_normal(5000), -2.9, 2.9)) for _ in range(50)]
    assert all(bounded)
    assert not ends_before_normal(np.empty(0))


def test_the_largest_of_heaps_is_in_the_same_or_in_the_next() -> None:
    # one maximum in seventeen is in the highest heap: half of the records have one there
    random = np.random.default_rng(8)
    levels = np.searchsorted([0.4, 16.0 / 17.0], random.random((300, 12)))
    maxima = levels + 1e-3 * random.standard_normal(levels.shape)
    stated = np.array([scatter_of_heap(each) for each in maxima])
    largest = np.max(maxima, axis=1)
    assert np.mean(stated > 0.0) > 0.6
    error = (largest - np.mean(largest))[stated > 0.0] / stated[stated > 0.0]
    assert 0.7 < np.sqrt(np.mean(error**2)) < 1.6


def test_a_rare_level_beyond_a_heap_comes_again_or_not() -> None:
    # once in a record on average, as a code of a converter that noise hardly reaches
    random = np.random.default_rng(10)
    maxima = (random.random((400, 20)) < 0.05) + 1e-2 * random.random((400, 20))
    stated = np.array([scatter_of_heap(each) for each in maxima])
    largest = np.max(maxima, axis=1)
    once = np.count_nonzero(maxima > 0.5, axis=1) == 1
    assert np.all(stated[once] > 0.4)
    assert float(np.std(largest)) == pytest.approx(float(np.mean(stated[once])), rel=0.15)


def test_values_of_no_heaps_are_none() -> None:
    random = np.random.default_rng(9)
    for draw in (random.standard_normal, random.standard_exponential, random.random):
        assert np.mean([scatter_of_heap(draw(12)) > 0.0 for _ in range(300)]) < 0.01


def test_few_maxima_in_one_heap_end_as_far_below_it_as_the_samples_do() -> None:
    """A torque that takes few values, each rounded, against a waveform that repeats its own."""
    random = np.random.default_rng(5)
    levels = 0.01 * np.round(random.normal(0.0, 2.0, 5000)) + 1e-6 * random.standard_normal(5000)
    levels = np.minimum(levels, 0.04 + 1e-6 * random.standard_normal(5000))
    maxima = np.sort(levels)[-5:]
    assert scatter_of_heap(maxima) < 1e-5
    assert scatter_of_heap(maxima, levels) == pytest.approx(0.01 * math.sqrt(0.293 * 0.707), rel=0.01)

    repeated = np.tile(np.cos(np.linspace(0.0, 6.28, 1000)), 5)
    assert scatter_of_heap(np.max(repeated.reshape(5, -1), axis=1), repeated) == 0.0
