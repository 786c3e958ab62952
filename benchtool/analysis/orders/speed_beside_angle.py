"""Mean of a measured speed, whose course the rotor's angle or the phase of a current tells too: what both
have in common is no error of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import TURN, unwrapped_angle
from benchtool.analysis.periods import track_tone
from benchtool.analysis.statistics.mean_beside import MeanBeside
from benchtool.analysis.statistics.repeatability import wander_of_difference
from benchtool.analysis.statistics.scatter import error_of_record
from benchtool.analysis.uncertainty import Contribution
from benchtool.errors import AnalysisError

Floats = NDArray[np.float64]

_FEWEST = 20  # samples
_GAP = 8.0  # times the usual step of the time: nothing was read in between


def speed_beside_angle(
    omega_m: Floats,
    times: float | Floats,
    theta_m: Floats | None = None,
    i_a: Floats | None = None,
    pole_pairs: int = 1,
    *,
    angle: str = "theta_m",
    current: str = "i_a",
) -> MeanBeside | None:
    """Return the mean of a speed, rad/s, over all rows, with its error beside an angle, rad, or else a phase
    current, all of shape (n,); None where neither tells it better than the speed's own scatter.

    `times` is the rate of the rows, Hz, or their times, s, shape (n,), which need not be even for an angle.
    `angle` and `current` are what messages call them. Either may turn the other way than the speed counts.
    """
    if len(omega_m) < _FEWEST:
        return None
    try:
        if theta_m is not None:
            rows, angle_rad, channel = slice(None), unwrapped_angle(theta_m, angle), angle
        elif i_a is not None and isinstance(times, float):
            rows, phase_rad = _phase_of(i_a, current)
            angle_rad, channel = phase_rad / pole_pairs, current
        else:
            return None
    except AnalysisError:
        return None
    if len(angle_rad) < _FEWEST:
        return None
    times_s = np.arange(len(omega_m)) / times if isinstance(times, float) else times
    if not np.all(np.diff(times_s) > 0.0):
        return None
    found = _beside(omega_m, times_s, rows, angle_rad, channel, has_direction=theta_m is not None)
    own = error_of_record(omega_m).standard
    return found if found.error.standard < (own if math.isfinite(own) else math.inf) else None


def _beside(
    omega_m: Floats, times_s: Floats, rows: slice, angle_rad: Floats, channel: str, *, has_direction: bool
) -> MeanBeside:
    """Return the mean of a speed, rad/s, at rising times, both of shape (n,), beside an angle of some of its
    rows without jumps.

    The angle at both ends tells the mean speed, whatever it does in between: the mean is that over time from
    the first row to the last. What the speed reads beside the differences of the angle has the errors of
    both: those of the angle, and of the times, are taken back by the next difference, and leave the mean
    those at the ends. In a gap, where nothing was read, the rotor turned as the angle says, by as many whole
    turns more as the speed does. The phase of one current rises whichever way the rotor turns, and has the
    direction of the speed.
    """
    between, shared_s = None, times_s[rows]
    steps_s, duration_s = np.diff(shared_s), float(shared_s[-1] - shared_s[0])
    turned = 0.5 * (omega_m[rows][1:] + omega_m[rows][:-1]) * steps_s
    advance = np.diff(angle_rad)
    if has_direction:
        advance *= math.copysign(1.0, float(np.sum(turned)) * float(np.sum(advance)))
    else:
        advance = np.copysign(advance, turned)
    is_gap = steps_s > _GAP * float(np.median(steps_s))
    advance[is_gap] += TURN * np.round((turned - advance)[is_gap] / TURN)
    beside = (turned - advance) * len(steps_s) / duration_s
    beside[is_gap] = np.mean(beside[~is_gap])
    wander = wander_of_difference(_at_even_times(np.cumsum(advance), shared_s[1:]))
    if math.isfinite(wander.standard):
        name = f"wander of the speed, by that of the course of {channel} within the record"
        between = Contribution(name, "A", wander.standard / duration_s, wander.dof)
    mean = float(np.trapezoid(omega_m, times_s)) + float(np.sum((advance - turned)[is_gap]))
    mean /= float(times_s[-1] - times_s[0])
    return MeanBeside(mean, error_of_record(beside), between, channel)


def _at_even_times(values: Floats, times_s: Floats) -> Floats:
    """Return values at even times from the first to the last."""
    return np.interp(np.linspace(times_s[0], times_s[-1], len(times_s)), times_s, values)


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
