"""Levels of a converter that a curve passes, and those within which it turns back."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import analyze_step
from benchtool.analysis.steps.converter_levels import (
    at_turns,
    left_beside_a_line,
    left_on_a_course,
    within_levels,
)
from benchtool.analysis.steps.noisy_curve import NoisyCurve
from benchtool.analysis.steps.smoothing import Noise
from benchtool.block import Block

Floats = NDArray[np.float64]

_ROWS = np.arange(400.0)
_STEP = 0.3
_DRAWS = 80


def _lobe(crest: float, half_period: float, damping: float, height: float) -> Floats:
    """Return one crest of a decaying oscillation, with rest before and after."""
    phase = np.clip(np.pi * (_ROWS - crest) / half_period, -0.8 * np.pi, 1.5 * np.pi)
    decay = damping / np.sqrt(1.0 - damping**2)
    course = np.exp(-decay * phase) * (np.cos(phase) + decay * np.sin(phase))
    return np.asarray(height * course)


def test_a_turn_within_a_level_is_as_far_beyond_its_edge_as_widths_tell() -> None:
    random, missed, anywhere = np.random.default_rng(21), [], []
    for _ in range(150):
        crest, offset = 200.0 + random.uniform(), random.uniform(-0.5, 0.5)
        lobe = _lobe(crest, random.uniform(30.0, 120.0), random.uniform(0.05, 0.5), random.uniform(3.0, 30.0))
        samples = np.round(lobe + offset)
        errors = within_levels(random, samples, 1.0, _DRAWS)
        row = round(crest)
        turned = (samples + at_turns(random, samples, 1.0, errors))[:, row]
        truth = lobe[row] + offset
        missed.append((np.mean(turned) - truth, np.std(turned)))
        anywhere.append(samples[row] - truth)
    error, standard = np.array(missed).T
    assert np.mean(np.abs(error) < 2.0 * standard + 0.02) > 0.9
    assert np.sqrt(np.mean(error**2)) < 0.6 * np.sqrt(np.mean(np.square(anywhere)))
    assert np.sqrt(np.mean(error**2)) == pytest.approx(np.sqrt(np.mean(standard**2)), rel=0.4)


def test_a_level_that_is_left_for_good_or_much_faster_on_one_side_is_no_turn() -> None:
    passes = np.repeat([0.0, 1.0, 2.0, 3.0, 4.0], 20)
    tail = np.repeat([0.0, 1.0, 2.0, 1.0, 0.0], [20, 1, 12, 40, 20])
    for samples in (passes, tail):
        errors = within_levels(np.random.default_rng(1), samples, 1.0, _DRAWS)
        assert np.array_equal(at_turns(np.random.default_rng(2), samples, 1.0, errors), errors)


def _is_turned(samples: Floats) -> bool:
    errors = within_levels(np.random.default_rng(1), samples, 1.0, _DRAWS)
    return not np.array_equal(at_turns(np.random.default_rng(2), samples, 1.0, errors), errors)


def test_a_lobe_that_chatters_is_a_turn_where_most_of_its_rows_are_on_the_level() -> None:
    rise, fall = np.repeat([0.0, 1.0], [20, 6]), np.repeat([1.0, 0.0], [6, 20])
    mostly, seldom = np.array([2.0, 1.0, 2.0, 2.0, 2.0, 1.0, 2.0]), np.array([2.0, 1.0, 1.0, 1.0, 1.0, 2.0])
    assert _is_turned(np.concatenate([rise, mostly, fall]))
    assert not _is_turned(np.concatenate([rise, seldom, fall]))


def test_three_widths_tell_a_corner_from_a_smooth_top() -> None:
    heights = []
    for third in (8, 5):  # rows that the third level is wider by on either side: as the second, or less
        samples = np.repeat([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0], [40, third, 8, 8, 8, third, 40])
        errors = within_levels(np.random.default_rng(1), samples, 1.0, 2000)
        turned = at_turns(np.random.default_rng(2), samples, 1.0, errors)
        heights.append(float(np.mean(np.max(turned[:, 40 + third + 8 : 48 + third + 8], axis=1))) + 0.5)
    # on average over powers: from 1 to 2 of the corner, hardly less than 2 of the smooth one
    powers = np.linspace(1.0, 2.0, 101)
    assert heights[0] == pytest.approx(float(np.mean(1.0 / (3.0**powers - 1.0))), rel=0.12)
    assert heights[1] == pytest.approx(1.0 / (3.0**2 - 1.0), rel=0.35)


def test_a_level_that_is_wider_by_one_row_alone_tells_nothing() -> None:
    assert _is_turned(np.repeat([0.0, 1.0, 2.0, 1.0, 0.0], [20, 1, 12, 1, 20]))
    assert not _is_turned(np.repeat([0.0, 1.0, 2.0, 0.0], [20, 1, 12, 20]))


@pytest.mark.parametrize("beyond", [0.03, 0.1, 0.6, 0.8])
def test_a_lobe_that_just_reaches_a_level_has_left_a_band_or_not(beyond: float) -> None:
    """Lobes that decay by a third each, the last of which is beyond the edge of a level by a part of it."""
    phase = np.pi * (_ROWS - 230.3) / 50.0
    lobes = (2.5 + beyond) * np.exp(-0.15 * phase) * np.cos(phase)
    band = 2.5 + 0.3
    truth = float(np.flatnonzero(np.abs(lobes) > band)[-1]) + 0.5
    curve = NoisyCurve.through(np.asarray(np.round(lobes), dtype=np.float64), Noise(np.zeros(1)))
    found = curve.last_outside(0.0, band)
    assert found is not None
    assert abs(found.place - truth) < 2.0 * found.standard + 0.5
    assert abs(found.place - truth) < 6.0
    assert found.standard < 12.0


@pytest.mark.parametrize("amplitude", [0.7, 1.0, 1.6, 2.4])
def test_a_ripple_of_a_step_and_more_does_not_hide_the_steps(amplitude: float) -> None:
    step, errors, stated = 0.1, [], []
    for seed in range(150):
        random = np.random.default_rng(seed)
        size = step * amplitude * random.uniform(0.93, 1.07)
        phase = 0.0731 * np.arange(1500) + random.uniform(0.0, 2.0 * np.pi)
        offset = random.uniform(0.0, step)
        ripple = size * np.cos(phase) + 0.02 * step * random.standard_normal(len(phase))
        read = step * np.round((ripple + offset) / step) - offset
        errors.append(float(np.mean(read - ripple)))
        stated.append(left_beside_a_line(read, step))
    assert 0.7 < np.sqrt(np.mean(np.square(errors)) / np.mean(np.square(stated))) < 1.4


@pytest.mark.parametrize("steps", [0.0, 0.6, 1.4, 3.3])
def test_a_course_over_several_levels_leaves_less_of_their_steps(steps: float) -> None:
    course = steps * _STEP * np.linspace(-0.5, 0.5, 400)
    places = _STEP * np.linspace(0.0, 1.0, 200, endpoint=False)
    errors = [np.mean(_STEP * np.round((course + place) / _STEP) - course - place) for place in places]
    of_level = _STEP / math.sqrt(12.0)
    left = left_on_a_course(course, _STEP)
    assert left * of_level == pytest.approx(float(np.sqrt(np.mean(np.square(errors)))), abs=0.02 * _STEP)


def test_what_no_line_makes_is_not_that_of_a_line() -> None:
    random = np.random.default_rng(0)
    assert left_beside_a_line(np.round(random.standard_normal(1000)), 1.0) == 0.0
    assert left_beside_a_line(np.ones(1000), 1.0) == 0.0
    line = 1.3 * np.cos(0.3 * np.arange(1000))
    assert left_beside_a_line(line, 0.0) == 0.0
    noisy, quiet = (
        left_beside_a_line(np.round(line + size * random.standard_normal(1000)), 1.0) for size in (0.3, 0.0)
    )
    assert noisy < 0.5 * quiet  # which hides them


@pytest.mark.parametrize("noise", [0.0, 0.25])
def test_a_level_within_that_in_which_a_lag_comes_to_rest_is_passed_later_than_its_edge(noise: float) -> None:
    """98 % of a step of 50 are up to a tenth of a level above its edge, and the lag stays within that."""
    random, row, lag = np.random.default_rng(5), np.arange(2000.0), 75.0
    relative = []
    for beyond in np.linspace(0.02, 0.18, 9):
        since = np.maximum(row - 500.0 + random.uniform(), 0.0)
        way = 100.0 + beyond + 50.0 * -np.expm1(-since / lag)
        speed = 2.0 * np.round((way + noise * random.standard_normal(len(row))) / 2.0)
        reference = 100.0 + beyond + np.where(row < 500.0, 0.0, 50.0)
        block = Block.from_arrays(5e3, {"y": "rad/s", "r": "rad/s"}, y=speed, r=reference)
        found = analyze_step(block, "y", "r").measurements
        reached = next(each for each in found if each.name == "reach_time")
        if reached.uncertainty is not None:
            error_s = reached.value - lag * np.log(50.0) / 5e3
            relative.append(error_s / reached.uncertainty.standard)
    assert len(relative) >= 7
    assert np.sqrt(np.mean(np.square(relative))) < 1.4
