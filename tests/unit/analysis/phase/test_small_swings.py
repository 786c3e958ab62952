"""Swings of a speed that are too small to be followed, and lines beside the largest harmonic."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import Measurement, PhaseTrack, current_spectrum, track_angle, track_tone
from benchtool.analysis.coherent.spectrum import CoherentSamples
from benchtool.analysis.phase.wander import wander
from benchtool.block import Block
from tests.at_length import at_length

RATE_HZ = 10_000.0


@pytest.mark.parametrize("seed", range(3))
def test_a_swing_too_small_to_follow_is_in_the_frequency(seed: int) -> None:
    """The phase at both ends counts, not that of the middle, which a window weights."""
    random = np.random.default_rng(seed)
    time_s = np.arange(20_000) / RATE_HZ
    theta = 2 * np.pi * 23.1 * time_s + 2e-3 * np.sin(2 * np.pi * (1.23 * time_s + random.uniform()))
    current = np.cos(theta) + 0.03 * np.cos(5 * theta) + 1e-3 * random.standard_normal(len(theta))
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = {each.name: each for each in current_spectrum(block, "i_a", track_tone(current)).measurements}
    true_Hz = float(theta[-1] - theta[0]) / (2 * np.pi * time_s[-1])
    frequency = found["fundamental_frequency"]
    assert frequency.uncertainty is not None
    assert abs(frequency.value - true_Hz) < 3.0 * frequency.uncertainty.standard
    assert 2 * np.pi * 2.0 * frequency.uncertainty.standard < 1e-3  # rad over the record


def settling(periods: float, share: float, constant: float) -> tuple[np.ndarray, np.ndarray]:
    """Return time and phase of a speed that is off by a share at first, and then less, with a time constant
    over the duration."""
    time_s = np.arange(round(periods * 40.0)) / RATE_HZ
    place = time_s * RATE_HZ / len(time_s)
    turned = place + share * constant * (1.0 - np.exp(-place / constant))
    return time_s, 2 * np.pi * periods * turned


def frequency_of(current: np.ndarray, track: PhaseTrack) -> Measurement:
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = {each.name: each for each in current_spectrum(block, "i_a", track).measurements}
    return found["fundamental_frequency"]


def mean_Hz(time_s: np.ndarray, theta: np.ndarray) -> float:
    return float((theta[-1] - theta[0]) / (2 * np.pi * time_s[-1]))


def off_in_u(current: np.ndarray, time_s: np.ndarray, theta: np.ndarray) -> float:
    """Return by how many standard uncertainties the frequency of a current without an angle is off."""
    frequency, true_Hz = frequency_of(current, track_tone(current)), mean_Hz(time_s, theta)
    assert frequency.uncertainty is not None
    return float((frequency.value - true_Hz) / frequency.uncertainty.standard)


def test_a_speed_that_settles_within_the_noise_is_in_the_frequency() -> None:
    """A window weights the first periods less than the others, and noise hides what their phases do."""
    random, errors = np.random.default_rng(8), []
    time_s, theta = settling(16.6, 1.1e-3, 0.15)
    for _ in range(16):
        current = np.cos(theta + random.uniform(0.0, 2 * np.pi)) + 0.007 * random.standard_normal(len(theta))
        errors.append(off_in_u(current, time_s, theta))
    assert 0.5 < float(np.sqrt(np.mean(np.square(errors)))) < 1.9


def test_a_settling_that_is_followed_is_known_in_the_middles_of_periods() -> None:
    """Its phases are no means over periods any more: taken for these, all were off by 1 to 2.5 u, one way."""
    time_s, theta = settling(9.8, 9.8e-3, 0.345)
    random, errors = np.random.default_rng(6), []
    for _ in range(6):
        current = np.cos(theta + random.uniform(0.0, 2 * np.pi)) + 1.1e-4 * random.standard_normal(len(theta))
        errors.append(off_in_u(current, time_s, theta))
    assert abs(float(np.mean(errors))) < 1.2


@pytest.mark.parametrize("rises", [-0.0135, 0.02])
def test_an_amplitude_that_rises_meanwhile_hides_no_speed_that_settles(rises: float) -> None:
    """A line through the amplitudes is no noise that might have moved the phases as well."""
    time_s, theta = settling(9.7, 2.9e-3, 0.37)
    load = 1.0 + rises * np.linspace(-0.5, 0.5, len(theta))
    current = load * np.cos(theta) + 3.8e-4 * np.random.default_rng(3).standard_normal(len(theta))
    frequency, true_Hz = frequency_of(current, track_tone(current)), mean_Hz(time_s, theta)
    assert frequency.uncertainty is not None
    assert abs(frequency.value - true_Hz) < 3.0 * frequency.uncertainty.standard
    assert frequency.uncertainty.standard < 2e-4 * true_Hz


def test_the_frequency_of_an_angle_that_was_computed_is_that_of_its_ends() -> None:
    """Blocks of its course that are a row longer than others, or the record, made an error of 9e-6 rad."""
    time_s, theta = settling(9.1, -2.4e-3, 0.78)
    current = np.cos(theta) + 0.01 * np.random.default_rng(2).standard_normal(len(theta))
    frequency, true_Hz = frequency_of(current, track_angle(theta / 4, 4)), mean_Hz(time_s, theta)
    assert frequency.uncertainty is not None
    assert abs(frequency.value - true_Hz) < 2.0 * frequency.uncertainty.standard
    assert frequency.uncertainty.standard < 3e-9 * true_Hz


def test_the_largest_low_component_has_the_budget_of_its_harmonic() -> None:
    """A line a third of a bin beside the fifth leaves as much of both open."""
    count = 20_000
    theta = 2 * np.pi * 40.3 * np.arange(count) / count
    current = np.cos(theta) + 0.03 * np.cos(5 * theta + 1.0) + 0.02 * np.cos(7 * theta)
    current += 0.006 * np.cos(2 * np.pi * (5 * 40.3 + 0.3) * np.arange(count) / count + 2.0)
    current += 1e-3 * np.random.default_rng(4).standard_normal(count)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = current_spectrum(block, "i_a", track_angle(theta / 4, 4))
    largest = next(each for each in found.measurements if each.name == "current_max_low_harmonic")
    row = found.tables[0].rows[4]
    assert largest.uncertainty is not None
    assert largest.value == pytest.approx(row[2])
    assert largest.uncertainty.standard == pytest.approx(row[5], rel=0.05)
    assert math.isfinite(row[5])


def test_a_line_beside_a_harmonic_does_not_make_it_the_largest() -> None:
    """In the bin of the fifth are a third of a bin's line and the fifth, more than the seventh."""
    count = 20_000
    turns = 40.3 * np.arange(count) / count
    theta = 2 * np.pi * turns
    current = np.cos(theta) + 0.027 * np.cos(5 * theta + 1.0) + 0.0285 * np.cos(7 * theta)
    current += 0.006 * np.cos(2 * np.pi * (5 + 0.3 / 40.3) * turns + 1.0)
    current += 1e-3 * np.random.default_rng(4).standard_normal(count)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = current_spectrum(block, "i_a", track_angle(theta / 4, 4))
    largest = next(each for each in found.measurements if each.name == "current_max_low_harmonic")
    assert found.spectrum.amplitude[5 * found.spectrum.periods] > 0.03
    assert largest.value == pytest.approx(0.0285, rel=1e-3)


