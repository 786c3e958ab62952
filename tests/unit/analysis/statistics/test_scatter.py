"""The error of a mean against the scatter of many means."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from benchmarks.coverage.noise import coloured, fractional
from benchtool.analysis.statistics.scatter import (
    MeanError,
    at_lowest_frequencies,
    error_of_periods,
    error_of_record,
    error_of_root,
    error_of_series,
    is_memory_untold,
    means_of_blocks,
)


@pytest.mark.parametrize("memory", [0.0, 0.9])
def test_it_is_the_scatter_of_the_mean_also_of_correlated_samples(memory: float) -> None:
    records = np.random.default_rng(0).standard_normal((250, 5000))
    records = signal.lfilter([1.0], [1.0, -memory], records, axis=1)
    scatter = float(np.std(np.mean(records, axis=1)))
    stated = np.array([error_of_record(record).standard for record in records])
    assert np.median(stated) == pytest.approx(scatter, rel=0.15)
    # in some of the records a slow drift cannot be excluded, and their mean is known less
    assert np.mean(stated < 2.0 * scatter) > 0.95
    errors = np.mean(records, axis=1) / stated
    assert float(np.sqrt(np.mean(errors**2))) == pytest.approx(0.95, abs=0.1)


def test_a_short_record_has_none() -> None:
    assert math.isnan(error_of_record(np.arange(19.0)).standard)
    assert error_of_record(np.ones(20)).standard == 0.0


def test_a_mean_under_flicker_noise_is_known_less_than_its_parts_say() -> None:
    """Noise of density 1 / f down to a quarter of a cycle in the record, made line by line."""
    random, count = np.random.default_rng(3), 4000
    shape = np.zeros(2 * count + 1)
    shape[1:] = 1.0 / np.sqrt(np.arange(1, 2 * count + 1))
    errors = []
    for _ in range(60):
        phasors = random.standard_normal((2, 2 * count + 1))
        noise = np.fft.irfft(shape * (phasors[0] + 1j * phasors[1]), 4 * count)[:count]
        errors.append(np.mean(noise) / error_of_record(noise).standard)
    assert np.mean(np.abs(errors) < 2.0) >= 0.9
    assert 0.5 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4


@pytest.mark.parametrize("cycles", [17.5, 23.2, 60.4])
def test_the_mean_over_no_whole_cycles_is_as_uncertain_as_where_they_begin(cycles: float) -> None:
    random, turn, means, stated = np.random.default_rng(3), np.arange(1500) / 1500, [], []
    for begin in np.arange(0.05, 1.0, 0.1):
        noise = 1e-3 * random.standard_normal(1500)
        record = np.sin(2.0 * np.pi * (cycles * turn + begin)) + noise
        means.append(np.mean(record))
        stated.append(error_of_record(record).standard)
    scatter = float(np.sqrt(np.mean(np.square(means))))
    assert min(stated) > 0.6 * scatter
    assert np.median(stated) < 2.0 * scatter


def test_the_mean_of_a_trend_is_not_known_to_less_than_the_trend() -> None:
    trend = np.linspace(-1.0, 1.0, 4000) + 1e-3 * np.random.default_rng(4).standard_normal(4000)
    assert not error_of_record(trend).standard < 0.5


@pytest.mark.parametrize("length", [2000.01, 2000.5, 2000.99])
def test_harmonics_of_few_rows_do_not_leak_over_a_part_of_a_row(length: float) -> None:
    """Four periods that end within the last of 2001 rows, without noise."""
    turned = 2.0 * np.pi * 4.0 * np.arange(2001) / length
    ripple = np.cos(3.0 * turned + 1.1) + 2.0 * np.cos(6.0 * turned + 0.3)

    def beside(values: np.ndarray) -> float:
        bins = np.abs(np.fft.rfft(values - np.mean(values))) / len(values)
        return float(np.max(bins[1:4]))

    marks = np.linspace(0.0, length, 5)
    assert beside(means_of_blocks(ripple, marks)) < 0.02 * beside(ripple) < 1e-4


@pytest.mark.parametrize("count", [3000, 40_000])
def test_a_ripple_whose_pace_changes_is_lines_over_its_angle(count: int) -> None:
    """A speed that rises by 8 % over 100 periods, whose ripple leaks into the lowest bins over time."""
    place = np.linspace(0.0, 1.0, count + 1)
    turns = 100.0 * (0.96 * place + 0.04 * place**2)
    ripple = np.diff(np.sin(2.0 * np.pi * turns)) / np.diff(turns)
    marks = np.interp(np.arange(101.0), turns, np.arange(count + 1.0))

    def lowest(values: np.ndarray) -> float:
        return float(np.max(np.abs(np.fft.rfft(values - np.mean(values)))[1:6])) / len(values)

    assert lowest(means_of_blocks(ripple, marks)) < 0.25 * lowest(ripple)


def test_periods_without_an_even_pace_keep_the_mean_of_all_samples() -> None:
    random = np.random.default_rng(5)
    marks = np.concatenate([[0.0], np.sort(random.uniform(0.0, 9000.0, 29)), [9000.0]])
    samples = random.standard_normal(9000)
    values = means_of_blocks(samples, marks)
    width = np.repeat(np.diff(marks), len(values) // 30)
    assert np.sum(values * width) / np.sum(width) == pytest.approx(np.mean(samples), abs=1e-12)


def test_the_mean_of_few_periods_of_white_noise_is_known_by_its_density_too() -> None:
    random = np.random.default_rng(7)
    alone: list[float] = []
    pooled: list[float] = []
    for _ in range(100):
        noise = random.standard_normal(2000)
        by_parts = error_of_series(np.mean(noise.reshape(4, 500), axis=1))
        for found, both in ((alone, False), (pooled, True)):
            error = at_lowest_frequencies(noise, by_parts, _marks(noise, 4), pooled=both)
            found.append(error.standard)
            assert error.standard > 0.0
    truth = 1.0 / np.sqrt(2000.0)
    assert all(of_both <= of_parts for of_both, of_parts in zip(pooled, alone, strict=True))
    assert truth < np.median(pooled) < 0.95 * np.median(alone)


def test_a_mean_under_fractional_noise_and_one_of_levels_is_known_as_stated() -> None:
    """Noise that falls as f^-0.6 goes on below the record, what is another in each of 40 periods does not."""
    random = np.random.default_rng(3)
    for is_fractional in (True, False):
        errors = []
        for _ in range(60):
            samples = (
                fractional(random, 4000) if is_fractional else np.repeat(random.standard_normal(40), 100)
            )
            if not is_fractional:
                samples = samples + 0.3 * random.standard_normal(4000)
            periods = error_of_series(samples.reshape(40, 100).mean(axis=1))
            errors.append(
                np.mean(samples) / at_lowest_frequencies(samples, periods, _marks(samples, 40)).standard
            )
        assert np.mean(np.abs(errors) < 2.0) >= 0.88
        assert 0.6 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4


@pytest.mark.parametrize(("count", "memory"), [(6, 0.9), (12, 0.9), (18, 0.9), (25, 0.9), (12, 0.0)])
def test_few_values_do_not_tell_how_long_they_remember(count: int, memory: float) -> None:
    random = np.random.default_rng(4)
    found = []
    for _ in range(80):
        values = 1.0 + 0.02 * coloured(random.standard_normal(count), memory)
        found.append(is_memory_untold(values, 1e-3 * random.standard_normal(count)))
    assert np.mean(found) > 0.9


def test_neighbours_that_are_unlike_or_enough_values_have_no_untold_memory() -> None:
    random = np.random.default_rng(4)
    alternating = 1.0 + 0.02 * np.tile([1.0, -1.0], 8)
    assert not is_memory_untold(alternating, 1e-3 * random.standard_normal(16))
    found = []
    for _ in range(80):
        values = 1.0 + 0.02 * random.standard_normal(24)
        found.append(is_memory_untold(values, 1e-3 * random.standard_normal(24)))
    assert np.mean(found) < 0.6


def test_what_moves_as_noise_does_or_is_of_many_values_has_no_untold_memory() -> None:
    random = np.random.default_rng(5)
    walk = 1.0 + 0.01 * np.cumsum(random.standard_normal(40))
    assert not is_memory_untold(walk, 1e-4 * random.standard_normal(40))
    noise = 0.02 * random.standard_normal((2, 20))
    assert not is_memory_untold(1.0 + noise[0], noise[1])


def test_a_memory_that_shows_is_continued_rather_than_refused() -> None:
    """The records in which it does not show err more: to refuse the others would leave these."""
    random = np.random.default_rng(6)
    records = [coloured(random.standard_normal(40), 0.95) for _ in range(80)]
    refused = [math.isnan(error_of_series(each).standard) for each in records]
    stated = [error_of_periods(each).standard for each in records]
    assert np.mean(refused) > 0.5
    assert np.mean(np.abs([np.mean(each) for each in records]) < 2.0 * np.array(stated)) >= 0.88


def test_a_budget_says_that_degrees_of_freedom_are_not_of_the_few_values_alone() -> None:
    random, periods = np.random.default_rng(8), 7
    white, walk = random.standard_normal(1680), np.cumsum(random.standard_normal(1680))

    def of(record: NDArray[np.float64], *, pooled: bool = False) -> MeanError:
        by_parts = error_of_series(np.mean(record.reshape(periods, -1), axis=1))
        return at_lowest_frequencies(record, by_parts, _marks(record, periods), pooled=pooled)

    turn = 2.0 * np.pi * np.arange(1680) / 1680
    few, both, more = of(white), of(white, pooled=True), of(walk)
    less = error_of_record(np.sin(11.3 * turn) + 1e-6 * white)
    assert few.line("periods").name == "periods"
    assert few.dof <= periods - 1 < both.dof
    assert both.line("periods").name == "periods, pooled with its density at the lowest frequencies"
    assert more.line("periods").name.endswith("frequencies, continued to zero")
    assert less.line("parts").name == "parts, by its density at the lowest frequencies"


def test_a_density_that_rises_before_it_falls_is_not_continued_by_its_fall() -> None:
    # a resonance four cycles a period fast, in seven periods: far less is at zero than its flanks make of it
    random, periods, count = np.random.default_rng(2), 7, 1680
    turn = 2.0 * np.pi * 4.0 * periods / count
    driven = random.standard_normal((60, count + 2000))
    records = signal.lfilter([1.0], [1.0, -1.99 * np.cos(turn), 0.99], driven, axis=1)[:, 2000:]
    scatter = float(np.std(np.mean(records, axis=1)))
    stated = []
    for record in records:
        by_parts = error_of_series(np.mean(record.reshape(periods, -1), axis=1))
        stated.append(at_lowest_frequencies(record, by_parts, _marks(record, periods)).standard)
    assert 0.8 * scatter < np.median(stated) < 3.0 * scatter


def test_the_mean_under_a_control_with_an_integral_is_known_better_than_the_density_above_says() -> None:
    random, periods, count = np.random.default_rng(6), 20, 2560
    driven = random.standard_normal((60, count + 2000))
    # the integral's corner is two cycles a period fast
    records = signal.lfilter([1.0, -1.0], [1.0, -0.91], driven, axis=1)[:, 2000:]
    scatter = float(np.std(np.mean(records, axis=1)))
    stated: dict[bool, list[float]] = {False: [], True: []}
    for record in records:
        by_parts = error_of_series(np.mean(record.reshape(periods, -1), axis=1))
        for may_fall, found in stated.items():
            found.append(
                at_lowest_frequencies(record, by_parts, _marks(record, periods), may_fall=may_fall).standard
            )
    assert np.median(stated[False]) > 3.0 * scatter
    assert scatter < np.median(stated[True]) < 2.5 * scatter


@pytest.mark.parametrize("count", [6, 40])
def test_the_root_of_few_squares_is_known_as_well_as_other_records_differ(count: int) -> None:
    records = np.random.default_rng(3).gamma(2.0, 0.5, (400, count))
    roots = np.sqrt(np.mean(records, axis=1))
    stated = [error_of_root(each, float(root)).standard for each, root in zip(records, roots, strict=True)]
    errors = (roots - 1.0) / np.array(stated)
    assert 0.75 < float(np.sqrt(np.mean(errors**2))) < 1.15
    assert np.mean(np.abs(errors) < 2.0) > 0.93


def test_a_root_of_squares_that_few_clicks_make_is_as_far_from_the_truth_as_is_stated() -> None:
    """Compound Poisson sums of clicks of normal height, beside a power that is always the same."""
    random, count = np.random.default_rng(8), 40
    clicks = random.poisson(0.5, (600, count))
    squares = 30.0 + random.chisquare(np.maximum(clicks, 1)) * (clicks > 0)
    roots = np.sqrt(np.mean(squares, axis=1))
    stated = [error_of_root(each, float(root)).standard for each, root in zip(squares, roots, strict=True)]
    errors = (roots - math.sqrt(30.5)) / np.array(stated)
    assert float(np.sqrt(np.mean(errors**2))) < 1.25
    assert np.mean(np.abs(errors) < 2.0) > 0.92


def _marks(samples: NDArray[np.float64], periods: int) -> NDArray[np.float64]:
    return np.linspace(0.0, len(samples), periods + 1)


@pytest.mark.parametrize("cycles", [1.6, 3.65, 5.3])
def test_a_slow_swing_is_no_noise_that_rises_towards_zero(cycles: float) -> None:
    """It moves the mean by where it begins, and that is all."""
    random, turn, means, stated = np.random.default_rng(5), np.arange(4000) / 4000, [], []
    for begin in np.arange(0.05, 1.0, 0.1):
        record = np.sin(2.0 * np.pi * (cycles * turn + begin)) + 0.3 * random.standard_normal(4000)
        means.append(np.mean(record))
        stated.append(error_of_record(record).standard)
    scatter = float(np.sqrt(np.mean(np.square(means))))
    assert min(stated) > 0.8 * scatter
    assert max(stated) < 1.4 * scatter
