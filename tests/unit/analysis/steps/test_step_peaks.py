"""Peaks of step responses: at corners, in few rows, or none at all; lobes between rows; wandering levels."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from benchtool.analysis import Measurement, analyze_step
from benchtool.analysis.steps.corners import corner_near
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.tops import kink
from benchtool.block import Block
from tests.at_length import at_length

Floats = NDArray[np.float64]

BEFORE = 200
RATE_HZ = 10_000.0


def _measured(y: Floats, before: int = BEFORE) -> dict[str, Measurement]:
    r = (np.arange(len(y)) >= before).astype(np.float64)
    block = Block.from_arrays(RATE_HZ, {"y": "Nm", "r": "Nm"}, y=y, r=r)
    return {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}


def _relative(found: Measurement, truth: float) -> float:
    assert found.uncertainty is not None
    return (found.value - truth) / found.uncertainty.standard


@pytest.mark.slow
def test_a_corner_in_noise_is_as_high_and_as_early_as_stated() -> None:
    random = np.random.default_rng(11)
    row = np.arange(1600.0) - BEFORE
    corner = 84.3
    y = np.where(row < corner, np.maximum(row, 0.0) / 70.0, 0.0)
    y = np.where(row < corner, y, 1.0 + (corner / 70.0 - 1.0) * np.exp(-(row - corner) / 50.0))
    found = [_measured(y + 8e-3 * random.standard_normal(len(y))) for _ in range(9)]
    high = [_relative(each["overshoot"], corner / 70.0 - 1.0) for each in found]
    late = [_relative(each["peak_time"], corner / RATE_HZ) for each in found]
    assert 0.5 < np.sqrt(np.mean(np.square(high))) < 1.7
    assert 0.5 < np.sqrt(np.mean(np.square(late))) < 1.6
    assert abs(np.mean(late)) < 0.8  # which windows that cut it off would move


@pytest.mark.slow
def test_an_overshoot_of_zero_has_the_uncertainty_of_what_cannot_be_negative() -> None:
    random = np.random.default_rng(12)
    y = 1.0 - np.exp(-np.maximum(np.arange(800.0) - BEFORE, 0.0) / 20.0)
    found = [_measured(y + 0.01 * random.standard_normal(len(y)))["overshoot"] for _ in range(12)]
    relative = [_relative(each, 0.0) for each in found]
    assert np.mean(np.abs(relative) <= 2.0) >= 0.9
    assert 0.7 < np.sqrt(np.mean(np.square(relative))) < 1.4
    assert 0.6 < min(relative) < max(relative) < 2.0  # as near to it in every record


@pytest.mark.slow
def test_a_trough_as_deep_as_the_noise_has_the_uncertainty_of_what_noise_makes_of_a_plateau() -> None:
    random = np.random.default_rng(13)
    row = 0.06 * np.maximum(np.arange(800.0) - BEFORE, 0.0)
    relative = []
    for damping in (0.6, 0.7):
        root = math.sqrt(1.0 - damping**2)
        y = 1.0 - np.exp(-damping * row) * (np.cos(root * row) + damping / root * np.sin(root * row))
        truth = math.exp(-2.0 * math.pi * damping / root)
        found = [_measured(y + 0.01 * random.standard_normal(len(y)))["undershoot"] for _ in range(8)]
        relative += [_relative(each, truth) for each in found]
    assert np.sqrt(np.mean(np.square(relative))) < 1.3
    assert np.mean(np.abs(relative) <= 2.0) >= 0.9


def test_a_lobe_between_rows_is_the_last_outside_a_band() -> None:
    def lobe(row: Floats) -> Floats:
        return np.asarray(0.03 * np.exp(-row / 12.0) * np.cos(2.0 * math.pi * row / 7.0))

    fine = np.arange(0.0, 60.0, 1e-3)
    for shift in np.linspace(0.0, 1.0, 9):
        truth = float(fine[np.flatnonzero(np.abs(lobe(fine + shift)) > 0.02)[-1]])
        found = NoisyCurve(lobe(np.arange(60.0) + shift), np.empty((0, 60))).last_outside(0.0, 0.02)
        assert found is not None
        assert abs(found.place - truth) < max(0.05, 2.0 * found.standard)


@pytest.mark.parametrize("phase", [0.3, *at_length(0.0, 0.6, 0.9)])
def test_a_trough_two_rows_after_its_peak_is_found_between_rows(phase: float) -> None:
    random = np.random.default_rng(13)
    late = np.maximum(np.arange(460.0) - 60 - phase, 0.0)
    y = 1.0 - np.exp(-late / 4.0) * np.cos(2.0 * math.pi * late / 5.0)
    fine = np.arange(0.0, 20.0, 1e-3)
    course = 1.0 - np.exp(-fine / 4.0) * np.cos(2.0 * math.pi * fine / 5.0)
    truth = 1.0 - float(np.min(course[np.argmax(course) :]))
    found = [_measured(y + 3e-3 * random.standard_normal(len(y)), 60)["undershoot"] for _ in range(6)]
    assert np.sqrt(np.mean([_relative(each, truth) ** 2 for each in found])) < 1.8


def test_the_peak_of_a_ringing_answer_is_no_corner_and_that_of_a_limited_one_is() -> None:
    rows = np.arange(-30.0, 31.0)
    noise = 4e-3 * np.random.default_rng(2).standard_normal(len(rows))
    of_noise = Noise(np.array([1.6e-5]))
    assert corner_near(1.4 - 0.2 * (rows / 20.0) ** 2 + noise, of_noise, 30) is None
    found = corner_near(1.4 + np.minimum((rows - 1.3) / 60.0, (1.3 - rows) / 200.0) + noise, of_noise, 30)
    assert found is not None
    assert found.probability > 0.9
    assert found.place == pytest.approx(31.3, abs=3.0 * found.place_error)
    assert found.height == pytest.approx(1.4, abs=3.0 * found.height_error)


def test_a_signal_that_walks_at_rest_has_no_numbers_and_1_over_f_noise_has() -> None:
    random = np.random.default_rng(14)
    rows, refused = 2400, {"walk": 0, "1/f": 0}
    y = 1.0 - np.exp(-np.maximum(np.arange(float(rows)) - 500, 0.0) / 20.0)
    frequency = np.maximum(np.arange(4 * rows + 1), 1.0)
    for _ in range(5):
        walk = 2e-3 * random.standard_normal(rows) + np.cumsum(4e-4 * random.standard_normal(rows))
        bins = np.fft.rfft(random.standard_normal(8 * rows)) / np.sqrt(frequency)
        pink = np.fft.irfft(bins)[:rows]
        for name, noise in (("walk", walk), ("1/f", 0.01 * pink / np.std(pink))):
            found = _measured(y + noise, 500)["plateau_mean"]
            refused[name] += "wanders" in found.reason
    assert refused["walk"] >= 4
    assert refused["1/f"] <= 1


def test_a_clipped_overshoot_is_none() -> None:
    random, root = np.random.default_rng(3), math.sqrt(1.0 - 0.3**2)
    row = 0.06 * np.maximum(np.arange(800.0) - BEFORE, 0.0)
    y = 1.0 - np.exp(-0.3 * row) * (np.cos(root * row) + 0.3 / root * np.sin(root * row))
    noisy = y + 2e-3 * random.standard_normal(len(y))
    whole, clipped = (_measured(each) for each in (noisy, np.minimum(noisy, 1.15)))
    assert whole["overshoot"].value == pytest.approx(0.37, abs=0.01)
    assert math.isnan(clipped["overshoot"].value)
    assert "overshoot is clipped" in clipped["overshoot"].reason
    # a level at rest in steps of a converter is none
    assert math.isfinite(_measured(np.round(noisy, 2))["overshoot"].value)


def test_a_corner_just_after_its_row_is_as_uncertain_as_the_courses_bend() -> None:
    late = np.arange(-20.0, 21.0) - 0.003
    course = np.where(late < 0.0, 0.015 * late, 0.15 * np.exp(-np.maximum(late, 0.0) / 45.0) - 0.15)
    found = kink(course, 20, 0.0)
    assert found is not None
    assert abs(found.above + float(course[20])) < 2.0 * found.above_error
    assert found.above_error < 2e-4


def test_a_corner_without_noise_is_known_between_rows() -> None:
    row, corner = np.arange(1000.0) - BEFORE, 84.3
    falls = 1.0 + 0.2 * np.exp(-np.maximum(row - corner, 0.0) / 50.0)
    found = _measured(np.where(row < corner, 1.2 / corner * np.maximum(row, 0.0), falls))["peak_time"]
    assert found.uncertainty is not None
    assert found.uncertainty.standard < 0.02 / RATE_HZ
    assert abs(_relative(found, corner / RATE_HZ)) < 2.0


def test_what_follows_a_crest_is_uncertain_by_which_crest_is_the_greatest() -> None:
    """Crests that decay by a tenth each, in noise as large as they differ by."""
    random, missed = np.random.default_rng(6), []
    at = np.arange(400.0)
    course = 0.01 * np.exp(-at / 200.0) * np.cos(2.0 * np.pi * at / 40.0)
    for _ in range(40):
        noise = random.standard_normal((61, len(at) + 10)).cumsum(axis=1)
        noise = 5e-4 * (noise[:, 10:] - noise[:, :-10])
        found, standard = NoisyCurve(course + noise[0], noise[1:]).least_after_greatest()
        missed.append((found - float(np.min(course))) / standard)
    assert 0.6 < float(np.sqrt(np.mean(np.square(missed)))) < 1.4


def test_a_trough_that_stands_alone_is_as_uncertain_as_the_least_of_its_rows() -> None:
    """Under a ripple, of which each record has a crest about the lowest row."""
    random, missed = np.random.default_rng(8), []
    at = np.arange(-60.0, 60.0)
    course = np.where(at < -50.0, 0.1, 2e-4 * at**2)
    for _ in range(60):
        phases = random.uniform(0.0, 2.0 * np.pi, (61, 1))
        noise = 0.01 * np.cos(2.0 * np.pi * at / 13.7 + phases) + 1e-3 * random.standard_normal((61, len(at)))
        found, standard = NoisyCurve(course + noise[0], noise[1:]).against(-1.0).greatest(kinked=True)
        missed.append(found / standard)
    assert 0.7 < float(np.sqrt(np.mean(np.square(missed)))) < 1.4


def test_a_trough_is_as_deep_as_without_the_windows_that_cut_it_off() -> None:
    random = np.random.default_rng(7)
    row = np.arange(1200.0) - BEFORE
    peak, trough = np.exp(-(((row - 70.0) / 18.0) ** 2)), np.maximum(0.0, 1.0 - np.abs(row - 140.0) / 18.0)
    y = np.clip(row / 30.0, 0.0, 1.0) + 0.3 * peak - 0.2 * trough
    found = [_measured(y + 0.02 * random.standard_normal(len(y)))["undershoot"] for _ in range(8)]
    assert np.sqrt(np.mean([_relative(each, 0.2) ** 2 for each in found])) < 1.4


def test_windows_do_to_a_trough_what_they_do_to_a_peak() -> None:
    at = np.arange(61.0) - 30.0
    sharp, blunt = np.exp(-((at / 9.0) ** 2)), 0.9 * np.exp(-((at / 10.0) ** 2))
    lower, later = NoisyCurve(-sharp, np.empty((0, 61)), longer=-blunt).against(-1.0).blunted()
    assert lower == pytest.approx(0.1)
    assert later == pytest.approx(0.0)


@pytest.mark.parametrize("height", [1.5, 2.5, 4.0])
def test_a_low_crest_beside_a_plateau_has_the_noise_of_its_rows(height: float) -> None:
    """As high as the noise makes the plateau, which the greatest value is therefore taken to be part of."""
    random, row = np.random.default_rng(3), np.arange(1000.0)
    course = height * np.exp(-0.5 * ((row - 80.0) / 25.0) ** 2)
    relative = []
    for _ in range(30):
        noise = ndimage.gaussian_filter1d(random.standard_normal((81, 1100)), 8.0, axis=1)[:, 50:-50]
        noise /= np.std(noise)
        found, standard = NoisyCurve(course + noise[0], noise[1:]).greatest(kinked=True)
        relative.append((found - height) / standard)
    assert float(np.mean(np.abs(relative) <= 2.0)) >= 0.9


def test_a_lag_that_noise_reads_there_and_back_on_steps_has_no_undershoot_for_certain() -> None:
    """The noise is a tenth of a step, and shows where the lag passes to the last level."""
    random = np.random.default_rng(4)
    late = np.maximum(np.arange(1200.0) - BEFORE, 0.0)
    relative = []
    for _ in range(6):
        y = 1.0 - np.exp(-late / 40.0) + 2e-3 * random.standard_normal(len(late))
        relative.append(_relative(_measured(np.round(y / 0.02) * 0.02)["undershoot"], 0.0))
    assert max(relative) < 2.0


def test_steps_of_a_converter_make_no_corner_of_a_smooth_peak() -> None:
    """Noise at rest is a tenth of a step; on the way through the levels the steps are noise."""
    rows, step = np.arange(-30.0, 31.0), 0.02
    noise = 1.6e-3 * np.random.default_rng(3).standard_normal(len(rows))
    missed = []
    for place in np.linspace(-0.5, 0.5, 5).tolist():
        course = 1.25 - 0.2 * ((rows - place) / 20.0) ** 2 + 0.04 * ((rows - place) / 20.0) ** 3 + noise
        found = corner_near(np.round(course / step) * step, Noise(np.array([2.6e-6])), 30, step)
        missed.append(
            0.0 if found is None else found.averaged((30.0, 2.0), (found.place, found.place_error))[0] - 30.0
        )
    assert max(np.abs(missed)) < 2.0


def test_smoothed_readings_that_happen_to_be_alike_are_no_level_of_a_converter() -> None:
    """Means of readings in steps are often alike a few rows apart, where noise decides which is greatest."""
    random = np.random.default_rng(21)
    rows, true = np.arange(400.0), 205.0
    late = []
    for _ in range(20):
        drawn = ndimage.uniform_filter1d(random.standard_normal((41, 400)), 25, axis=1)
        values = np.round(1.0 - (rows - true) ** 2 / 4e4 + 0.02 * drawn[0], 3)
        top = int(np.argmax(values))
        values[top + 2] = values[top]
        curve = NoisyCurve(values, 0.02 * drawn[1:], beside=np.full(400, 0.98))
        found = curve.place_of_greatest()
        late.append((found.place - true) / found.standard)
    assert 0.5 < np.sqrt(np.mean(np.square(late))) < 1.5
    read = replace(curve, beside=np.zeros(400))  # the samples themselves are on levels
    assert read.place_of_greatest().standard < 2.0
