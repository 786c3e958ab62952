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

    @classmethod
    def of_angle(cls, angle_rad: NDArray[np.float64], turn_rad: float) -> PeriodMarks | None:
        """Return where turns begin of an angle without wraps, shape (n,), of either direction and any speed;
        None where it stands, turns back, counts in steps or has fewer than one turn."""
        travelled = np.abs(angle_rad - angle_rad[0])
        if not np.all(np.diff(travelled) > 0.0):
            return None
        rows = np.arange(len(travelled) + 1.0)
        travelled = np.append(travelled, 2.0 * travelled[-1] - travelled[-2])
        turns = int(travelled[-2] / turn_rad)
        if turns < 1:
            return None
        begins = turn_rad * np.arange(turns + 1.0)
        numbers = np.interp(begins, travelled, rows)
        reached = np.interp(begins + travelled[-1] - begins[-1], travelled, rows)
        return cls(numbers, reached - numbers)


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
