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
    noise_floor,
    total_harmonic_distortion,
    track_angle,
)
from benchtool.analysis.coherent.spectrum import spectrum_of as spectrum_of_samples
from benchtool.analysis.noise.noise import (
    NoiseFloor,
    relative_to_found,
)
from benchtool.analysis.noise.noise_over_time import NoiseOverTime
from benchtool.analysis.statistics.scatter import MeanError
from benchtool.block import Block, Channel
from tests.unit.analysis.noise.lines_in_noise import (
    RATE_HZ,
    SIGMA,
    spectrum_of,
    spectrum_of_bins,
)

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
