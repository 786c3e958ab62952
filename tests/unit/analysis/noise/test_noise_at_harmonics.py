"""The noise around harmonics, and beside a fundamental whose phase is followed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from benchtool.analysis import (
    coherent_spectrum,
    harmonic_noise,
    harmonics,
    noise_floor,
    track_angle,
)
from benchtool.analysis.noise.noise import followed_bins, sidebands
from benchtool.analysis.statistics.medians import MEDIAN_OF_RMS
from tests.unit.analysis.noise.lines_in_noise import (
    RATE_HZ,
    SIGMA,
    floor_of,
    of_bins,
    spectrum_of,
    spectrum_of_bins,
)


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


def test_an_amplitude_scatters_by_its_uncertainty() -> None:
    spectra = [spectrum_of({1: 1.0, 5: 0.1}, seed, 4065) for seed in range(200)]

    for order in (1, 5):
        amplitudes = [harmonics(spectrum)[order - 1] for spectrum in spectra]
        claimed = [harmonic_noise(spectrum, 5)[order - 1] for spectrum in spectra]
        assert np.sqrt(np.mean(np.square(claimed))) == pytest.approx(np.std(amplitudes), rel=0.2)


@pytest.mark.parametrize(("order", "reach", "sides"), [(1, 79, 1), (3, 39, 2)])
def test_sidebands_that_only_turn_the_phase_leak_beyond_what_is_seen(
    order: int, reach: int, sides: int
) -> None:
    """Of a power c / d^2 at a distance d: up to half a harmonic away it is no noise, and beyond, where
    it is c / reach to either side, half of it is the error of the amplitude."""
    bins, c, noise = np.arange(80 * 10), 4e-3, 1e-3 * np.exp(0.25j * np.pi)  # as much in phase as across
    # of noise at all places of the period no two orders are alike, but for those beside the line
    signs = np.random.default_rng(0).choice((-1.0, 1.0), (10, 80))
    signs[order, 1:] = signs[order - 1, :0:-1]
    noise = noise * signs.ravel()
    floors = []
    for power in (0.0, c):
        phasor = np.where(bins % 80 == 0, 1.0, noise)
        away = np.maximum(np.abs(bins - 80 * order), 1)
        turned = np.sqrt(noise.imag**2 + power / away**2)
        to_turn = (phasor.imag != 0.0) & (away <= reach)
        phasor.imag = np.where(to_turn, np.copysign(turned, phasor.imag), phasor.imag)
        floors.append(floor_of(spectrum_of_bins(phasor, 80)))
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
    assert floor_of(followed).amplitude < 0.95 * plain.amplitude


@pytest.mark.parametrize(("periods", "reach"), [(12, 2), (13, 1)])
def test_around_a_harmonic_is_as_many_orders_as_hold_twenty_bins(periods: int, reach: int) -> None:
    """So many periods have nine or ten bins between harmonics, here of an amplitude that rises evenly. Beside
    the first and the last harmonics there are fewer, at least eight."""
    place, known = np.arange(periods * 9 + 10.0), 9 + reach
    found = harmonic_noise(of_bins(place**2, periods), 12)
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
