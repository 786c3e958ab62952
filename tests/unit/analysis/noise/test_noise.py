"""The noise floor against noise of known size, and its uncertainty against what it claims."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.coverage.noise import coloured
from benchtool.analysis import (
    CoherentSamples,
    CoherentSpectrum,
    coherent_spectrum,
    current_spectrum,
    harmonic_noise,
    harmonics,
    noise_floor,
    total_harmonic_distortion,
    track_angle,
)
from benchtool.analysis.coherent.spectrum import spectrum_of as spectrum_of_samples
from benchtool.analysis.noise.noise import (
    MEDIAN_OF_RMS,
    NoiseFloor,
    followed_bins,
    relative_to_found,
    sidebands,
)
from benchtool.analysis.noise.noise_over_time import NoiseOverTime, noise_over_time
from benchtool.analysis.statistics.scatter import MeanError
from benchtool.block import Block, Channel
from tests.unit.analysis.noise.lines_in_noise import RATE_HZ, SIGMA, spectrum_of, spectrum_of_bins

Array = NDArray[np.float64]


@pytest.mark.parametrize("content", [{1: 1.0}, {1: 1.0, 2.5: 0.3, 5: 0.2, 7.1: 0.5, 11: 0.1}])
def test_the_floor_of_white_noise_is_its_density_whatever_lines_there_are(
    content: dict[float, float],
) -> None:
    spectrum = spectrum_of(content, seed=1)

    floor = noise_floor(spectrum)

    assert floor is not None
    # sigma^2 spread over 0 to half the rate; peak amplitude of a bin 1/T wide
    density = SIGMA / math.sqrt(RATE_HZ / 2)
    accuracy = 4 * floor.relative_error
    assert floor.density == pytest.approx(density, rel=accuracy)
    assert floor.amplitude == pytest.approx(2 * SIGMA / math.sqrt(spectrum.samples), rel=accuracy)


def test_what_is_left_of_a_motion_between_low_harmonics_may_be_no_noise() -> None:
    spectrum = spectrum_of({1: 1.0}, seed=2)
    quiet, moved = noise_floor(spectrum), noise_floor(spectrum, has_moved=True)
    assert quiet is not None
    assert moved is not None
    assert moved.relative_error < 1.5 * quiet.relative_error

    low = 5 * spectrum.periods
    left = spectrum.phasor.copy()
    left[:low] *= 10.0
    spread = replace(spectrum, phasor=left, amplitude=np.abs(left))
    moved = noise_floor(spread, has_moved=True)
    assert moved is not None
    # it is, or it is not: the floor is as far from both, and that is its uncertainty
    assert moved.amplitude * (1.0 - moved.of_rest) == pytest.approx(quiet.amplitude, rel=0.02)
    assert moved.amplitude * (1.0 + moved.of_rest) == pytest.approx(moved.highest)
    assert moved.of_rest > 5.0 * quiet.relative_error


def test_noise_that_rises_with_frequency_is_no_rest_of_a_motion() -> None:
    spectrum = spectrum_of({1: 1.0}, seed=2)
    high = 5 * spectrum.periods
    more = spectrum.phasor.copy()
    more[high:] *= 10.0
    risen = replace(spectrum, phasor=more, amplitude=np.abs(more))
    moved, floor = noise_floor(risen, has_moved=True), noise_floor(risen)
    assert moved is not None
    assert floor is not None
    assert moved.amplitude == floor.amplitude
    assert moved.of_rest == 0.0


def test_a_level_has_half_of_the_small_uncertainty_of_its_power() -> None:
    assert relative_to_found(0.008) == 0.004
    assert 0.0075 < relative_to_found(0.015) < 0.00751


@pytest.mark.parametrize("relative", [0.004, 0.1, 0.3])
def test_a_level_that_is_low_by_chance_is_off_by_more_of_itself(relative: float) -> None:
    """Of a mean of n exponentially distributed powers the relative standard deviation is 1 / sqrt(n)."""
    n = 1.0 / relative**2
    power = np.random.default_rng(1).gamma(n, 1.0 / n, 200_000)
    errors = 1.0 - 1.0 / np.sqrt(power)
    assert relative_to_found(relative) == pytest.approx(float(np.sqrt(np.mean(errors**2))), rel=0.02)


def test_the_floor_scatters_by_what_it_says_of_itself() -> None:
    random, floors = np.random.default_rng(3), []
    for _ in range(200):
        noise = random.standard_normal((2, 1800))
        floors.append(noise_floor(spectrum_of_bins(noise[0] + 1j * noise[1], 20)))

    amplitudes = [floor.amplitude for floor in floors if floor is not None]
    assert len(amplitudes) == 200
    claimed = floors[0].relative_error if floors[0] is not None else math.nan
    assert np.std(amplitudes) / np.mean(amplitudes) == pytest.approx(claimed, rel=0.2)


def test_harmonics_and_their_neighbours_are_not_noise() -> None:
    # of the four bins between the harmonics of five periods, the outer two hold what a wobble spreads
    amplitude = np.tile([1.0, 0.3, 0.01, 0.01, 0.3], 20)
    spectrum = CoherentSpectrum(10.0 * np.arange(100.0), amplitude, 5, 1000.0, amplitude + 0j)

    floor = noise_floor(spectrum)

    assert floor is not None
    assert floor.bins == 2 * 20
    # the median of n squares of noise is H_n - H_(n/2) of their mean, for 40 bins in bands of 16 and 24
    assert floor.amplitude == pytest.approx(0.01 / math.sqrt(math.log(2.0)), rel=0.03)
    assert floor.density == pytest.approx(floor.amplitude / math.sqrt(2 * 10.0))


def test_bins_next_to_dc_are_not_noise() -> None:
    """What drifts spreads about dc, as what wobbles does about a harmonic."""
    amplitude = np.full(100, 0.01)
    amplitude[:3] = amplitude[11::12] = amplitude[13::12] = 0.5  # dc, its neighbours, and those of harmonics
    amplitude[12::12] = 1.0
    amplitude[2] = 0.01
    spectrum = CoherentSpectrum(
        10.0 * np.arange(100.0), amplitude, 12, 1000.0, np.asarray(amplitude, dtype=np.complex128)
    )

    floor = noise_floor(spectrum, 0.0, 1.0)

    assert floor is not None
    assert floor.bins == 12 - 3  # 2 to 10
    assert floor.amplitude == pytest.approx(0.01 / math.sqrt(math.log(2.0)), rel=0.05)  # a median of few


def test_the_floor_around_a_harmonic_is_local() -> None:
    generator, samples = np.random.default_rng(4), 40_065
    theta_e = 2 * np.pi * 50.0 * np.arange(samples, dtype=np.float64) / RATE_HZ
    white = generator.normal(0.0, 1.0, samples)
    blue = np.diff(white, prepend=0.0)  # density 2 sin(pi f / rate), so it rises with frequency

    noise = harmonic_noise(
        coherent_spectrum(np.cos(theta_e) + SIGMA * blue, RATE_HZ, track_angle(theta_e, 1)), 50
    )

    expected = math.sqrt(2 / (samples - 65)) * SIGMA * 2 * np.sin(np.pi * np.arange(1, 51) / 200)
    np.testing.assert_allclose(noise[9:], expected[9:], rtol=0.35)
    assert noise[49] / noise[9] == pytest.approx(expected[49] / expected[9], rel=0.3)


def test_too_few_bins_between_harmonics_give_no_floor() -> None:
    theta_e = 2 * np.pi * 1500.0 * np.arange(80, dtype=np.float64) / RATE_HZ

    spectrum = coherent_spectrum(np.cos(theta_e), RATE_HZ, track_angle(theta_e, 1))

    assert spectrum.periods == 2
    assert noise_floor(spectrum) is None
    assert np.all(np.isnan(harmonic_noise(spectrum, 1)))
    assert math.isnan(total_harmonic_distortion(spectrum).standard)
    block = Block((Channel("i_a", "A"),), 0, 1, 1 / RATE_HZ, np.cos(theta_e)[:, np.newaxis])
    found = {each.name: each for each in current_spectrum(block, "i_a", track_angle(theta_e, 1)).measurements}
    for name in ("current_thd_f_groups", "current_thd_f_subgroups"):
        assert math.isnan(found[name].value)
        assert found[name].unit == "%"
        assert "at least 4 and 2 are needed" in found[name].reason


def test_an_amplitude_scatters_by_its_uncertainty() -> None:
    spectra = [spectrum_of({1: 1.0, 5: 0.1}, seed, 4065) for seed in range(200)]

    for order in (1, 5):
        amplitudes = [harmonics(spectrum)[order - 1] for spectrum in spectra]
        claimed = [harmonic_noise(spectrum, 5)[order - 1] for spectrum in spectra]
        assert np.sqrt(np.mean(np.square(claimed))) == pytest.approx(np.std(amplitudes), rel=0.2)


def _spectrum(samples: Array, periods: int) -> CoherentSpectrum:
    return spectrum_of_samples(CoherentSamples(samples, periods, float(len(samples)), 1e4))


def test_the_floor_of_steep_noise_is_its_mean_power_and_not_its_median() -> None:
    generator, count, periods = np.random.default_rng(4), 20_000, 40
    errors = []
    for _ in range(30):
        noise = coloured(generator.standard_normal(count), 0.99)
        spectrum = _spectrum(np.cos(2 * np.pi * periods * np.arange(count) / count) + 0.01 * noise, periods)
        floor = noise_floor(spectrum)
        assert floor is not None
        bins = np.arange(len(spectrum.amplitude))
        inside = bins[(bins % periods >= 2) & (bins % periods <= periods - 2)]
        density = (1 - 0.99**2) / np.abs(1 - 0.99 * np.exp(-2j * np.pi * inside / count)) ** 2
        truth = 0.02 * math.sqrt(float(np.mean(density)) / count)
        errors.append((floor.amplitude / truth - 1.0) / floor.relative_error)
    assert 0.6 < math.sqrt(float(np.mean(np.square(errors)))) < 1.5


@pytest.mark.parametrize(("corner_order", "steepness"), [(0.3, 2.0), (1.0, 2.0), (1.5, 4.0)])
@pytest.mark.parametrize("periods", [3, 8])
def test_the_floor_of_few_periods_is_no_continuation_of_a_slope(
    periods: int, corner_order: float, steepness: float
) -> None:
    """Level up to a corner, where few bins hold most of it."""
    generator, bins = np.random.default_rng(5), np.arange(100 * periods + 1)
    density = 1e-6 / (1.0 + (bins / periods / corner_order) ** steepness)
    guard = 2 if periods >= 4 else 1
    between = (bins % periods >= guard) & (bins % periods <= periods - guard)
    truth, ratios, errors = math.sqrt(float(np.mean(density[between]))), [], []
    for _ in range(60):
        noise = generator.standard_normal((2, len(bins))) * np.sqrt(0.5 * density)
        phasor = noise[0] + 1j * noise[1] + np.where(bins == periods, 5.0, 0.0)
        spectrum = CoherentSpectrum(bins * 50.0 / periods, np.abs(phasor), periods, 1e4, phasor)
        floor = noise_floor(spectrum)
        assert floor is not None
        ratios.append(floor.amplitude / truth)
        errors.append((floor.amplitude - truth) / (floor.amplitude * floor.relative_error))
    assert math.sqrt(float(np.mean(np.square(ratios)))) == pytest.approx(1.0, abs=0.1)
    assert 0.5 < math.sqrt(float(np.mean(np.square(errors)))) < 1.5


def test_what_moves_only_the_phase_of_the_fundamental_is_no_floor() -> None:
    count, periods = 20_000, 40
    noise = 1e-3 * np.random.default_rng(4).standard_normal(count)
    turn = 2 * np.pi * periods * np.arange(count) / count
    wander = 2e-3 * coloured(np.random.default_rng(5).standard_normal(count), 0.9995)
    still, moved = (noise_floor(_spectrum(np.cos(turn + by) + noise, periods)) for by in (0.0, wander))
    assert still is not None
    assert moved is not None
    assert moved.amplitude == pytest.approx(still.amplitude, rel=0.1)


def _of_bins(square: Array, periods: int, seed: int = 0) -> CoherentSpectrum:
    """Return a spectrum, 10 Hz a bin, whose bins have these squares, and phases at random."""
    phasor = np.sqrt(square) * np.exp(2j * np.pi * np.random.default_rng(seed).random(len(square)))
    return spectrum_of_bins(phasor, periods)


def _between(square: Array, periods: int = 20) -> CoherentSpectrum:
    """Return a spectrum with large harmonics, and these squares in turn where a floor is looked for."""
    within = np.arange(2 * len(square) + 2 * periods) % periods
    place = np.flatnonzero((within > 1) & (within < periods - 1))[: len(square)]
    bins = np.where(within == 0, 1e3 * np.max(square), 0.0)[: place[-1] + 1]
    bins[place] = square
    return _of_bins(bins, periods)


def _floor(spectrum: CoherentSpectrum, *orders: float, has_moved: bool = False) -> NoiseFloor:
    found = noise_floor(spectrum, *orders, has_moved=has_moved)
    assert found is not None
    return found


def _median_of(count: int) -> float:
    """Return the mean of the median of so many exponentially distributed values, H_n - H_(n/2)."""
    upper = math.fsum(1.0 / each for each in range(count // 2 + 1, count + 1))
    return upper if count % 2 else upper + 1.0 / count


def _quantiles(count: int, seed: int = 0) -> Array:
    """Return values of an exponential distribution of mean 1, each as likely, in random order."""
    return np.random.default_rng(seed).permutation(-np.log((np.arange(count) + 0.5) / count))


def test_a_floor_may_be_of_either_of_two_levels() -> None:
    """Of 2 with a probability of a quarter, else of 1.2: 1.4 on average, and sqrt(3) / 4 of 0.8 from that."""
    over_time = NoiseOverTime(MeanError(0.2, 7.0), 0.8)
    floor = NoiseFloor(2.0, 10.0, 40, 0.03, 50.0, least=0.6, all_noise=0.25, over_time=over_time)
    assert floor.amplitude == pytest.approx(1.4)
    assert floor.standard == pytest.approx(1.4 / math.sqrt(2.0))
    assert floor.density == pytest.approx(1.4 / math.sqrt(20.0))
    assert floor.of_rest == pytest.approx(math.sqrt(3.0) / 4.0 * 0.8 / 1.4)
    assert floor.relative_error == pytest.approx(math.hypot(0.03, floor.of_rest))
    assert floor.by_time == MeanError(relative_to_found(0.2), 7.0)
    certain = NoiseFloor(2.0, 10.0, 40, 0.03, 50.0)
    assert (certain.amplitude, certain.relative_error, certain.by_time.standard) == (2.0, 0.03, 0.0)


def test_orders_are_whole_and_eight_bins_are_a_floor() -> None:
    """Twelve periods have nine bins between two harmonics, here of a level that is four times that before."""
    order, within = np.divmod(np.arange(60), 12)
    spectrum = _of_bins(np.where((within < 2) | (within > 10), 99.0, 16.0**order), 12)
    for first, last, level in ((1.0, 2.0, 4.0), (2.6, 2.9, 16.0), (4.0, 9.0, 256.0)):
        floor = _floor(spectrum, first, last)
        assert floor.bins == 9
        assert floor.bin_Hz == 10.0
        assert floor.amplitude == pytest.approx(level / math.sqrt(_median_of(9)))
    assert _floor(spectrum, -2.5) == _floor(spectrum)
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
    floor = _floor(_between(1e-6 * np.random.default_rng(3).permutation(square)))
    assert floor.bins == 28
    assert floor.amplitude == pytest.approx(1e-3 * math.sqrt(power))


@pytest.mark.parametrize("lines", [False, True])
@pytest.mark.parametrize("exponent", [-6.0, -2.0, 3.0])
def test_noise_in_proportion_to_a_power_of_frequency_is_its_mean(exponent: float, lines: bool) -> None:
    """In one band, from bin 2 on: lines in four of 26 bins are told from the slope, where they are large."""
    place = np.delete(np.arange(2, 31), [17, 18, 19])  # bins next to the fundamental of 20 periods
    shape = place.astype(np.float64) ** exponent
    square = np.where(np.arange(26) % 7 == 5, 300.0, 1.0) * shape if lines else shape
    floor = _floor(_between(square))
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
    plain, floor = (_floor(_between(each), 1.0) for each in (shape, lined))
    truth = np.mean(shape[place > 20])
    assert plain.amplitude**2 == pytest.approx(truth, rel=0.02)
    assert floor.amplitude**2 == pytest.approx(truth, rel=0.02)


def test_squares_in_random_order_have_no_slope() -> None:
    for seed in range(5):
        square = _quantiles(30, seed)
        power = 0.5 * float(np.sum(np.sort(square)[14:16])) / _median_of(30)
        floor = _floor(_between(square))
        assert floor.amplitude == pytest.approx(math.sqrt(power))
        # a median scatters by 1 / sqrt(n) of that of an exponential, which is ln 2 of its mean
        assert floor.dof == pytest.approx(2.0 * 30 * math.log(2.0) ** 2)


@pytest.mark.parametrize(("low", "high"), [(1.0, 1.0), (4.0, 1.0), (1.0, 4.0), (0.0, 1.0)])
def test_bands_of_sixteen_bins_have_levels_of_their_own(low: float, high: float) -> None:
    """Of forty bins 16 and 24: one level is told by the median, two that do not scatter by the mean."""
    floor = _floor(_between(np.repeat([low, high], [16, 24])), has_moved=True)
    if low in (0.0, high):  # beside a band without anything there is no slope
        low, high = low / _median_of(16), high / _median_of(24)
    total = 0.4 * low + 0.6 * high
    assert floor.highest == pytest.approx(math.sqrt(total))
    assert floor.least == pytest.approx(min(1.0, math.sqrt(high / total)))


@pytest.mark.parametrize("level", [(1.0, 1.0, 8.0), (1.0, 1.0, 1.0, 8.0)])
def test_the_slope_of_a_band_is_that_of_two_to_either_side(level: tuple[float, ...]) -> None:
    """Where it is zero, in the first of four, the median stands for a band, elsewhere the mean."""
    floor = _floor(_between(np.repeat(level, 16)))
    first = level[0] / _median_of(16) if len(level) == 4 else level[0]
    assert floor.amplitude**2 == pytest.approx(np.mean([first, *level[1:]]))


@pytest.mark.parametrize(("order", "is_steep"), [(4, False), (2, True)])
def test_the_median_stands_for_noise_that_hardly_changes_within_a_band(order: int, is_steep: bool) -> None:
    """In two bands of 16 bins the power rises in proportion to frequency: by a third from bin 42 on, and by a
    fifth from bin 82 on."""
    bins = np.arange(140.0)
    between = bins[(bins > 20 * order) & (bins % 20 > 1) & (bins % 20 < 19)][:32]
    floor = _floor(_of_bins(bins[: int(between[-1]) + 1], 20), order)
    powers = [np.median(between[16 * band :][:16]) / _median_of(16) for band in (0, 1)]
    if is_steep:
        powers = [np.mean(between)]
    assert floor.bins == 32
    assert floor.amplitude**2 == pytest.approx(np.mean(powers))


def test_bins_more_than_half_of_which_are_empty_have_no_floor() -> None:
    square = np.where(np.arange(60) % 5 < 2, (1.0 + np.arange(60.0)) ** 4, 0.0)
    for count in (20, 30, 60):
        floor = _floor(_between(square[:count]), has_moved=True)
        assert (floor.amplitude, floor.relative_error, floor.dof) == (0.0, 0.0, math.inf)
        assert (floor.bins, floor.bin_Hz) == (count, 10.0)


def test_seven_bins_that_have_something_tell_no_slope() -> None:
    square = np.append([0.0, 0.0], np.arange(8.0, 1.0, -1.0) ** 2)
    assert _floor(_between(square, 8)).amplitude == pytest.approx(math.sqrt(4.0**2 / _median_of(9)))


def test_all_bins_that_are_neither_harmonics_nor_lines_tell_the_course_of_noise() -> None:
    random = np.random.default_rng(5)
    bins = np.arange(20 * 41 + 1)
    square = np.where(bins % 20 > 0, random.exponential(1.0, len(bins)), 1e4)
    square[[205, 408]] = 100.0  # lines
    square[[239, 361]] = 30.0, 3.0  # beside harmonics
    spectrum = _of_bins(square, 20)
    expected = bins[22:799]
    expected = expected[(expected % 20 > 0) & ~np.isin(expected, [205, 408, 239])]
    floor = _floor(spectrum, 1.0, 40.0)
    assert floor.over_time == noise_over_time(spectrum.phasor, expected)
    assert floor.over_time != NoiseFloor(1.0, 10.0, 40, 0.1, 50.0).over_time


@pytest.mark.parametrize(("order", "reach", "sides"), [(1, 79, 1), (3, 39, 2)])
def test_sidebands_that_only_turn_the_phase_leak_beyond_what_is_seen(
    order: int, reach: int, sides: int
) -> None:
    """Of a power c / d^2 at a distance d: up to half a harmonic away it is no noise, and beyond, where
    it is c / reach to either side, half of it is the error of the amplitude."""
    bins, c, noise = np.arange(80 * 10), 4e-3, 1e-3 * np.exp(0.25j * np.pi)  # as much in phase as across
    floors = []
    for power in (0.0, c):
        phasor = np.where(bins % 80 == 0, 1.0, noise)
        away = np.maximum(np.abs(bins - 80 * order), 1)
        turned = np.sqrt(noise.imag**2 + power / away**2)
        phasor.imag = np.where((phasor.imag > 0.0) & (away <= reach), turned, phasor.imag)
        floors.append(_floor(spectrum_of_bins(phasor, 80)))
    still, moved = floors
    assert moved.amplitude == pytest.approx(still.amplitude, rel=0.01)
    of_leaks = 0.5 * sides * c / reach / (still.amplitude**2 * still.bins)
    assert math.sqrt(moved.of_bins**2 - still.of_bins**2) == pytest.approx(of_leaks, rel=0.05)


def test_the_noise_in_quadrature_that_a_phase_took_along_counts() -> None:
    """Within 16 bins of the fundamental a fifth of the amplitude: twice what is in phase stands for both."""
    bins, noise = np.arange(160), 1e-3 * np.exp(0.25j * np.pi)
    phasor = np.where(bins % 80 == 0, 1.0, noise * 10.0 / (10.0 + np.abs(bins - 80.0)))
    still = spectrum_of_bins(phasor, 80)
    taken = phasor.copy()
    taken.imag[(np.abs(bins - 80) <= 16) & (bins != 80)] *= 0.2
    followed = replace(still, phasor=taken, amplitude=np.abs(taken))
    plain, found = noise_floor(still), noise_floor(followed, follows_signal=True)
    assert plain is not None
    assert found is not None
    assert found.amplitude == pytest.approx(plain.amplitude, rel=1e-9)
    assert found.relative_error == pytest.approx(plain.relative_error, rel=1e-9)
    assert _floor(followed).amplitude < 0.95 * plain.amplitude


@pytest.mark.parametrize(("periods", "reach"), [(12, 2), (13, 1)])
def test_around_a_harmonic_is_as_many_orders_as_hold_twenty_bins(periods: int, reach: int) -> None:
    """So many periods have nine or ten bins between harmonics, here of an amplitude that rises evenly. Beside
    the first and the last harmonics there are fewer, at least eight."""
    place, known = np.arange(periods * 9 + 10.0), 9 + reach
    found = harmonic_noise(_of_bins(place**2, periods), 12)
    place = place[(place % periods > 1) & (place % periods < periods - 1)]
    away = np.abs(place - periods * np.arange(1, known + 1)[:, np.newaxis])
    median = [np.median(place[each < reach * periods]) for each in away]
    assert median[3] == 4 * periods  # by symmetry
    np.testing.assert_allclose(found[:known], np.array(median) / MEDIAN_OF_RMS / math.sqrt(2.0))
    assert np.all(np.isnan(found[known:]))


def test_a_pair_of_sidebands_is_in_phase_or_in_quadrature() -> None:
    """Of 2 (1 + 2 m cos(w t)) cos(t + 0.7) each is m; of a phase that swings by 2 m, j m."""
    for sideband, in_phase, quadrature in ((0.3, 0.36, 0.0), (0.3j, 0.0, 0.36)):
        bins = np.zeros(20, dtype=complex)
        bins[10], bins[13], bins[7] = 2.0, sideband, -np.conj(sideband) if sideband.imag else sideband
        found = sidebands(bins * np.exp(0.7j), 10, 5)
        np.testing.assert_allclose(found[0], [0.0, 0.0, in_phase, 0.0, 0.0], atol=1e-12)
        np.testing.assert_allclose(found[1], [0.0, 0.0, quadrature, 0.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    ("kept", "bins"),
    [
        ([0.1] * 16 + [1.0] * 24, 16),  # of five parts of eight the third has as much in quadrature
        ([0.1] * 16 + [0.55] * 8 + [1.0] * 16, 16),
        ([0.1] * 16 + [0.5] * 8 + [1.0] * 16, 16),
        ([0.1] * 16 + [0.45] * 8 + [1.0] * 16, 24),
        ([0.1] * 43, 40),  # none: all whole parts
        ([0.2] * 40, 0),  # a sixth may be chance
        ([0.15] * 8 + [1.0] * 8, 8),
        ([0.0] * 7, 0),
    ],
)
def test_a_phase_took_the_noise_in_quadrature_along_up_to_where_half_is_there(
    kept: list[float], bins: int
) -> None:
    assert followed_bins(np.full(len(kept), 3.0), 3.0 * np.array(kept)) == bins


def test_eight_bins_are_held_against_those_that_they_are_in_quadrature_to() -> None:
    rises, falls = np.repeat([1.0, 10.0], 8), np.repeat([10.0, 1.0], 8)
    assert followed_bins(rises, np.repeat([0.2, 10.0], 8)) == 0
    assert followed_bins(falls, np.ones(16)) == 8
