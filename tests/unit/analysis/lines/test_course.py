"""How far an angle gets about a steady rise: its course in noise, and what it repeats in every turn."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import Measurement, current_spectrum, track_angle
from benchtool.analysis.lines.course import FEWEST, change_over_record, repeated_in_turns
from benchtool.block import Block

RATE_HZ, POLE_PAIRS = 5_000.0, 4


def test_a_quadratic_gets_as_far_as_it_does() -> None:
    at = (np.arange(20) + 0.5) / 20
    found = change_over_record(3.0 * at**2 - 5.0 * at + 1.0)
    assert found.size == pytest.approx(-2.0)
    assert found.standard < 1e-9


@pytest.mark.parametrize("parts", [FEWEST, 64])
def test_noise_alone_is_the_scatter_of_the_quadratic(parts: int) -> None:
    """Of a quadratic by least squares the change over the record is its slope: sqrt(12 / n) of the noise."""
    random = np.random.default_rng(parts)
    errors = [change_over_record(random.standard_normal(parts)) for _ in range(100)]
    ratio = np.array([each.size / each.standard for each in errors])
    assert 0.6 < math.sqrt(float(np.mean(ratio**2))) < 1.3
    if parts == 64:
        assert 1.0 < float(np.median([each.standard for each in errors])) / math.sqrt(12 / parts) < 2.0


@pytest.mark.parametrize("noise", [0.0, 0.01, 0.3])
def test_the_end_of_a_random_walk_of_the_speed_is_told_as_well_as_noise_allows(noise: float) -> None:
    random, parts, rows, ratio = np.random.default_rng(7), 48, 20, []
    for _ in range(60):
        course = np.cumsum(np.cumsum(random.standard_normal(parts * rows))) / (parts * rows) ** 1.5
        seen = course + noise * random.standard_normal(len(course))
        found = change_over_record(np.mean(seen.reshape(parts, rows), axis=1))
        ratio.append((found.size - (course[-1] - course[0])) / found.standard)
    assert 0.6 < math.sqrt(float(np.mean(np.square(ratio)))) < 1.4
    assert float(np.mean(np.abs(ratio) < 2.0)) > 0.85


def test_what_repeats_is_found_beside_a_drift_and_only_of_two_turns() -> None:
    turns = np.linspace(0.0, 7.4, 3_000)
    own = 0.1 * np.sin(2 * np.pi * turns + 1.0) + 0.03 * np.cos(6 * np.pi * turns)
    found = repeated_in_turns(own + 0.4 * turns - 0.02 * turns**2, turns).values
    assert float(np.max(np.abs(found - own))) < 5e-3
    assert not np.any(repeated_in_turns(own[:800], turns[:800]).values)


@pytest.mark.parametrize("last", [7.4, 7.002])
def test_how_far_what_repeats_gets_over_the_record_is_known_as_noise_allows(last: float) -> None:
    random, ratio = np.random.default_rng(11), []
    for _ in range(100):
        turns = np.linspace(0.0, last, 3_000)
        own = 0.1 * np.sin(2 * np.pi * (turns + random.uniform()))
        found = repeated_in_turns(own + 0.1 * random.standard_normal(len(turns)), turns)
        off = found.values[-1] - found.values[0] - (own[-1] - own[0])
        ratio.append(float(off) / found.standard)
    assert 0.7 < math.sqrt(float(np.mean(np.square(ratio)))) < 1.4


def _error(
    swung_rad: float, of_sensor_rad: float, order: int, random: np.random.Generator
) -> tuple[float, float]:
    """Return error and standard uncertainty of the frequency of a rotor that swings by little, along an angle
    with an error of that order."""
    time_s = np.arange(12_000) / RATE_HZ
    theta_m = 2 * np.pi * 5.03 * time_s
    theta_m += swung_rad / POLE_PAIRS * np.sin(2 * np.pi * (0.83 * time_s + random.uniform()))
    angle = theta_m + of_sensor_rad / POLE_PAIRS * np.sin(order * theta_m + random.uniform(0, 2 * np.pi))
    current = np.cos(POLE_PAIRS * theta_m) + 1e-3 * random.standard_normal(len(theta_m))
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = current_spectrum(block, "i_a", track_angle(angle, POLE_PAIRS)).measurements
    frequency = next(each for each in found if each.name == "fundamental_frequency")
    true_Hz = POLE_PAIRS * float(theta_m[-1] - theta_m[0]) / (2 * np.pi * time_s[-1])
    assert frequency.uncertainty is not None
    return frequency.value - true_Hz, frequency.uncertainty.standard


@pytest.mark.parametrize("seed", range(4))
def test_a_swing_that_is_not_followed_counts_at_both_ends(seed: int) -> None:
    """The slope of the fit to the angle is another, and the swing no noise."""
    error, standard = _error(1.5e-3, 0.0, 1, np.random.default_rng(seed))
    assert abs(error) < 3.0 * standard
    assert standard < 1e-5


@pytest.mark.parametrize("seed", range(4))
def test_an_error_of_the_sensor_at_both_ends_is_in_the_uncertainty(seed: int) -> None:
    """Once in an electrical period it moves no phase of the current from period to period."""
    error, standard = _error(30e-3, 20e-3, POLE_PAIRS, np.random.default_rng(seed))
    assert abs(error) < 2.5 * standard


@pytest.mark.parametrize("phase_rad", [0.0, 1.5, 3.0])
def test_an_error_once_a_turn_of_nearly_whole_turns_is_told_by_turns_without_its_tilt(
    phase_rad: float,
) -> None:
    """Both ends are at nearly one place of a turn, and next to nothing of the error is between them."""
    theta = np.linspace(0.0, 2 * np.pi * 19.9993, 20_000)
    angle = theta + 0.01 * np.sin(theta + phase_rad)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=np.cos(POLE_PAIRS * theta))
    frequency = current_spectrum(block, "i_a", track_angle(angle, POLE_PAIRS)).measurements[0]
    true_Hz = POLE_PAIRS * 19.9993 / 19_999 * RATE_HZ
    assert frequency.uncertainty is not None
    assert abs(frequency.value - true_Hz) < 1.5 * frequency.uncertainty.standard
    assert frequency.uncertainty.standard < 1e-5


def test_digits_of_an_angle_are_counts_with_its_jumps_or_without() -> None:
    """No whole number of them is a turn: without jumps the angle seemed to have no steps, and where a few
    rows at either end were equally far apart by chance, no error."""
    time_s = np.arange(700) / 700.0
    theta = 2 * np.pi * 17.8333 * time_s + 0.3
    read = np.asarray(np.round(np.mod(theta, 2 * np.pi), 2), dtype=np.float64)
    for angle in (read, np.unwrap(read)):
        track = track_angle(angle, 1)
        assert track.resolution_rad == pytest.approx(0.01)
    current = np.cos(theta) + 1e-4 * np.random.default_rng(1).standard_normal(len(theta))
    block = Block.from_arrays(700.0, {"i_a": "A"}, i_a=current)
    frequency = current_spectrum(block, "i_a", track).measurements[0]
    assert frequency.uncertainty is not None
    assert 1e-6 < frequency.uncertainty.standard < 1e-4
    assert abs(frequency.value - 17.8333) < 3.0 * frequency.uncertainty.standard


def _of_part_of_turn(
    revolutions: float, pole_pairs: int, of_sensor_rad: float, phase_rad: float
) -> Measurement:
    """Return the frequency along an angle with an error once in a revolution."""
    time_s = np.arange(round(0.3 * RATE_HZ)) / RATE_HZ
    theta_m = 2 * np.pi * revolutions * time_s / 0.3
    angle = theta_m + of_sensor_rad * np.sin(theta_m + phase_rad)
    noise = 1e-3 * np.random.default_rng(4).standard_normal(len(theta_m))
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=np.cos(pole_pairs * theta_m) + noise)
    return current_spectrum(block, "i_a", track_angle(angle, pole_pairs)).measurements[0]


@pytest.mark.parametrize("of_sensor_rad", [0.0, 5e-3])
@pytest.mark.parametrize("phase_rad", [-1.0, 0.5])
@pytest.mark.parametrize("pole_pairs", [18, 24])
def test_of_a_part_of_a_revolution_the_frequency_is_that_of_the_current(
    pole_pairs: int, phase_rad: float, of_sensor_rad: float
) -> None:
    """Within a third of a turn an error once in a turn is nearly a change of the speed."""
    frequency = _of_part_of_turn(0.35, pole_pairs, of_sensor_rad, phase_rad)
    assert frequency.uncertainty is not None
    assert 1e-6 < frequency.uncertainty.standard / frequency.value < 1e-4
    assert abs(frequency.value - 0.35 * pole_pairs / 0.3) < 3.0 * frequency.uncertainty.standard
    assert "of the signal; the angle alone gives" in frequency.definition


def test_of_a_part_of_a_revolution_and_few_periods_there_is_no_frequency() -> None:
    frequency = _of_part_of_turn(0.35, 12, 5e-3, 0.5)
    assert math.isnan(frequency.value)
    assert "does not show within 0.35 revolutions" in frequency.reason
    whole = _of_part_of_turn(1.05, 4, 0.0, 0.5)
    assert whole.uncertainty is not None
    assert "of the signal" not in whole.definition
