"""Index of a tail."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.statistics.tail import (
    GUMBEL,
    extreme_over_excess,
    moment_estimate,
    tail_index,
    tail_indices_of_heavy,
)


def test_tails_of_a_power_law_are_told_from_normal_ones() -> None:
    random = np.random.default_rng(5)
    normal = [tail_index(random.standard_normal(20_000)) for _ in range(20)]
    heavy = [tail_index(random.standard_t(3.0, 20_000)) for _ in range(20)]
    assert np.median(normal) == 0.0
    assert np.median(heavy) == pytest.approx(1.0 / 3.0, abs=0.12)
    assert tail_index(np.ones(50)) == 0.0


def test_few_values_far_larger_than_all_others_are_no_heavy_tail() -> None:
    random, found = np.random.default_rng(9), []
    for _ in range(10):
        noise = random.standard_normal(20_000)
        noise[random.integers(0, 20_000, 60)] += 30.0 * random.standard_normal(60)
        found.append(tail_index(noise))
    assert sum(each == 0.0 for each in found) >= 7


def test_tails_known_to_be_heavy_have_indices_also_where_none_is_significant() -> None:
    random = np.random.default_rng(5)
    few = [random.standard_t(3.0, 400) for _ in range(40)]
    assert all(tail_index(each, 40) == 0.0 for each in few)
    heavy = [tail_indices_of_heavy(each, 40) for each in few]
    assert 0.2 < float(np.median(heavy)) < 0.5
    assert np.min(heavy) > 0.0
    assert tail_indices_of_heavy(np.ones(400), 40) == tail_indices_of_heavy(few[0][:60], 40) == ()


@pytest.mark.parametrize(
    ("index", "count"),
    [(-20.0, 1), (-20.0, 3), (-1.0, 1), (-0.3, 3), (-0.3, 200), (0.01, 200), (0.1, 200), (0.3, 200)],
)
def test_the_largest_of_pareto_excesses_scatters_in_proportion_to_their_mean(
    index: float, count: int
) -> None:
    least = 1.0 - (1.0 - np.random.default_rng(21).random(40_000)) ** (1.0 / count)
    over_mean = float(np.std((least**-index - 1.0) / index)) * (1.0 - index)
    assert extreme_over_excess(index, count) == pytest.approx(over_mean, rel=0.1)
    assert extreme_over_excess(0.0, count) == GUMBEL == pytest.approx(1.2825, abs=1e-4)


@pytest.mark.parametrize("index", [-1e6, -300.0, -85.0, -1e-9, 0.4, 1e3])
@pytest.mark.parametrize("count", [1, 50, 10**6])
def test_no_index_is_too_far_from_zero(index: float, count: int) -> None:
    assert 0.0 <= extreme_over_excess(index, count) < 1e3


def test_the_moment_estimate_is_of_the_index_with_its_deviation() -> None:
    records = np.random.default_rng(22).pareto(4.0, (200, 4000))
    found = np.array([moment_estimate(each, 200) for each in records])
    assert np.mean(found[:, 0]) == pytest.approx(0.25, abs=0.05)
    assert np.std(found[:, 0]) == pytest.approx(np.mean(found[:, 1]), rel=0.15)
    assert moment_estimate(np.ones(100), 20) == moment_estimate(np.zeros(100), 20) == (0.0, 0.0)


def test_a_tail_on_one_side_is_one_of_the_magnitudes_from_twenty_values_of_it_on() -> None:
    size = ((np.arange(2000) + 0.5) / 2000) ** -0.5  # quantiles of Pareto's distribution of index 1/2
    assert tail_index(-size) == tail_index(size) == pytest.approx(0.5 + 1.25**0.5 / 20.0**0.5, abs=0.1)
    assert tail_index(-size[1:]) == 0.0


def test_heavy_tails_are_of_less_than_a_quarter_of_the_values() -> None:
    few = np.random.default_rng(3).standard_t(3.0, 81)
    assert len(tail_indices_of_heavy(few, 10)) > 8
    assert tail_indices_of_heavy(-np.abs(few), 10) == tail_indices_of_heavy(few, 10)
    assert tail_indices_of_heavy(few[1:], 10) == ()
