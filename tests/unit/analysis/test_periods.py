"""Places of electrical periods along a track."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.errors import AnalysisError


def test_the_first_period_begins_at_row_0_though_the_phase_turns_back_there() -> None:
    """An angle that is held for ten rows leaves a curve through it that falls for one."""
    speed, rows = 0.027, 5_000
    held = np.zeros(rows)
    held[1:10] = -1.01 * speed
    track = PhaseTrack(
        Polynomial([0.4, speed]), rows, "an angle", departure=lambda at: np.interp(at, np.arange(rows), held)
    )
    assert track.at(np.array([1.0]))[0] < track.at(np.array([0.0]))[0]
    marks = track.period_marks()
    assert marks[0] == track.period_rows()[0] == 0
    np.testing.assert_allclose(np.diff(marks), 2 * np.pi / speed, atol=1.1)


@pytest.mark.parametrize("stands", [slice(2000, None), slice(0, 1500), slice(1000, 4000)])
def test_an_angle_that_stands_still_is_told_as_such(stands: slice) -> None:
    """The speed was said to change by 449 %, or the angle to cover no period."""
    theta_m = np.mod(
        0.006 * np.arange(5000) + 1e-5 * np.random.default_rng(0).standard_normal(5000), 2 * np.pi
    )
    theta_m[stands] = theta_m[stands][0]
    with pytest.raises(
        AnalysisError, match=r"^'theta_m': \d+ samples in a row .* stood still, or the rotor did"
    ):
        track_angle(theta_m, 4)


def test_a_start_of_constant_amplitude_is_no_amplitude_that_changes() -> None:
    time_s = np.arange(10_000) / 5e3
    turned = 40.0 * (time_s + 0.2 * np.expm1(-time_s / 0.2))
    current = 5.0 * np.cos(2.0 * np.pi * turned)
    with pytest.raises(AnalysisError, match=r"^the frequency of .* the machine starts, stops or changes"):
        track_tone(current)
    with pytest.raises(AnalysisError, match=r"^the amplitude of"):
        track_tone((1.0 + 0.3 * time_s) * np.cos(2.0 * np.pi * 40.0 * time_s))