@pytest.mark.parametrize("counts", [1000, *at_length(64, 2500)])
@pytest.mark.parametrize("wobble_counts", [0.02, *at_length(0.0)])
def test_counts_that_beat_with_the_rows_leave_the_frequency_open(counts: int, wobble_counts: float) -> None:
    """An encoder at a rate that is nearly a ratio of whole numbers of the rows' shows no deviation."""
    random = np.random.default_rng(counts)
    time_s = np.arange(20_000) / RATE_HZ
    errors = []
    for _ in range(8):
        true_Hz = 20.0 * (1.0 + 2e-5 * random.standard_normal())
        theta_m = 2 * np.pi * true_Hz / 4.0 * time_s + random.uniform(0.0, 2 * np.pi)
        step_rad = 2 * np.pi / counts
        read = theta_m + wobble_counts * step_rad * np.sin(theta_m)
        track = track_angle(np.floor(read / step_rad) * step_rad, 4)
        current = np.cos(4.0 * theta_m) + 1e-3 * random.standard_normal(len(theta_m))
        block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
        found = {each.name: each for each in current_spectrum(block, "i_a", track).measurements}
        frequency = found["fundamental_frequency"]
        assert frequency.uncertainty is not None
        errors.append((frequency.value - true_Hz) / frequency.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(errors))) < 1.7


@pytest.mark.parametrize("per_period", [12, 39, 600])
def test_a_tone_that_turns_beside_its_track_has_its_amplitude_and_phase(per_period: int) -> None:
    """Its image at the negative frequency and the middle of its samples, moved both by 3e-3 to 5e-3."""
    turns = np.arange(20 * per_period) / per_period
    own_rad = 0.4 + 3e-3 * turns + 1e-3 * turns**2
    values = 2.0 * np.cos(2 * np.pi * turns + own_rad)
    seen = wander(CoherentSamples(values, 20, float(len(values)), RATE_HZ))
    middle = np.arange(20.0) + 0.5
    expected_rad = 0.4 + 3e-3 * middle + 1e-3 * (middle**2 + 1.0 / 12.0)
    np.testing.assert_allclose(seen.phase_rad, expected_rad, atol=2e-4)
    np.testing.assert_allclose(seen.amplitude, 2.0, rtol=2e-4)
