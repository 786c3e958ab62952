"""The noise floor of bins whose squares are given: medians, slopes and levels of its bands."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import (
    CoherentSpectrum,
    noise_floor,
)
from benchtool.analysis.noise.noise import (
    NoiseFloor,
    relative_to_found,
)
from benchtool.analysis.noise.noise_over_time import noise_over_time
from tests.unit.analysis.noise.lines_in_noise import (
    floor_of,
    of_bins,
)

Array = NDArray[np.float64]


def _between(square: Array, periods: int = 20) -> CoherentSpectrum:
    """Return a spectrum with large harmonics, and these squares in turn where a floor is looked for."""
    within = np.arange(2 * len(square) + 2 * periods) % periods
    place = np.flatnonzero((within > 1) & (within < periods - 1))[: len(square)]
    bins = np.where(within == 0, 1e3 * np.max(square), 0.0)[: place[-1] + 1]
    bins[place] = square
    return of_bins(bins, periods)


def _median_of(count: int) -> float:
    """Return the mean of the median of so many exponentially distributed values, H_n - H_(n/2)."""
    upper = math.fsum(1.0 / each for each in range(count // 2 + 1, count + 1))
    return upper if count % 2 else upper + 1.0 / count


def _quantiles(count: int, seed: int = 0) -> Array:
    """Return values of an exponential distribution of mean 1, each as likely, in random order."""
    return np.random.default_rng(seed).permutation(-np.log((np.arange(count) + 0.5) / count))


def test_orders_are_whole_and_eight_bins_are_a_floor() -> None:
    """Twelve periods have nine bins between two harmonics, here of a level that is four times that before."""
    order, within = np.divmod(np.arange(60), 12)
    spectrum = of_bins(np.where((within < 2) | (within > 10), 99.0, 16.0**order), 12)
    for first, last, level in ((1.0, 2.0, 4.0), (2.6, 2.9, 16.0), (4.0, 9.0, 256.0)):
        floor = floor_of(spectrum, first, last)
        assert floor.bins == 9
        assert floor.bin_Hz == 10.0
        assert floor.amplitude == pytest.approx(level / math.sqrt(_median_of(9)))
    assert floor_of(spectrum, -2.5) == floor_of(spectrum)
    for size, is_floor in ((48 + 10, True), (48 + 9, False)):
        short = replace(spectrum, amplitude=spectrum.amplitude[:size], phasor=spectrum.phasor[:size])
        assert (noise_floor(short, 4.0) is not None) is is_floor


@pytest.mark.parametrize(("line", "is_line"), [(6.0, False), (14.0, True)])
def test_lines_are_left_out_of_the_median(line: float, is_line: bool) -> None:
    """Of 28 bins five have lines: the median is between the 14th and 15th of all, or the 12th of the rest."""
    square = np.sort(_quantiles(28))
    power = 0.5 * (square[13] + square[14]) / _median_of(28)
    square[-5:] = line * power
    power = square[11] / _median_of(23) if is_line else power
    floor = floor_of(_between(1e-6 * np.random.default_rng(3).permutation(square)))
    assert floor.bins == 28
    assert floor.amplitude == pytest.approx(1e-3 * math.sqrt(power))


@pytest.mark.parametrize("lines", [False, True])
@pytest.mark.parametrize("exponent", [-6.0, -2.0, 3.0])
def test_noise_in_proportion_to_a_power_of_frequency_is_its_mean(exponent: float, lines: bool) -> None:
    """In one band, from bin 2 on: lines in four of 26 bins are told from the slope, where they are large."""
    place = np.delete(np.arange(2, 31), [17, 18, 19])  # bins next to the fundamental of 20 periods
    shape = place.astype(np.float64) ** exponent
    square = np.where(np.arange(26) % 7 == 5, 300.0, 1.0) * shape if lines else shape
    floor = floor_of(_between(square))
    assert floor.bins == 26
    assert floor.amplitude**2 == pytest.approx(np.mean(shape), rel=1e-9 if not lines else 0.3)
    if lines:
        return
    # half of as many squares as hold most of the power, and of twice that, as these do not scatter
    of_shape = max(1.5, np.sum(shape) ** 2 / float(shape @ shape))
    alike = max(1.5, 2.0 * np.sum(shape) ** 2 / float(shape @ shape) - 1.0)
    assert 2.0 / floor.dof == pytest.approx(0.5 / alike + 0.5 / of_shape)
    assert floor.of_bins == pytest.approx(relative_to_found(math.sqrt(2.0 / floor.dof)))


@pytest.mark.parametrize("exponent", [-3.0, 8.0])
def test_bands_of_a_slope_go_by_those_around(exponent: float) -> None:
    """Lines of a thousand times the noise are in one of ten bins."""
    place = np.arange(340)
    place = place[(place % 20 > 1) & (place % 20 < 19)]
    shape = place.astype(np.float64) ** exponent
    lined = np.where(np.arange(len(place)) % 10 == 6, 1e3, 1.0) * shape
    plain, floor = (floor_of(_between(each), 1.0) for each in (shape, lined))
    truth = np.mean(shape[place > 20])
    assert plain.amplitude**2 == pytest.approx(truth, rel=0.02)
    assert floor.amplitude**2 == pytest.approx(truth, rel=0.02)


def test_squares_in_random_order_have_no_slope() -> None:
    for seed in range(5):
        square = _quantiles(30, seed)
        power = 0.5 * float(np.sum(np.sort(square)[14:16])) / _median_of(30)
        floor = floor_of(_between(square))
        assert floor.amplitude == pytest.approx(math.sqrt(power))
        # a median scatters by 1 / sqrt(n) of that of an exponential, which is ln 2 of its mean
        assert floor.dof == pytest.approx(2.0 * 30 * math.log(2.0) ** 2)


@pytest.mark.parametrize(("low", "high"), [(1.0, 1.0), (4.0, 1.0), (1.0, 4.0), (0.0, 1.0)])
def test_bands_of_sixteen_bins_have_levels_of_their_own(low: float, high: float) -> None:
    """Of forty bins 16 and 24: one level is told by the median, two that do not scatter by the mean."""
    floor = floor_of(_between(np.repeat([low, high], [16, 24])), has_moved=True)
    if low in (0.0, high):  # beside a band without anything there is no slope
        low, high = low / _median_of(16), high / _median_of(24)
    total = 0.4 * low + 0.6 * high
    assert floor.highest == pytest.approx(math.sqrt(total))
    assert floor.least == pytest.approx(min(1.0, math.sqrt(high / total)))


@pytest.mark.parametrize("level", [(1.0, 1.0, 8.0), (1.0, 1.0, 1.0, 8.0)])
def test_the_slope_of_a_band_is_that_of_two_to_either_side(level: tuple[float, ...]) -> None:
    """Where it is zero, in the first of four, the median stands for a band, elsewhere the mean."""
    floor = floor_of(_between(np.repeat(level, 16)))
    first = level[0] / _median_of(16) if len(level) == 4 else level[0]
    assert floor.amplitude**2 == pytest.approx(np.mean([first, *level[1:]]))


@pytest.mark.parametrize(("order", "is_steep"), [(4, False), (2, True)])
def test_the_median_stands_for_noise_that_hardly_changes_within_a_band(order: int, is_steep: bool) -> None:
    """In two bands of 16 bins the power rises in proportion to frequency: by a third from bin 42 on, and by a
    fifth from bin 82 on."""
    bins = np.arange(140.0)
    between = bins[(bins > 20 * order) & (bins % 20 > 1) & (bins % 20 < 19)][:32]
    floor = floor_of(of_bins(bins[: int(between[-1]) + 1], 20), order)
    powers = [np.median(between[16 * band :][:16]) / _median_of(16) for band in (0, 1)]
    if is_steep:
        powers = [np.mean(between)]
    assert floor.bins == 32
    assert floor.amplitude**2 == pytest.approx(np.mean(powers))


def test_bins_more_than_half_of_which_are_empty_have_no_floor() -> None:
    square = np.where(np.arange(60) % 5 < 2, (1.0 + np.arange(60.0)) ** 4, 0.0)
    for count in (20, 30, 60):
        floor = floor_of(_between(square[:count]), has_moved=True)
        assert (floor.amplitude, floor.relative_error, floor.dof) == (0.0, 0.0, math.inf)
        assert (floor.bins, floor.bin_Hz) == (count, 10.0)


def test_seven_bins_that_have_something_tell_no_slope() -> None:
    square = np.append([0.0, 0.0], np.arange(8.0, 1.0, -1.0) ** 2)
    assert floor_of(_between(square, 8)).amplitude == pytest.approx(math.sqrt(4.0**2 / _median_of(9)))


def test_all_bins_that_are_neither_harmonics_nor_lines_tell_the_course_of_noise() -> None:
    random = np.random.default_rng(5)
    bins = np.arange(20 * 41 + 1)
    square = np.where(bins % 20 > 0, random.exponential(1.0, len(bins)), 1e4)
    square[[205, 408]] = 100.0  # lines
    square[[239, 361]] = 30.0, 3.0  # beside harmonics
    spectrum = of_bins(square, 20)
    expected = bins[22:799]
    expected = expected[(expected % 20 > 0) & ~np.isin(expected, [205, 408, 239])]
    floor = floor_of(spectrum, 1.0, 40.0)
    assert floor.over_time == noise_over_time(spectrum.phasor, expected)
    assert floor.over_time != NoiseFloor(1.0, 10.0, 40, 0.1, 50.0).over_time
