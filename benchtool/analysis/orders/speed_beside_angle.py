"""Mean of a measured speed, whose course the rotor's angle or the phase of a current tells too: what both
have in common is no error of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import unwrapped_angle
from benchtool.analysis.periods import track_tone
from benchtool.analysis.statistics.repeatability import wander_of_difference
from benchtool.analysis.statistics.scatter import MeanError, error_of_record
from benchtool.analysis.uncertainty import Contribution
from benchtool.errors import AnalysisError

Floats = NDArray[np.float64]

_FEWEST = 20  # samples


@dataclass(frozen=True)
class SpeedBesideAngle:
    """Error of the mean of a measured speed as the mean speed in its record, by what it reads beside the
    course that `channel` tells; `between_records` is how much the mean speed of another record differs."""

    error: MeanError
    between_records: Contribution | None
    channel: str

    @classmethod
    def of(cls, omega_m: Floats, angle_rad: Floats, sample_rate_Hz: float, channel: str) -> SpeedBesideAngle:
        """Return that of a speed, rad/s, beside an angle without jumps, both of shape (n,).

        The angle at both ends tells the mean speed, whatever it does in between. What the speed reads beside
        the differences of the angle has the errors of both: those of the angle are taken back by the next
        difference, and leave the mean those at the ends.
        """
        between = None
        beside = 0.5 * (omega_m[1:] + omega_m[:-1]) - sample_rate_Hz * np.diff(angle_rad)
        wander, duration_s = wander_of_difference(angle_rad), (len(angle_rad) - 1) / sample_rate_Hz
        if math.isfinite(wander.standard):
            name = f"wander of the speed, by that of the course of {channel} within the record"
            between = Contribution(name, "A", wander.standard / duration_s, wander.dof)
        return cls(error_of_record(beside), between, channel)


def speed_beside_angle(
    omega_m: Floats,
    sample_rate_Hz: float,
    theta_m: Floats | None = None,
    i_a: Floats | None = None,
    pole_pairs: int = 1,
) -> SpeedBesideAngle | None:
    """Return the error of the mean of a speed, rad/s, beside an angle, rad, or else a phase current, all of
    shape (n,); None where neither tells it better than the speed's own scatter."""
    if len(omega_m) < _FEWEST:
        return None
    try:
        if theta_m is not None:
            found = SpeedBesideAngle.of(omega_m, unwrapped_angle(theta_m), sample_rate_Hz, "theta_m")
        elif i_a is not None:
            rows, phase_rad = _phase_of(i_a)
            if len(rows) < _FEWEST:
                return None
            found = SpeedBesideAngle.of(omega_m[rows], phase_rad / pole_pairs, sample_rate_Hz, "i_a")
        else:
            return None
    except AnalysisError:
        return None
    own = error_of_record(omega_m).standard
    return found if found.error.standard < (own if math.isfinite(own) else math.inf) else None


def _phase_of(current: Floats) -> tuple[NDArray[np.int64], Floats]:
    """Return rows and the phase of the fundamental of a current, shape (n,), rad, over a period about each:
    its harmonics have no mean over that.

    Raises:
        AnalysisError: as `track_tone`.
    """
    track = track_tone(current, "i_a")
    along_rad, half = track.at(np.arange(len(current), dtype=np.float64)), 0.5 * len(current) / track.periods
    sums = np.concatenate([[0.0], np.cumsum(current * np.exp(-1j * along_rad))])
    rows = np.arange(math.ceil(half), len(current) - math.ceil(half))
    number, middle = np.arange(len(sums)), rows + 0.5
    after, before = (
        np.interp(at, number, sums.real) + 1j * np.interp(at, number, sums.imag)
        for at in (middle + half, middle - half)
    )
    return rows, along_rad[rows] + np.unwrap(np.angle(after - before))
