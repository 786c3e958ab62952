"""Mean of a measured speed, whose course the rotor's angle or the phase of a current tells too: what both
have in common is no error of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import unwrapped_angle
from benchtool.analysis.periods import track_tone
from benchtool.analysis.statistics.mean_beside import MeanBeside
from benchtool.analysis.statistics.repeatability import wander_of_difference
from benchtool.analysis.statistics.scatter import error_of_record
from benchtool.analysis.uncertainty import Contribution
from benchtool.errors import AnalysisError

Floats = NDArray[np.float64]

_FEWEST = 20  # samples


def speed_beside_angle(
    omega_m: Floats,
    sample_rate_Hz: float,
    theta_m: Floats | None = None,
    i_a: Floats | None = None,
    pole_pairs: int = 1,
    *,
    angle: str = "theta_m",
    current: str = "i_a",
) -> MeanBeside | None:
    """Return the mean of a speed, rad/s, over all rows, with its error beside an angle, rad, or else a phase
    current, all of shape (n,); None where neither tells it better than the speed's own scatter.

    `angle` and `current` are what messages call them. Either may turn the other way than the speed counts.
    """
    if len(omega_m) < _FEWEST:
        return None
    try:
        if theta_m is not None:
            rows, angle_rad, channel = slice(None), unwrapped_angle(theta_m, angle), angle
        elif i_a is not None:
            rows, phase_rad = _phase_of(i_a, current)
            angle_rad, channel = phase_rad / pole_pairs, current
        else:
            return None
    except AnalysisError:
        return None
    if len(angle_rad) < _FEWEST:
        return None
    found = _beside(omega_m, rows, angle_rad, sample_rate_Hz, channel)
    own = error_of_record(omega_m).standard
    return found if found.error.standard < (own if math.isfinite(own) else math.inf) else None


def _beside(
    omega_m: Floats, rows: slice, angle_rad: Floats, sample_rate_Hz: float, channel: str
) -> MeanBeside:
    """Return the mean of a speed, rad/s, shape (n,), beside an angle of some of its rows without jumps.

    The angle at both ends tells the mean speed, whatever it does in between: the mean is that from the first
    row to the last, which count by half. What the speed reads beside the differences of the angle has the
    errors of both: those of the angle are taken back by the next difference, and leave the mean those at the
    ends.
    """
    between, duration_s = None, (len(angle_rad) - 1) / sample_rate_Hz
    speed = 0.5 * (omega_m[1:] + omega_m[:-1])
    along = sample_rate_Hz * np.diff(angle_rad)
    shared = 0.5 * (omega_m[rows][1:] + omega_m[rows][:-1])
    beside = shared - math.copysign(1.0, float(np.mean(shared)) * float(np.mean(along))) * along
    wander = wander_of_difference(angle_rad)
    if math.isfinite(wander.standard):
        name = f"wander of the speed, by that of the course of {channel} within the record"
        between = Contribution(name, "A", wander.standard / duration_s, wander.dof)
    return MeanBeside(float(np.mean(speed)), error_of_record(beside), between, channel)


def _phase_of(current: Floats, name: str) -> tuple[slice, Floats]:
    """Return rows and the phase of the fundamental of a current, shape (n,), rad, over a period about each:
    its harmonics have no mean over that.

    Raises:
        AnalysisError: as `track_tone`.
    """
    track = track_tone(current, name)
    along_rad, half = track.at(np.arange(len(current), dtype=np.float64)), 0.5 * len(current) / track.periods
    sums = np.concatenate([[0.0], np.cumsum(current * np.exp(-1j * along_rad))])
    rows = slice(math.ceil(half), max(math.ceil(half), len(current) - math.ceil(half)))
    number, middle = np.arange(len(sums)), np.arange(rows.start, rows.stop) + 0.5
    after, before = (
        np.interp(at, number, sums.real) + 1j * np.interp(at, number, sums.imag)
        for at in (middle + half, middle - half)
    )
    return rows, along_rad[rows] + np.unwrap(np.angle(after - before))
