"""How much the largest of values scatters, by what they exceed a level by."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.statistics.excesses import HeavyTail, scatter_of_largest


def scatter_in_tail(deviations: np.ndarray, maxima: np.ndarray) -> float:
    tail = HeavyTail.above(deviations)
    assert tail is not None
    return tail.scatter_of_largest(maxima)


def test_the_largest_of_a_record_scatters_over_records_as_stated() -> None:
    """Exponential values, whose largest has a standard deviation of pi / sqrt(6) beyond a few values."""
    records = np.random.default_rng(1).exponential(2.0, (400, 200))
    stated = np.array([scatter_of_largest(record) for record in records])
    assert np.mean(stated) == pytest.approx(2.0 * math.pi / math.sqrt(6.0), rel=0.1)
    assert np.mean(stated) == pytest.approx(float(np.std(records.max(axis=1))), rel=0.15)


def test_of_fewer_than_four_the_largest_has_no_scatter() -> None:
    assert math.isnan(scatter_of_largest(np.array([1.0, 3.0, 2.0])))
    # the mean excess of 2, 3 and 6 over the least of the four, 1, over that of quantiles of Gumbel's
    # distribution at 3/8, 5/8 and 7/8 over the one at 1/8
    quantiles = -np.log(-np.log(np.array([0.375, 0.625, 0.875])))
    of_gumbel = float(np.mean(quantiles)) + math.log(-math.log(0.125))
    assert scatter_of_largest(np.array([2.0, 6.0, 1.0, 3.0])) == pytest.approx(
        math.pi / math.sqrt(6.0) * (1.0 + 2.0 + 5.0) / 3.0 / of_gumbel
    )


def test_of_several_indices_of_a_tail_the_variances_are_averaged() -> None:
    values = np.abs(np.random.default_rng(7).standard_t(3.0, 400))
    of_each = [scatter_of_largest(values, index) for index in (0.0, 0.3)]
    assert scatter_of_largest(values, 0.0, 0.3) == pytest.approx(math.hypot(*of_each) / math.sqrt(2.0))
    assert scatter_of_largest(values) == of_each[0] < of_each[1]


def test_the_largest_of_a_heavy_tail_scatters_more() -> None:
    """Pareto's distribution of the index 0.2, whose largest of n behaves as (n / e)^0.2, e exponential."""
    records = np.random.default_rng(6).pareto(5.0, (300, 400))
    stated = np.array([scatter_of_largest(record, 0.2) for record in records])
    assert np.mean(stated) == pytest.approx(float(np.std(records.max(axis=1))), rel=0.25)


def test_the_largest_of_few_scatters_as_they_do_at_least() -> None:
    values = np.array([1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 2.0, 2.0, 2.0, 2.0])
    assert scatter_of_largest(values) >= 0.6 * float(np.std(values, ddof=1))


@pytest.mark.parametrize("periods", [5, 40])
@pytest.mark.parametrize("dof", [3.0, 4.0])
def test_the_largest_of_heavy_samples_scatters_as_stated(dof: float, periods: int) -> None:
    samples = np.random.default_rng(12).standard_t(dof, (120, periods, 400))
    maxima = np.max(samples, axis=2)
    pairs = zip(samples.reshape(120, -1), maxima, strict=True)
    stated = np.array([scatter_in_tail(*each) for each in pairs])
    largest = np.max(maxima, axis=1)
    error = (largest - np.mean(largest)) / stated
    assert 0.6 < np.sqrt(np.mean(error**2)) < 1.4
    assert np.mean(np.abs(error) < 2.0) > 0.9


def test_heavy_samples_beside_the_crests_of_a_ripple_do_not_make_its_largest() -> None:
    deviations = np.random.default_rng(13).standard_t(3.0, 8000)
    assert scatter_in_tail(deviations, np.linspace(1.0, 1.01, 20)) == 0.0
    assert HeavyTail.above(deviations[:300]) is None


def test_the_excess_is_over_the_next_of_half_as_many_again_as_the_root_of_the_values() -> None:
    values = np.random.default_rng(5).exponential(1.0, 100)
    of_gumbel, ordered = -np.log(-np.log((np.arange(84, 100) + 0.5) / 100)), np.sort(values)
    excess = float(np.mean(ordered[-15:]) - ordered[-16]) / float(np.mean(of_gumbel[1:]) - of_gumbel[0])
    assert scatter_of_largest(values) == pytest.approx(math.pi / math.sqrt(6.0) * excess)


def test_of_four_that_are_the_largest_alike_all_of_few_tell() -> None:
    values = np.array([0.0, 0.3, -0.2, 0.1, -0.1, 0.2, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    order = np.random.default_rng(1).permutation(len(values))
    assert scatter_of_largest(values[order]) == pytest.approx(0.6 * float(np.std(values, ddof=1)))


@pytest.mark.parametrize("below", [0.5, 30.0])
def test_values_that_are_held_scatter_as_what_is_above_their_median_does(below: float) -> None:
    values = np.random.default_rng(0).standard_normal(400)
    held = np.repeat(np.where(values > 0.0, values, below * values), 5)
    assert scatter_of_largest(held) == pytest.approx(0.77, abs=0.07)


def test_a_heavy_tail_is_of_a_twentieth_of_the_values_and_of_any_unit() -> None:
    values = np.random.default_rng(4).standard_t(3.0, 8000)
    maxima = np.max(values.reshape(20, 400), axis=1)
    tail, ordered = HeavyTail.above(values), np.sort(values)
    assert tail is not None
    assert tail.count == 400
    assert tail.excess == pytest.approx(float(np.mean(ordered[-400:]) - ordered[-401]))
    assert HeavyTail.above(values[:399]) is None
    assert HeavyTail.above(values[:400]) is not None
    for maxima_of in (maxima, 0.7 * maxima, 0.2 * maxima):
        of_small_unit = scatter_in_tail(1e3 * values, 1e3 * maxima_of)
        assert of_small_unit == pytest.approx(1e3 * tail.scatter_of_largest(maxima_of))
    assert tail.scatter_of_largest(0.2 * maxima) == 0.0 < tail.scatter_of_largest(0.8 * maxima)
    assert scatter_in_tail(values + 50.0, maxima) == pytest.approx(tail.scatter_of_largest(maxima))
