"""Distortion in its definitions: closed forms, a fit as a second way, and what must not change it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from benchtool.analysis import (
    CoherentSpectrum,
    Reference,
    coherent_spectrum,
    distortion_and_noise,
    harmonics,
    relative_phase_rad,
    total_harmonic_distortion,
    track_angle,
)
from benchtool.analysis.measurement import Basis
from benchtool.analysis.spectra.harmonics import harmonic_table

RATE_HZ = 10e3
Array = NDArray[np.float64]

contents = st.lists(st.floats(0.0, 0.3), min_size=6, max_size=6)


def rotation(samples: int, frequency_Hz: float = 40.7, begin_rad: float = 0.0) -> Array:
    theta_e: Array = begin_rad + 2 * np.pi * frequency_Hz * np.arange(samples, dtype=np.float64) / RATE_HZ
    return theta_e


def wave(theta_e: Array, amplitudes: list[float], phases: Array) -> Array:
    """Harmonics 2, 3 ... of these amplitudes and phases beside a fundamental of 1."""
    orders = np.arange(1, len(amplitudes) + 2)
    parts = np.array([1.0, *amplitudes]) * np.cos(np.outer(theta_e, orders) + phases[: len(orders)])
    total: Array = np.sum(parts, axis=1)
    return total


def spectrum_of(samples: Array, theta_e: Array) -> CoherentSpectrum:
    return coherent_spectrum(samples, RATE_HZ, track_angle(theta_e, 1))


def fitted(samples: Array, theta_e: Array, count: int) -> tuple[Array, Array]:
    """Amplitude and phase (as cosines) of harmonics 1 to `count` by least squares, without any DFT."""
    orders = np.arange(1, count + 1)
    cosines, sines = np.cos(np.outer(theta_e, orders)), np.sin(np.outer(theta_e, orders))
    basis = np.hstack([cosines, sines, np.ones((len(samples), 1))])
    solution = np.linalg.lstsq(basis, samples, rcond=None)[0]
    phasor = solution[:count] - 1j * solution[count : 2 * count]
    return np.abs(phasor), np.angle(phasor)


@settings(max_examples=25, deadline=None)
@given(contents, st.integers(0, 2**31))
def test_dft_and_least_squares_agree_in_amplitude_phase_and_distortion(
    amplitudes: list[float], seed: int
) -> None:
    generator = np.random.default_rng(seed)
    theta_e = rotation(3000, 40.7 + generator.uniform(-5, 5), generator.uniform(0, 6))
    samples = wave(theta_e, amplitudes, generator.uniform(-3, 3, 7)) + generator.normal(0, 1e-5, 3000)

    spectrum = spectrum_of(samples, theta_e)
    amplitude, phase = fitted(samples, theta_e, 7)

    np.testing.assert_allclose(harmonics(spectrum)[:7], amplitude, atol=1e-4)
    relative = phase - np.arange(1, 8) * phase[0]
    turned = np.exp(1j * (relative_phase_rad(spectrum)[:7] - relative))
    np.testing.assert_allclose((turned - 1.0) * amplitude, 0.0, atol=2e-4)
    expected = np.linalg.norm(amplitude[1:]) / amplitude[0]
    assert total_harmonic_distortion(spectrum, 7).ratio == pytest.approx(expected, abs=1e-4)


def test_the_three_references_of_a_square_wave() -> None:
    theta_e = rotation(6000)
    odd = np.arange(1, 50, 2)
    samples = np.sum(np.sin(np.outer(theta_e, odd)) / odd, axis=1)
    content = math.sqrt(np.sum(1.0 / odd[1:] ** 2))

    spectrum = spectrum_of(samples, theta_e)

    assert total_harmonic_distortion(spectrum).ratio == pytest.approx(content, rel=1e-3)
    of_total = total_harmonic_distortion(spectrum, reference=Reference.TOTAL)
    assert of_total.ratio == pytest.approx(content / math.hypot(1.0, content), rel=1e-3)
    of_stated = total_harmonic_distortion(spectrum, reference=Reference.STATED, stated_amplitude=4.0)
    assert of_stated.ratio == pytest.approx(content / 4.0, rel=1e-3)
    few = total_harmonic_distortion(spectrum, highest_harmonic=4)
    assert few.highest_harmonic == 4
    assert few.ratio == pytest.approx(1 / 3, rel=1e-3)


def test_a_stated_reference_needs_its_amplitude_and_zero_gives_nothing() -> None:
    spectrum = spectrum_of(np.cos(rotation(3000)), rotation(3000))

    with pytest.raises(ValueError, match="needs its amplitude"):
        total_harmonic_distortion(spectrum, reference=Reference.STATED)
    assert math.isnan(
        total_harmonic_distortion(spectrum, reference=Reference.STATED, stated_amplitude=0.0).ratio
    )


def test_distortion_and_noise_counts_what_lies_between_the_harmonics() -> None:
    theta_e = rotation(40_065, 50.0)
    noise = np.random.default_rng(2).normal(0.0, 0.02, len(theta_e))
    samples = np.cos(theta_e) + 0.05 * np.cos(3 * theta_e) + 0.04 * np.cos(3.5 * theta_e) + noise + 7.0

    spectrum = spectrum_of(samples, theta_e)

    # noise up to 0.45 of the rate, of 0.5
    power = 0.05**2 / 2 + 0.04**2 / 2 + 0.02**2 * 0.9
    assert distortion_and_noise(spectrum) == pytest.approx(math.sqrt(2 * power), rel=0.02)
    assert total_harmonic_distortion(spectrum).ratio == pytest.approx(0.05, rel=0.02)


@settings(max_examples=25, deadline=None)
@given(contents, st.floats(1e-3, 1e3), st.floats(-5.0, 5.0), st.integers(0, 2**31))
def test_scale_and_dc_leave_the_distortion_and_the_phases(
    amplitudes: list[float], scale: float, dc: float, seed: int
) -> None:
    theta_e = rotation(2500)
    samples = wave(theta_e, amplitudes, np.random.default_rng(seed).uniform(-3, 3, 7))

    one = spectrum_of(samples, theta_e)
    other = spectrum_of(scale * (samples + dc), theta_e)

    np.testing.assert_allclose(harmonics(other)[:7], scale * harmonics(one)[:7], atol=2e-5 * scale)
    for reference in (Reference.FUNDAMENTAL, Reference.TOTAL):
        assert total_harmonic_distortion(other, reference=reference).ratio == pytest.approx(
            total_harmonic_distortion(one, reference=reference).ratio, abs=2e-5
        )
    assert distortion_and_noise(other) == pytest.approx(distortion_and_noise(one), abs=2e-5)


@settings(max_examples=25, deadline=None)
@given(contents, st.floats(0.0, 6.28), st.integers(0, 2**31))
def test_where_the_record_begins_does_not_matter(
    amplitudes: list[float], begin_rad: float, seed: int
) -> None:
    phases = np.random.default_rng(seed).uniform(-3, 3, 7)
    early, late = rotation(2500), rotation(2500, begin_rad=begin_rad)

    one = spectrum_of(wave(early, amplitudes, phases), early)
    other = spectrum_of(wave(late, amplitudes, phases), late)

    np.testing.assert_allclose(harmonics(other)[:7], harmonics(one)[:7], atol=2e-5)
    turned = np.exp(1j * (relative_phase_rad(other) - relative_phase_rad(one)))[:7]
    np.testing.assert_allclose((turned - 1.0) * harmonics(one)[:7], 0.0, atol=2e-4)
    assert total_harmonic_distortion(other).ratio == pytest.approx(
        total_harmonic_distortion(one).ratio, abs=2e-5
    )


def test_a_phase_is_that_of_the_cosine_when_the_fundamental_peaks() -> None:
    theta_e = rotation(3000, begin_rad=1.234)
    samples = np.cos(theta_e - 0.5) + 0.1 * np.cos(3 * (theta_e - 0.5) + 0.7)

    phase_rad = relative_phase_rad(spectrum_of(samples, theta_e))

    assert phase_rad[0] == pytest.approx(0.0, abs=1e-12)
    assert phase_rad[2] == pytest.approx(0.7, abs=1e-3)
    assert np.all((phase_rad > -np.pi) & (phase_rad <= np.pi))


def test_the_table_of_lines_that_are_none_holds_zero() -> None:
    """Noise alone has Rayleigh's distribution, of which twice the component's deviation holds 86 %."""
    random, held = np.random.default_rng(11), []
    phase = rotation(10_000)
    track = track_angle(phase, 1)
    for _ in range(30):
        current = np.cos(phase) + 1e-2 * random.standard_normal(len(phase))
        table = harmonic_table(coherent_spectrum(current, RATE_HZ, track), "lines", "i_a", "A", Basis())
        held += [row[2] <= 2.0 * row[5] for row in table.rows[1:]]
    assert 0.93 < np.mean(held) < 0.98


def test_the_noise_of_many_equal_lines_counts_once() -> None:
    # each line by itself allows for its few bins: the root of the sum of their squares reads 1.3 times more
    orders, noise, found = 12, 1e-3, []
    theta_e = rotation(9830)
    track = track_angle(np.mod(theta_e, 2 * np.pi), 1)
    for seed in range(40):
        random = np.random.default_rng([71, seed])
        signal = wave(theta_e, orders * [0.1], random.uniform(0, 2 * np.pi, orders + 1))
        spectrum = coherent_spectrum(signal + noise * random.standard_normal(len(theta_e)), RATE_HZ, track)
        distortion = total_harmonic_distortion(spectrum, orders + 1)
        error = distortion.ratio - 0.1 * math.sqrt(orders)
        found.append(error / distortion.standard)
    assert 0.75 < float(np.sqrt(np.mean(np.square(found)))) < 1.25


def test_noise_alone_that_is_large_by_chance_beside_one_of_many_harmonics_is_none() -> None:
    # the fourth power of the larger of two estimates, one of them of few bins, is six times that of the noise
    small, orders, found = 2e-3, 50, []
    theta_e = rotation(10_000)
    track = track_angle(np.mod(theta_e, 2 * np.pi), 1)
    for seed in range(80):
        random = np.random.default_rng([72, seed])
        signal = wave(theta_e, [0.0, 0.0, 0.0, small], random.uniform(0, 2 * np.pi, 5))
        spectrum = coherent_spectrum(signal + 2e-2 * random.standard_normal(len(theta_e)), RATE_HZ, track)
        distortion = total_harmonic_distortion(spectrum, orders)
        found.append((distortion.ratio - small) / distortion.standard)
    assert 0.72 < float(np.sqrt(np.mean(np.square(found)))) < 1.2
