"""Errors of means by their formulas: degrees of freedom, limits and what falls back to what."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.coverage.noise import coloured
from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.statistics.scatter import (
    Basis,
    MeanError,
    at_lowest_frequencies,
    error_of_periods,
    error_of_record,
    error_of_root,
    error_of_series,
    is_memory_untold,
    mean_of_periods,
    without_oscillations,
)


def even(samples: np.ndarray, periods: int) -> np.ndarray:
    return np.linspace(0.0, len(samples), periods + 1)


def test_a_line_of_a_budget_has_the_mean_once_unless_it_says_how_often() -> None:
    error = MeanError(0.3, 7.0)
    assert (error.line("a").standard, error.line("a", 2.0).standard) == (0.3, 0.6)
    assert error.line("a").dof == 7.0


def test_two_values_tell_no_scatter_and_equal_ones_have_that_of_their_rounding() -> None:
    assert math.isnan(error_of_series(np.array([1.0, 2.0])).standard)
    assert math.isfinite(error_of_series(np.array([1.0, 2.0, 0.5])).standard)
    rounded = 1e6 + 1e-7 * np.array([0.0, 1.0, 0.0, 1.0])
    found = error_of_series(rounded)
    assert found.dof == math.inf
    assert found.standard == pytest.approx(float(np.std(rounded)))


def test_a_series_that_wanders_all_over_has_no_error_and_at_least_one_degree_of_freedom() -> None:
    found = error_of_series(np.linspace(0.0, 1.0, 12))
    assert math.isnan(found.standard)
    assert found.dof >= 1.0


@pytest.mark.parametrize("seed", range(6))
def test_neighbours_alike_count_as_a_gauss_markov_sequence_does_without_its_bias(seed: int) -> None:
    """Kendall: the correlation r of n neighbours is too small by (1 + 3 r) / n."""
    values = coloured(np.random.default_rng(seed).standard_normal(160), 0.6)[100:]
    about, count = values - np.mean(values), len(values)
    square = float(about @ about) / count
    r = float(about[1:] @ about[:-1]) / count / square
    memory = r + (1.0 + 3.0 * r) / count
    tau = (1.0 + memory) / (1.0 - memory)
    found = error_of_series(values)
    least = math.sqrt(square * tau / (count - tau))
    assert math.isnan(found.standard) or found.standard > 0.999 * least
    assert r > 0.25


def test_the_error_of_a_root_grows_by_the_skewness_that_its_deviation_has_at_least() -> None:
    squares, error = np.array([0.5, 1.5] * 8), MeanError(0.1, 15.0)
    expected = 0.1 / 2.0 * (1.0 + 0.5 * (2.0 * 0.5 / 1.0) * (0.1 / students_deviation(15.0) / 0.5))
    assert error_of_root(squares, 1.0, error).standard == pytest.approx(expected)
    assert error_of_root(squares, 0.0, error).standard == 0.0


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_values_that_deviate_by_more_than_a_thousandth_may_have_a_memory(sign: float) -> None:
    course = np.sin(np.linspace(0.0, 6.0, 20))
    course *= 1.0 / float(np.std(course))
    noise = 1e-6 * np.random.default_rng(1).standard_normal(20)
    assert is_memory_untold(sign * (1.0 + 1.5e-3 * course), noise)
    assert not is_memory_untold(sign * (1.0 + 0.7e-3 * course), noise)


def test_fewer_values_than_tell_a_memory_have_an_untold_one_unless_neighbours_are_clearly_unlike() -> None:
    noise = 1e-6 * np.random.default_rng(1).standard_normal(20)
    unlike = 1.0 + 0.01 * np.array([1.0, -0.5, -0.9, 1.1, 0.3, -0.8, 1.0, -0.2, -0.9, 1.0] * 2)
    assert not is_memory_untold(unlike, noise, fewest=20)
    assert is_memory_untold(unlike, noise, fewest=21)


def test_an_oscillation_that_the_parts_cut_is_known_by_ten_degrees_of_freedom() -> None:
    random = np.random.default_rng(3)
    alternating = np.resize([1.0, -1.0], 25) + 1e-3 * random.standard_normal(25)
    found = without_oscillations(alternating, MeanError(0.5, 9.0))
    assert (found.basis, found.dof) == (Basis.LOWEST, 10.0)
    bins = np.abs(np.fft.rfft(alternating - np.mean(alternating))[1:6]) / 25
    assert found.standard == pytest.approx(float(np.sqrt(np.mean(bins**2))) * students_deviation(10.0))
    assert without_oscillations(alternating[:24], MeanError(0.5, 9.0)).basis is Basis.SCATTER
    for begin in np.arange(0.05, 1.0, 0.1):
        line = np.sin(2.0 * np.pi * (60.4 * np.arange(1500) / 1500 + begin))
        assert error_of_record(line + 1e-3 * random.standard_normal(1500)).dof == 10.0


def test_both_are_pooled_by_their_degrees_of_freedom() -> None:
    random, found = np.random.default_rng(8), []
    for _ in range(20):
        record = random.standard_normal(1680)
        by_parts = error_of_series(np.mean(record.reshape(7, -1), axis=1))
        error = at_lowest_frequencies(record, by_parts, even(record, 7), pooled=True)
        found.append((error.basis, error.dof - by_parts.dof))
    assert found.count((Basis.POOLED, 10.0)) > 5
    assert {dof for basis, dof in found if basis is Basis.POOLED} == {10.0}


def test_a_density_that_falls_towards_zero_is_not_continued_upwards() -> None:
    random, number = np.random.default_rng(4), np.arange(1, 2001)
    bins = np.minimum(number / 40.0, 1.0) * np.exp(2j * np.pi * random.random(2000))
    record = np.fft.irfft(np.concatenate([[0.0], bins]), 4000)
    by_parts = MeanError(1e-9, 30.0)
    found = at_lowest_frequencies(record, by_parts, even(record, 100))
    lowest = float(np.sqrt(np.mean((number[:5] / 40.0) ** 2))) / 4000
    assert (found.basis, found.dof) == (Basis.LOWEST, 10.0)
    assert found.standard == pytest.approx(lowest * students_deviation(10.0), rel=1e-6)
    held = at_lowest_frequencies(record, by_parts, even(record, 100), may_fall=True)
    assert 0.0 < held.standard <= found.standard
    by_less = at_lowest_frequencies(np.tile(record[:40], 100), MeanError(1e-12, 30.0), may_fall=True)
    assert math.isfinite(by_less.standard)


def test_where_a_control_may_hold_the_mean_the_error_is_never_more_than_without() -> None:
    random = np.random.default_rng(5)
    for record in (random.standard_normal(2560), np.cumsum(random.standard_normal(2560))):
        by_parts = error_of_series(np.mean(record.reshape(20, -1), axis=1))
        alone, held = (
            at_lowest_frequencies(record, by_parts, even(record, 20), may_fall=each) for each in (False, True)
        )
        assert held.standard <= alone.standard or math.isnan(alone.standard)


def test_the_mean_of_periods_is_that_about_a_slow_swing_and_else_their_mean() -> None:
    noise = 1e-3 * np.random.default_rng(7).standard_normal(60)
    mean, error = mean_of_periods(5.0 + noise)
    assert mean == pytest.approx(5.0 + float(np.mean(noise)), abs=1e-12)
    assert error == error_of_periods(5.0 + noise)
    swing = np.sin(2.0 * np.pi * 2.4 * (np.arange(60) + 0.5) / 60)
    about, of_rest = mean_of_periods(5.0 + noise + 0.1 * swing)
    assert abs(about - 5.0) < 1e-3 < abs(float(np.mean(0.1 * swing)))
    assert of_rest.standard < 4.0 * error.standard


def test_a_record_of_rounding_alone_has_the_error_of_its_parts() -> None:
    record = 1e6 + 1e-10 * np.round(np.random.default_rng(6).standard_normal(4000))
    by_parts = MeanError(1e-14, 9.0)
    assert at_lowest_frequencies(record, by_parts) == by_parts


def test_errors_of_few_values_are_compared_and_pooled_without_what_their_number_adds() -> None:
    few, many = MeanError.of_scatter(0.1, 4.0, Basis.LOWEST), MeanError.of_scatter(0.1, 40.0)

    assert few.standard == pytest.approx(0.1 * math.sqrt(4.0 / 2.0))
    assert few.experimental == pytest.approx(0.1)
    # two estimates of one variance that are alike: as likely above as below, but for the skewness of F
    assert few.exceeds_by_chance(many) == pytest.approx(0.4189, abs=1e-4)
    assert few.exceeds_by_chance(MeanError(0.0, 40.0)) == 0.0
    assert MeanError.of_scatter(0.2, 4.0).exceeds_by_chance(many) == pytest.approx(0.00802, abs=1e-5)

    both = few.pooled(MeanError.of_scatter(0.2, 12.0))
    assert both.experimental == pytest.approx(math.sqrt((4.0 * 0.01 + 12.0 * 0.04) / 16.0))
    assert both.dof == 16.0
    assert both.basis is Basis.LOWEST


def test_a_scatter_is_pooled_with_the_noise_that_explains_it() -> None:
    noise = MeanError.of_scatter(0.1, 20.0)
    alike, more = MeanError.of_scatter(0.12, 3.0), MeanError.of_scatter(0.3, 3.0)
    assert alike.pooled_with_noise(noise) == alike.pooled(noise)
    assert more.pooled_with_noise(noise) is more
    known = MeanError.of_scatter(0.1, math.inf)
    assert alike.pooled_with_noise(known) is known
