"""Places of electrical periods along a track."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from benchtool.analysis.periods import PhaseTrack


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
