"""Where electrical periods begin, by which other signals are parted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.angle_following import along_angle
from benchtool.analysis.phase.phase_following import follow
from benchtool.errors import AnalysisError


@dataclass(frozen=True)
class PeriodMarks:
    """The sample `numbers` at which periods begin, the first 0, and at which the last one ends, shape
    (periods + 1,); `as_far` are the rows in which each turns as far as the record does behind the last of
    them, and at last the rows behind that, of the same shape, None where the phase there is not told."""

    numbers: NDArray[np.float64]
    as_far: NDArray[np.float64] | None = None

    @classmethod
    def of(cls, track: PhaseTrack) -> PeriodMarks:
        """Return those of a track."""
        numbers = track.period_marks()
        return cls(numbers, track.rows_as_far(numbers))


def marks_of_rotor(track: PhaseTrack) -> PeriodMarks:
    """Return where periods begin by where the rotor is, also while its speed swings, if the track was made
    from an angle that departs from it, or follows a signal."""
    tracks = along_angle(track, track.samples / track.periods)
    return PeriodMarks.of(tracks.within or tracks.of_periods or track)


def marks_of_tone(current: NDArray[np.float64], sample_rate_Hz: float, track: PhaseTrack) -> PeriodMarks:
    """Return where periods begin without an angle: where the phase of the current is that gave the track,
    shape (n,), also while its frequency changes."""
    try:
        return PeriodMarks.of(follow(current, sample_rate_Hz, track)[1])
    except AnalysisError:  # too short, or too fast, to be followed
        return PeriodMarks.of(track)
