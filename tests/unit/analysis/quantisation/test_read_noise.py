"""Noise by where a converter reads a value and how much its readings scatter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ndtr

from benchtool.analysis import analyze_step
from benchtool.analysis.quantisation.read_noise import error_of_mean, noise_of_readings
from benchtool.block import Block

STEP = 0.3


def readings(place: float, rms: float, seed: int = 0) -> np.ndarray:
    noise = rms * np.random.default_rng(seed).standard_normal(8000)
    return np.asarray(STEP * np.round(17.0 + place + noise))


@pytest.mark.parametrize("place", [0.0, 0.2, 0.45, 0.5, 0.9])
@pytest.mark.parametrize("rms", [0.3, 0.45, 0.9, 3.0])
def test_noise_of_a_third_of_a_step_and_more_is_told_at_any_place(place: float, rms: float) -> None:
    assert noise_of_readings(readings(place, rms), STEP) == pytest.approx(rms * STEP, rel=0.08)


def test_readings_far_from_the_others_hide_no_steps() -> None:
    """Ten of 8000, each by 20 steps, make more of their variance than the noise does."""
    read = readings(0.2, 0.33)
    near = noise_of_readings(read, STEP)
    read[:10] += 20.0 * STEP
    assert noise_of_readings(read, STEP) == pytest.approx(near, rel=0.1)


def test_next_to_no_noise_in_the_middle_between_levels_is_not_taken_for_half_a_step() -> None:
    assert float(np.std(readings(0.5, 0.02))) == pytest.approx(0.5 * STEP, rel=0.01)
    assert noise_of_readings(readings(0.5, 0.02), STEP) < 0.25 * STEP
    assert noise_of_readings(readings(0.1, 0.02), STEP) < 0.05 * STEP


@pytest.mark.parametrize(("place", "rms"), [(0.25, 0.15), (0.4, 0.2), (0.75, 0.15), (0.1, 0.2)])
def test_less_noise_is_told_by_how_far_from_a_level_the_value_is(place: float, rms: float) -> None:
    assert noise_of_readings(readings(place, rms), STEP) == pytest.approx(rms * STEP, rel=0.2)


@pytest.mark.parametrize("rms", [1e-4, 0.03, 0.1, 0.33])
def test_the_error_of_a_mean_is_that_of_values_anywhere_between_two_levels(rms: float) -> None:
    """Also of those alone that are read on both levels."""
    places = np.random.default_rng(5).uniform(-0.5, 0.5, 400)
    over_u, of_both = [], []
    for seed, place in enumerate(places):
        read = readings(place, rms, seed)[:400]
        error = float(np.mean(read)) - STEP * (17.0 + place)
        over_u.append(error / math.hypot(error_of_mean(read, STEP), float(np.std(read)) / 20.0))
        if np.ptp(read) > 0.0:
            of_both.append(over_u[-1])
    for each in filter(None, (over_u, of_both)):
        assert 0.6 < math.sqrt(np.mean(np.square(each))) < 1.5
        assert np.mean(np.abs(each) < 2.0) > 0.93


@pytest.mark.parametrize("share", [0.2, 0.45])
def test_the_error_of_two_levels_is_what_any_noise_up_to_theirs_leaves(share: float) -> None:
    """Of any rms of which the square is as likely as another, at the place where the mean is as it is."""
    read = np.where(np.arange(1000) < 1000.0 * share, STEP, 0.0)
    most = noise_of_readings(read, STEP) / STEP

    def mean(place: float, noise: float) -> float:
        return float(np.sum(ndtr((place - np.arange(-3.0, 5.0) + 0.5) / noise))) - 4.0

    off = []
    for noise in most * np.sqrt((np.arange(100) + 0.5) / 100):
        place = brentq(lambda at, noise=noise: mean(at, noise) - share, -0.5, 1.5)
        off.append(share - place)
    assert error_of_mean(read, STEP) == pytest.approx(STEP * math.sqrt(np.mean(np.square(off))), rel=5e-3)


@pytest.mark.parametrize(("off", "is_whole"), [(0.007, True), (0.02, False)])
def test_readings_a_hundredth_of_a_step_off_are_on_levels(off: float, is_whole: bool) -> None:
    read = readings(0.5, 0.02) + off * STEP * (np.arange(8000) % 2)
    assert (noise_of_readings(read, STEP) < 0.25 * STEP) is is_whole


def test_readings_about_a_reference_that_moves_are_told_by_their_variance() -> None:
    moved = readings(0.0, 0.6) - 0.2 * STEP * np.sin(np.arange(8000.0))
    expected = np.sqrt(float(np.var(moved)) - STEP**2 / 12.0)
    assert noise_of_readings(moved, STEP) == pytest.approx(expected)
    assert noise_of_readings(moved, 0.0) == pytest.approx(float(np.std(moved)))


def test_the_tracking_error_is_without_what_two_levels_make_of_a_value_between_them() -> None:
    """Which is half of a step, 7.8e-3, where the signal is off by the tail of its answer and little noise."""
    random, time_s = np.random.default_rng(4), (np.arange(6000) - 500) / 10e3
    r = np.where(time_s >= 0.0, 1.0, 0.0)
    answer = np.where(time_s >= 0.0, 1.0 - np.exp(-np.maximum(time_s, 0.0) / 3e-3), 0.0)
    step = 1.0 / 64.0
    y = step * (np.round((answer + 2e-3 * random.standard_normal(6000)) / step - 0.5) + 0.5)
    block = Block.from_arrays(10e3, {"y": "Nm", "r": "Nm"}, y=y, r=r)
    found = {each.name: each for each in analyze_step(block, "y", "r").measurements}["tracking_error_rms"]
    settled = int(np.flatnonzero(np.abs(answer - 1.0) > 0.02)[-1]) + 1
    assert float(np.sqrt(np.mean((y - r)[settled:] ** 2))) > 7e-3
    assert found.uncertainty is not None
    assert found.value < 5e-3
    assert (
        abs(found.value - float(np.sqrt(np.mean((answer - r)[settled:] ** 2))))
        < 2.5 * found.uncertainty.standard
    )
    assert "steps of a converter" in found.definition
