"""Where electrical periods begin, by which other signals are parted."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.angle_following import along_angle
from benchtool.analysis.phase.phase_following import follow
from benchtool.errors import AnalysisError


def marks_of_rotor(track: PhaseTrack) -> NDArray[np.float64]:
    """Return the sample numbers at which periods begin, shape (periods + 1,): where the rotor is, also while
    its speed swings, if the track was made from an angle that departs from it, or follows a signal."""
    tracks = along_angle(track, track.samples / track.periods)
    return (tracks.within or tracks.of_periods or track).period_marks()


def marks_of_tone(
    current: NDArray[np.float64], sample_rate_Hz: float, track: PhaseTrack
) -> NDArray[np.float64]:
    """Return the sample numbers at which periods begin, shape (periods + 1,), without an angle: where the
    phase of the current is that gave the track, shape (n,), also while its frequency changes."""
    try:
        return follow(current, sample_rate_Hz, track)[1].period_marks()
    except AnalysisError:  # too short, or too fast, to be followed
        return track.period_marks()
