"""Phases beyond the first and last period: noise, and what bends."""

import math

import numpy as np
import pytest

from benchtool.analysis import current_spectrum
from benchtool.analysis.periods import track_tone
from benchtool.analysis.phase.continuation import continuation
from benchtool.analysis.phase.turned_phase import turned_by_tone
from benchtool.analysis.spectra.separation import separate
from benchtool.block import Block

RATE_HZ, F_HZ, PERIODS = 10_000.0, 200.0, 60.3


def test_a_swing_of_few_periods_is_no_noise() -> None:
    place = np.arange(100.0)
    swing_rad = 0.1 * np.sin(2 * np.pi * place / 10.3)
    assert continuation(swing_rad).noise2 < (1e-3 * 0.1) ** 2
    found = continuation(swing_rad[:22])  # of which no weights are told
    bend_rad = math.sqrt(found.missed2)
    # a cubic misses the next phase by the fourth difference, the one half a period on by 105 / 384 of that
    assert math.sqrt(found.error2(0.5)) == pytest.approx(105.0 / 384.0 * bend_rad, rel=1e-2)


def test_a_swing_of_four_periods_goes_on() -> None:
    # once in a revolution of four pole pairs: a parabola through the last phases misses it by all of it
    random, errors, stated = np.random.default_rng(11), [], []
    for _ in range(20):
        place, begin_rad = np.arange(80.0), random.uniform(0.0, 2.0 * math.pi)
        drift_rad = 6.0 * place + 1e-4 * place**2
        phase_rad = drift_rad + 0.04 * np.sin(2 * np.pi * place / 4.02 + begin_rad)
        found = continuation(phase_rad + 1e-4 * random.standard_normal(80))
        truth_rad = 6.0 * 79.7 + 1e-4 * 79.7**2 + 0.04 * math.sin(2 * math.pi * 79.7 / 4.02 + begin_rad)
        errors.append(float(found.weights(0.7) @ phase_rad[-found.size :]) - truth_rad)
        stated.append(math.sqrt(found.error2(0.7)))
    assert max(map(abs, errors)) < 5e-4
    assert max(stated) < 5e-4


def test_what_digits_do_to_every_third_phase_is_no_swing() -> None:
    """Rows are at the same places of every third period, and were rounded there alike."""
    random, errors = np.random.default_rng(2), []
    for _ in range(4):
        theta = 2.0 * np.pi * 3.0 / 500.0 * np.arange(20_000) + random.uniform(0.0, 2.0 * np.pi)
        wave = np.cos(theta) + 0.02 * np.cos(5 * theta + random.uniform(0.0, 2.0 * np.pi))
        wave += 0.02 * np.cos(7 * theta + random.uniform(0.0, 2.0 * np.pi))
        block = Block.from_arrays(10_000.0, {"i_a": "A"}, i_a=np.round(5.0 * wave, 4))
        frequency = current_spectrum(block, "i_a", track_tone(block.column("i_a"))).measurements[0]
        assert frequency.uncertainty is not None
        errors.append((frequency.value - 60.0) / frequency.uncertainty.standard)
    assert np.max(np.abs(errors)) < 3.0


def test_noise_is_that_of_fourth_differences() -> None:
    random = np.random.default_rng(5)
    found = [continuation(1e-3 * random.standard_normal(80)).noise2 for _ in range(40)]
    assert math.sqrt(float(np.mean(found))) == pytest.approx(1e-3, rel=0.1)


def test_a_swing_within_periods_is_none_along_the_track_that_follows_it() -> None:
    count, random, ratios = 12_000, np.random.default_rng(12), []
    for _ in range(8):
        turns = 200.0 * np.arange(count) / RATE_HZ
        swing_rad = 0.04 * np.sin(2 * np.pi * (turns / 4.0 + random.uniform()))
        theta = 2 * np.pi * (turns + random.uniform()) + swing_rad
        samples = np.cos(theta) + 0.03 * np.cos(5 * theta + 1.0) + 0.02 * np.cos(7 * theta)
        samples = samples + 3e-3 * random.standard_normal(count)
        found = separate(samples, RATE_HZ, track_tone(samples), "i_a", 0.0)
        seen, beside_rad = found.over_record(RATE_HZ, "i_a")
        turned = turned_by_tone(found.spectrum, found.track, seen, 0.0, beside_rad)
        ratios.append((turned.phase_rad - float(theta[-1] - theta[0])) / turned.standard)
    assert 0.5 < math.sqrt(float(np.mean(np.square(ratios)))) < 1.5


@pytest.mark.slow
def test_noise_of_a_followed_phase_counts_once() -> None:
    count = round(PERIODS / F_HZ * RATE_HZ)
    place = np.arange(count) / count
    theta = 2 * np.pi * PERIODS * (place + 0.01 * (place**2 - place))
    current = np.cos(theta) + 0.03 * np.cos(5 * theta + 1.0) + 0.02 * np.cos(7 * theta)
    random, ratios = np.random.default_rng(6), []
    for _ in range(40):
        samples = current + 1e-3 * random.standard_normal(count)
        found = separate(samples, RATE_HZ, track_tone(samples), "i_a", 0.0)
        seen, beside_rad = found.over_record(RATE_HZ, "i_a")
        turned = turned_by_tone(found.spectrum, found.track, seen, 0.0, beside_rad)
        standard = math.hypot(*(each.standard for each in turned.budget))
        ratios.append((turned.phase_rad - float(theta[-1] - theta[0])) / standard)
    assert 0.75 < math.sqrt(float(np.mean(np.square(ratios)))) < 1.3


def test_noise_of_few_phases_is_that_of_the_amplitudes_too() -> None:
    random, by_phase, by_both = np.random.default_rng(7), [], []
    for _ in range(200):
        phase_rad, amplitude = 1e-3 * random.standard_normal((2, 7))
        by_phase.append(continuation(phase_rad).noise2)
        by_both.append(continuation(phase_rad, 1.0 + amplitude).noise2)
    assert np.mean(by_both) == pytest.approx(1e-6, rel=0.15)
    # three overlapping differences are often far below, and errors then many times the uncertainty
    assert np.quantile(by_both, 0.1) > 2.0 * np.quantile(by_phase, 0.1)


def test_an_amplitude_that_swings_is_no_noise_of_the_phase() -> None:
    phase_rad = 1e-3 * np.random.default_rng(8).standard_normal(7)
    swings = 1.0 + 0.02 * np.sin(1.3 * np.arange(7.0))
    assert continuation(phase_rad, swings).noise2 == continuation(phase_rad).noise2


def test_a_track_that_swings_within_ten_periods_reaches_both_ends() -> None:
    # half a period before its ends the record has its last phases; the track is continued from there
    random, errors = np.random.default_rng(9), []
    for _ in range(6):
        time_s = np.arange(25_000) / 10_000.0
        swing = 0.1 * np.sin(2 * np.pi * (2.0 * time_s + random.uniform()))
        theta = 2 * np.pi * (20.0 * time_s + random.uniform()) + swing
        samples = np.cos(theta) + 0.03 * np.cos(5 * theta + 1.0) + 0.02 * np.cos(7 * theta)
        samples = samples + 1e-5 * random.standard_normal(len(theta))
        found = separate(samples, 10_000.0, track_tone(samples), "i_a", 0.0)
        errors.append(found.spectrum.fundamental - 1.0)
    assert math.sqrt(float(np.mean(np.square(errors)))) < 6e-6
