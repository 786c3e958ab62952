"""Where a response falls to a level slowly, in errors that make it do so more than once."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.responses.response_curve import ResponseCurve
from tests.at_length import at_length

FREQUENCY_HZ = np.arange(20.0, 900.0, 4.0)
QUARTER_TURN = -0.5 * math.pi


def turned(delay_s: float) -> np.ndarray:
    """Return the phase of a lag of 100 Hz behind a delay."""
    return -np.arctan(FREQUENCY_HZ / 100.0) - 2.0 * np.pi * FREQUENCY_HZ * delay_s


@pytest.mark.parametrize("error", [0.02, *at_length(0.08)])
def test_a_shallow_phase_is_where_it_is_said_to_be(error: float) -> None:
    """One parabola in a hundred does not describe its points by chance: a window that ended there was of
    five points, whose slope is that of their errors."""
    random, relative = np.random.default_rng(5), []
    true_Hz = float(np.interp(-QUARTER_TURN, -turned(1e-4), FREQUENCY_HZ))
    for _ in range(80):
        noise = error * (random.standard_normal((2, len(FREQUENCY_HZ))) * np.array([[1.0], [1j]])).sum(axis=0)
        response = np.exp(1j * turned(1e-4)) * (1.0 + noise)
        curve = ResponseCurve.of_phase(FREQUENCY_HZ, response, np.full(len(noise), error), QUARTER_TURN)
        found = curve.falls_to(QUARTER_TURN)
        assert found is not None
        if not found.undefined_because:
            relative.append((found.frequency_Hz - true_Hz) / found.standard_Hz)
    assert len(relative) > 76
    assert 0.7 < float(np.sqrt(np.mean(np.square(relative)))) < 1.3
    assert np.max(np.abs(relative)) < 4.0


def test_one_value_that_is_below_by_chance_is_no_crossing() -> None:
    error = np.full(len(FREQUENCY_HZ), 0.05)
    values = np.where(np.arange(len(FREQUENCY_HZ)) % 2, 0.02, -0.02) - 2e-4 * (FREQUENCY_HZ - 600.0)
    values[80] = -4.0 * 0.05
    found = ResponseCurve(FREQUENCY_HZ, values, error, 10.0).falls_to(0.0)
    assert found is not None
    assert abs(found.frequency_Hz - 600.0) < 2.0 * found.standard_Hz


def test_a_level_that_the_values_hardly_fall_below_is_not_passed() -> None:
    """Of many values at the end some are clearly below by chance, which make the crossing early."""
    random, error, frequency_Hz = np.random.default_rng(8), 0.1, FREQUENCY_HZ[FREQUENCY_HZ < 650.0]
    course, answered = turned(5e-5)[: len(frequency_Hz)], 0  # it is at the level at 560 Hz
    for _ in range(60):
        noise = error * (random.standard_normal((2, len(course))) * np.array([[1.0], [1j]])).sum(axis=0)
        response = np.exp(1j * course) * (1.0 + noise)
        curve = ResponseCurve.of_phase(frequency_Hz, response, np.full(len(noise), error), QUARTER_TURN)
        found = curve.falls_to(QUARTER_TURN)
        answered += found is not None and not found.undefined_because
    assert answered <= 5
