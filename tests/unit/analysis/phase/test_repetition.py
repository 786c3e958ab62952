"""What moves the fundamental's phase, as its harmonics have it: closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples
from benchtool.analysis.periods import track_angle, track_tone
from benchtool.analysis.phase.phase_following import follow
from benchtool.analysis.phase.repetition import repetition
from benchtool.analysis.spectra.modulation import apart_in_time

Array = NDArray[np.float64]
RATE_HZ, SAMPLES, PER_PERIOD = 10_000.0, 20_000, 200
T = np.arange(SAMPLES) / RATE_HZ
NOISE = 2e-3 * np.random.default_rng(0).standard_normal(SAMPLES)


def current(phase: Array) -> Array:
    return np.cos(phase) + 0.05 * np.cos(5.0 * phase + 1.0) + 0.03 * np.cos(7.0 * phase + 2.0)


def swing(frequency_Hz: float, begin: float = 0.3) -> Array:
    return np.sin(2.0 * np.pi * frequency_Hz * T + begin)


def off_rad(samples: Array, phase: Array) -> float:
    """Return how far, rms, the track that follows is off the phase."""
    _, track, _ = follow(samples, RATE_HZ, track_tone(samples))
    return float(np.std(track.at(np.arange(SAMPLES, dtype=np.float64)) - phase))


@pytest.mark.parametrize("amplitude", [0.0, 0.02, 0.06])
def test_a_phase_that_swings_is_followed_whatever_the_amplitude_does(amplitude: float) -> None:
    phase = 2.0 * np.pi * 50.3 * T + 0.02 * swing(2.3)
    samples = (1.0 + amplitude * swing(2.3, 1.6)) * current(phase) + NOISE
    assert off_rad(samples, phase) < 1e-3


@pytest.mark.parametrize(("order", "most_rad"), [(0.9, 1e-3), (1.13, 1e-3), (17.3, 4e-4)])
def test_a_line_is_not_followed_and_a_drift_is(order: float, most_rad: float) -> None:
    """It moves the phase of the fundamental by 21 mrad, rms, and far from it that of one period by 0.6."""
    phase = 2.0 * np.pi * 50.3 * T * (1.0 + 0.002 * T)
    samples = current(phase) + 0.03 * np.cos(order * phase + 1.0) + NOISE
    assert off_rad(samples, phase) < most_rad


def test_a_swing_is_followed_and_a_line_beside_it_is_not() -> None:
    phase = 2.0 * np.pi * 50.3 * T + 0.02 * swing(2.3)
    samples = current(phase) + 0.02 * np.cos(2.0 * np.pi * 56.7 * T) + NOISE
    assert off_rad(samples, phase) < 1e-3


def coherent(samples: Array) -> CoherentSamples:
    return CoherentSamples(samples, SAMPLES // PER_PERIOD, float(SAMPLES), RATE_HZ)


def test_what_harmonics_repeat_is_told_from_what_they_do_not() -> None:
    steady = 2.0 * np.pi * 50.0 * T
    moved, beside = 0.01 * swing(3.0), 0.02 * np.cos(2.0 * np.pi * 57.0 * T)
    for motion, line in ((moved, 0.0 * T), (0.0 * T, beside), (moved, beside)):
        found = repetition(coherent(current(steady + motion) + line + NOISE))
        assert found is not None
        expected = float(np.std(motion))
        assert found.motion_rad == pytest.approx(expected, rel=0.05)
        at = motion[PER_PERIOD - 1 : -PER_PERIOD : PER_PERIOD]
        assert np.std(found.phase_rad - at) < 1e-3


def test_a_swing_that_no_harmonic_shows_is_undecided() -> None:
    phase = 2.0 * np.pi * 50.0 * T + 0.01 * swing(3.0)
    for weak in (0.0, 1e-4):
        samples = (1.0 + 0.01 * swing(3.0)) * np.cos(phase) + weak * np.cos(5.0 * phase)
        found = repetition(coherent(samples + 0.05 / 2e-3 * NOISE))
        assert found is not None
        assert found.motion_rad == 0.0
        assert found.undecided_rad > 0.007


def test_a_mean_over_periods_is_that_over_time_where_the_speed_is_constant() -> None:
    amplitude = 1.0 + 0.1 * np.sin(2.0 * np.pi * np.arange(100) / 20.0)
    assert abs(apart_in_time(amplitude, np.arange(101.0))) < 1e-12
    # longer periods where the amplitude is greater: half of the product of both
    edges = np.concatenate([[0.0], np.cumsum(1.0 + 0.2 * (amplitude - 1.0))])
    assert apart_in_time(amplitude, edges) == pytest.approx(0.5 * 0.1 * 0.02, rel=0.02)
    edges = np.concatenate([[0.0], np.cumsum(1.0 - 0.2 * (amplitude - 1.0))])
    assert apart_in_time(amplitude, edges) == pytest.approx(-0.5 * 0.1 * 0.02, rel=0.02)


@pytest.mark.parametrize("slip", [-0.0046, 0.003])
def test_what_a_fundamental_that_slips_leaks_to_its_harmonics_is_none_of_them(slip: float) -> None:
    angle = 2.0 * np.pi / 21.0 * np.arange(1200.0)
    for begin in np.linspace(0.0, 2.0 * np.pi, 6, endpoint=False):
        phase = angle * (1.0 + slip) + begin
        samples = np.cos(phase) + 8e-4 * np.random.default_rng(2).standard_normal(len(phase))
        _, track, seen = follow(samples, RATE_HZ, track_angle(angle, 1))
        assert track.follows_signal
        assert seen.excess_rad < 1e-3
        assert float(np.std(track.at(np.arange(1200.0)) - phase)) < 1e-3
