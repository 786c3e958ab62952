"""The step of a converter by the levels that it shows."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import analyze_step
from benchtool.analysis.quantisation.resolution import (
    counting_step,
    largest_even_step,
    resolution,
    step_between,
    step_of_counts,
)
from benchtool.block import Block


@pytest.mark.parametrize("seed", range(5))
def test_few_levels_tell_the_step_that_they_are_whole_numbers_of_apart(seed: int) -> None:
    random = np.random.default_rng(seed)
    step, level = 0.01 * random.uniform(0.1, 1.0), np.sort(random.choice(2_000, 8, replace=False))
    found = step_between(17.3 + step * np.append(level, level[-1] + 1), 16)
    assert found == pytest.approx(step, rel=1e-6)


def test_values_anywhere_and_few_values_have_no_step_between_them() -> None:
    random = np.random.default_rng(3)
    assert not any(step_between(np.sort(random.standard_normal(9)), 16) for _ in range(200))
    assert step_between(1.0 - np.exp(-np.arange(12.0) / 2.1), 16) == 0.0
    assert step_between(np.linspace(0.0, 1.0, 9), 16) == 0.0  # few steps of a ramp that was drawn
    assert step_between(np.array([0.0, 0.3, 1.0]), 2) == 0.0


def test_an_answer_of_few_levels_leaves_a_step_of_the_converter_open() -> None:
    """It is over in few rows: the mean at rest had an uncertainty of 1e-16."""
    rows = np.arange(240)
    smooth = np.where(rows < 102, 0.0, 1.0 - np.exp(-np.maximum(rows - 101.3, 0.0) / 2.3))
    step = 1.0 / 64.0
    y = step * np.round((smooth - 0.3 * step) / step) + 0.3 * step
    block = Block.from_arrays(1e3, {"y": "Nm", "r": "Nm"}, y=y, r=np.where(rows < 100, 0.0, 1.0))
    found = {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}
    mean = found["tracking_error_mean"]
    assert mean.uncertainty is not None
    assert 0.9 < mean.uncertainty.standard / (step / math.sqrt(12.0)) < 1.5
    assert abs(mean.value) < 2.0 * mean.uncertainty.standard


PLACES = np.cos(2.0 * np.pi * np.arange(20_000) / 200.0 + 0.4) + 0.01 * np.cos(
    np.pi * np.arange(20_000) / 20.0
)


@pytest.mark.parametrize(
    ("step", "is_32_bit"), [(0.0117, False), (3.1e-4, False), (2.1e-5, False), (0.0117, True), (3.1e-4, True)]
)
def test_few_places_of_a_period_tell_the_step_of_a_converter(step: float, is_32_bit: bool) -> None:
    read = 0.6 * step + step * np.round(5.0 * PLACES / step)
    read = read.astype(np.float32).astype(np.float64) if is_32_bit else read
    assert resolution(read) == pytest.approx(step, rel=1e-3)
    assert counting_step(read) == (resolution(read) if step > 1e-4 else 0.0)


@pytest.mark.parametrize("digits", [3, 6, 9])
def test_few_places_of_a_period_tell_the_digits_of_a_text(digits: int) -> None:
    read = np.round(1.5 * PLACES, digits)
    assert resolution(read) == pytest.approx(10.0**-digits)
    assert counting_step(read) == (resolution(read) if digits == 3 else 0.0)


def test_values_that_were_computed_have_no_step_but_their_rounding() -> None:
    assert resolution(1.5 * PLACES) < 1e-15
    assert resolution((1.5 * PLACES).astype(np.float32).astype(np.float64)) == pytest.approx(2.0**-23)
    assert resolution(np.random.default_rng(0).standard_normal(300)) == 0.0
    assert counting_step(np.random.default_rng(0).standard_normal(300)) == 0.0
    assert resolution(np.full(9, 1.5)) == resolution(np.array([])) == 0.0
    assert resolution(np.array([1.0, 1.0, 1.25, 3.0])) == 0.25


@pytest.mark.parametrize("largest", [5e-324, 1e-300, 1e-40, 1e39, 1e300])
def test_numbers_of_any_size_have_a_resolution(largest: float) -> None:
    found = resolution(largest * np.sin(np.arange(9.0)))
    assert 0.0 <= found <= largest


@pytest.mark.parametrize("counts", [500, 4096, 10_000, 65_536])
def test_an_encoder_is_told_from_an_angle_in_32_bits(counts: int) -> None:
    """The least distance of two levels is rounded, and a thousand times that is no level any more."""
    rows, turn = np.arange(4500), 2.0 * np.pi
    for begin in (0.003, 2.1, 4.6):
        theta = begin + 31.42e-4 * rows + 1e-3 * np.sin(2e-3 * rows)
        read = np.mod(np.floor(theta * counts / turn) * (turn / counts), turn)
        step = resolution(read.astype(np.float32).astype(np.float64))
        assert step == pytest.approx(turn / counts, rel=1e-6)
        assert step_of_counts(np.unwrap(read.astype(np.float32).astype(np.float64)), step) == step
        computed = np.mod(theta, turn).astype(np.float32).astype(np.float64)
        assert step_of_counts(np.unwrap(computed), resolution(computed)) == 0.0


@pytest.mark.parametrize("is_32_bit", [False, True])
def test_an_encoder_that_passes_whole_counts_in_every_row_is_told(is_32_bit: bool) -> None:
    """Five of ten thousand counts in each row, and two turns of what a computation gives."""
    turn, rows = 2.0 * np.pi, np.arange(4500)
    for begin in (0, 3, 9998):
        read = np.mod(begin + 5 * rows, 10_000) * (turn / 10_000)
        computed = np.mod(begin + 0.1234 + 5.0017 * rows, 10_000.0) * (turn / 10_000)
        if is_32_bit:
            read, computed = (each.astype(np.float32).astype(np.float64) for each in (read, computed))
        assert largest_even_step(np.unwrap(read)) == pytest.approx(5 * turn / 10_000, rel=1e-6)
        assert largest_even_step(np.unwrap(computed)) == 0.0


def test_a_distance_that_rounds_by_more_than_a_step_is_no_number_of_them() -> None:
    for least in (2.225073858507203e-309, 1e-200, 1e-20):
        assert resolution(np.array([0.0, 1.0, least])) == least


@pytest.mark.parametrize("turns", [10.0, 3000.0])
def test_a_speed_that_was_computed_of_counts_has_their_step(turns: float) -> None:
    """Its values are whole numbers of it but for the rounding of the angle, which was taken for the step."""
    count_rad, rate_Hz = 2.0 * math.pi / 65_536, 5000.0
    place = turns * 65_536 * np.linspace(0.0, 1.0, 20_000)
    place += 2.0 * np.sin(np.linspace(0.0, 400.0, len(place)))
    speed = np.gradient(np.floor(place) * count_rad) * rate_Hz
    assert len(np.unique(speed)) >= 30
    for found in (resolution(speed), counting_step(speed)):
        assert found == pytest.approx(0.5 * count_rad * rate_Hz, rel=1e-6)


def test_values_anywhere_differ_by_no_rounding() -> None:
    """Between the least step of many and the others are others of any size."""
    samples = np.random.default_rng(2).standard_normal(20_000)
    assert resolution(samples) == 0.0
    assert counting_step(samples) == 0.0


def test_rows_that_keep_step_with_an_encoder_hide_no_count() -> None:
    """Places 128 to 134 counts apart are nearly whole steps of 128 to the next few, and farther away not."""
    count_rad = 2.0 * math.pi / 65_536
    turned = np.arange(5000) / 500.0
    place = np.floor(65_536 * (turned + 0.02 / 6.0 / (2.0 * math.pi) * np.sin(12.0 * math.pi * turned) + 0.1))
    assert counting_step(np.mod(place, 65_536.0) * count_rad) == pytest.approx(count_rad, rel=1e-6)
