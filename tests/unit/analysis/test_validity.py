"""What makes a record no record of its signal: values that stand still, and steps of an angle."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.resolution import (
    resolution,
    step_of_counts,
    step_of_even_counts,
)
from benchtool.analysis.validity import standing

SINE = np.cos(2.0 * np.pi * np.arange(20_000) / 500)


def held(samples: np.ndarray, rows: int) -> np.ndarray:
    """Return the samples with so many that repeat the one in row 7100, where the sine falls."""
    repeated = samples.copy()
    repeated[7100 : 7100 + rows] = repeated[7100]
    return repeated


@pytest.mark.parametrize("step", [0.0, 1e-3])
def test_values_that_stand_still_while_the_signal_goes_on_are_told(step: float) -> None:
    samples = np.round(SINE / step) * step if step else SINE
    assert standing(samples) == ""
    assert standing(held(samples, 60)).startswith("60 samples in a row from row 7100")


@pytest.mark.parametrize("step", [0.008, 0.03, 0.2])
def test_the_crest_of_a_wave_in_steps_does_not_stand_still(step: float) -> None:
    assert standing(np.round(SINE / step) * step) == ""


def test_a_signal_of_levels_does_not_stand_still() -> None:
    """Values that stay, as those of a slow sensor or of a logic level, are no fault of one place."""
    levels = np.repeat(np.random.default_rng(0).standard_normal(200), 100)
    assert standing(levels) == ""
    assert standing(np.ones(100)) == ""


def test_an_angle_at_constant_speed_counts_in_no_steps() -> None:
    even = 0.01 * np.arange(5000.0)
    assert step_of_counts(even, resolution(even)) == 0.0
    counted = np.floor(even / 0.007) * 0.007
    assert step_of_counts(counted, resolution(counted)) == pytest.approx(0.007)


@pytest.mark.parametrize(("counts", "a_row"), [(4096, 14), (1000, 7), (2500, 3)])
def test_an_angle_that_turns_whole_counts_between_rows_counts_in_steps(counts: int, a_row: int) -> None:
    """The rest of its counts shows where a turn is no multiple of what it turns between rows."""
    step = 2 * np.pi / counts
    angle = 0.3 + a_row * step * np.arange(500.0)
    shared = np.gcd(counts, a_row)
    found = step_of_even_counts(angle)
    assert found == pytest.approx(shared * step if a_row > shared else 0.0)


def test_a_computed_angle_counts_in_no_steps() -> None:
    assert step_of_even_counts(0.3 + 0.0123456 * np.arange(5000.0)) == 0.0
    assert step_of_even_counts(2 * np.pi / 200 * np.arange(5000.0)) == 0.0  # back after 200 rows
    assert step_of_even_counts(np.cumsum(0.01 + 1e-6 * np.arange(500.0))) == 0.0
