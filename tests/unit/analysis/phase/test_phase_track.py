"""Sample numbers of a phase that departs from its polynomial."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.periods import PhaseTrack

Array = NDArray[np.float64]
SAMPLES, STEP_RAD = 2_000, 0.02
LINEAR = Polynomial([0.0, STEP_RAD])


def test_a_curve_that_leaves_the_record_steeply_is_not_followed_out_of_it() -> None:
    def cubic(numbers: Array) -> Array:  # flat within the record, and far beyond any phase soon after it
        return np.asarray(0.05 * np.sin(0.01 * numbers) - np.maximum(0.0, numbers - SAMPLES + 1.0) ** 3)

    track = PhaseTrack(LINEAR, SAMPLES, "as it was made", departure=cubic)
    phase = np.linspace(0.0, STEP_RAD * (SAMPLES + 5.0), 900)
    numbers = track.sample_numbers(phase)
    assert np.all(np.diff(numbers) > 0.0)
    np.testing.assert_allclose(track.at(numbers), phase, atol=1e-4)


def test_a_phase_that_turns_back_for_a_moment_has_sample_numbers_in_order() -> None:
    def notched(numbers: Array) -> Array:
        return np.asarray(-0.5 * np.exp(-(((numbers - 1000.0) / 5.0) ** 2)))

    track = PhaseTrack(LINEAR, SAMPLES, "as it was made", departure=notched)
    numbers = track.sample_numbers(np.linspace(1.0, 39.0, 500))
    assert np.all(np.isfinite(numbers))
    assert np.all(np.diff(numbers) >= 0.0)
