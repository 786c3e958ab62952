"""Tones whose frequency moves against the harmonics: found as they were made, and noise is none."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples, spectrum_of
from benchtool.analysis.spectra.interharmonics import Interharmonics, between_harmonics, without
from benchtool.analysis.spectra.moving_tones import Course, moving_tones

PERIODS, PER_PERIOD = 60, 200


def course_of_speed(swing: float = 0.0) -> Course:
    """Return a course under a speed that swings three times in the record."""
    turned = np.arange(PERIODS * PER_PERIOD) / (PERIODS * PER_PERIOD)
    return Course(turned, turned + swing * np.sin(6.0 * np.pi * turned))


def samples_of(course: Course, between: NDArray[np.float64], seed: int) -> CoherentSamples:
    theta = 2.0 * np.pi * PERIODS * course.turned
    noise = 1e-3 * np.random.default_rng(seed).standard_normal(len(theta))
    harmonics = np.cos(theta) + 0.03 * np.cos(5 * theta + 1.0)
    return CoherentSamples(harmonics + between + noise, PERIODS, 1.0 * len(theta), 10e3)


def hum(course: Course) -> NDArray[np.float64]:
    """Return a tone of constant frequency."""
    return np.asarray(0.01 * np.cos(2.0 * np.pi * 2.43 * PERIODS * course.passed + 0.3))


def sweep(course: Course) -> NDArray[np.float64]:
    """Return one from order 2.1 to 3.4."""
    cycles = PERIODS * (2.1 * course.passed + 0.65 * course.passed**2)
    return np.asarray(0.01 * np.cos(2.0 * np.pi * cycles + 0.3))


@pytest.mark.parametrize("made", [hum, sweep])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_what_moves_is_taken_out_down_to_the_noise(
    made: Callable[[Course], NDArray[np.float64]], seed: int
) -> None:
    course = course_of_speed(2e-3)
    coherent = samples_of(course, made(course), seed)
    found = moving_tones(coherent, course)
    assert len(found) == 1
    assert abs(found[0].phasor) == pytest.approx(0.01, rel=0.01)
    left = without(coherent, Interharmonics(moving=found), course)
    noise = samples_of(course, 0.0 * course.turned, seed)
    assert float(np.std(left.values - noise.values)) < 1e-4


def test_a_steady_tone_does_not_move() -> None:
    course = course_of_speed()
    coherent = samples_of(course, hum(course), 4)
    assert not moving_tones(coherent, course)
    found = between_harmonics(coherent, spectrum_of(coherent), course)
    assert found is not None
    assert found.places / PERIODS == pytest.approx([2.43], abs=1e-3)


def test_a_narrow_band_of_noise_is_no_tone() -> None:
    course, random = course_of_speed(2e-3), np.random.default_rng(5)
    for _ in range(40):
        bins = np.zeros(PERIODS * PER_PERIOD // 2 + 1, dtype=np.complex128)
        bins[140:152] = random.standard_normal(12) + 1j * random.standard_normal(12)
        noise = np.fft.irfft(bins)
        assert not moving_tones(samples_of(course, 0.01 * noise / np.std(noise), 6), course)


def test_an_amplitude_that_swings_or_wanders_is_no_tone() -> None:
    course, random = course_of_speed(), np.random.default_rng(7)
    theta = 2.0 * np.pi * PERIODS * course.turned
    swing = 0.02 * np.cos(2.0 * np.pi * 3.3 * course.turned) * np.cos(theta)
    assert not moving_tones(samples_of(course, swing, 8), course)
    for _ in range(20):
        walk = np.repeat(
            np.convolve(random.standard_normal(PERIODS), 0.8 ** np.arange(40))[:PERIODS], PER_PERIOD
        )
        assert not moving_tones(samples_of(course, 0.02 * walk * np.cos(theta), 9), course)
