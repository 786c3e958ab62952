"""The least-squares line through samples that are evenly apart: against numpy, and on lines themselves."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.statistics.straight_lines import (
    places_about_middle,
    slope_of,
    slope_weights,
    without_slope,
)


@pytest.mark.parametrize("count", [2, 3, 20, 101])
def test_the_slope_is_that_of_least_squares(count: int) -> None:
    samples = np.random.default_rng(count).standard_normal(count) + 3.0
    slope, _ = np.polyfit(np.arange(count), samples, 1)
    assert slope_of(samples) == pytest.approx(slope, rel=1e-9)
    assert float(slope_weights(count) @ samples) == slope_of(samples)


def test_a_line_has_its_slope_and_is_level_without_it() -> None:
    line = 5.0 - 0.25 * np.arange(9, dtype=np.float64)
    assert slope_of(line) == pytest.approx(-0.25, rel=1e-12)
    assert without_slope(line) == pytest.approx(np.full(9, 4.0), rel=1e-12)


def test_places_are_about_the_middle_and_weights_leave_no_mean() -> None:
    assert places_about_middle(4).tolist() == [-1.5, -0.5, 0.5, 1.5]
    assert places_about_middle(1).tolist() == [0.0]
    assert float(np.sum(slope_weights(7))) == pytest.approx(0.0, abs=1e-15)
