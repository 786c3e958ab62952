"""Coverage of a measured rotor angle: travel, revolutions, and how finely they are sampled."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.validity import require_signal
from benchtool.errors import AnalysisError

TURN = 2 * np.pi

_SMALLEST_JUMP = 0.8  # of the range of a wrapped angle: where it starts over
_WRAP_TOLERANCE = 0.05
_MOST_TURNS = 32  # until an angle starts over; more are counts of an encoder
_SAME_RAD = 1e-9
_STANDS = 0.01  # of a revolution: a rotor that moves by less stands
_ROWS_PER_UPDATE = 1.2  # from which an angle may be updated more rarely than it is read
_COUNTS_PER_UPDATE = 1.5  # of the least step: an angle that counts moves by one, rarely by two
_WITHIN_COUNTS, _HIGHEST_DEGREE = 0.6, 4  # of a count: half of it, and what its places move a curve by
_GAP, _BESIDE_A_GAP = 1.5, 16  # times the usual step of the time; rows by which the speed there is told
_COARSE = 1.2  # samples for each angle of each revolution, from which the angle is taken to count in steps


@dataclass(frozen=True)
class AngleCoverage:
    """Where on the circle samples are.

    Attributes:
        angle_rad: the angle without wraps, shape (n,), in the order of the samples.
        revolution: which revolution each sample is in, shape (n,), from 0.
        revolutions: revolutions travelled between the least and the greatest angle.
        largest_arc_rad: the longest arc of the circle that no sample of any revolution is in.
        resolution_rad: the step of the angle, or 0 where it is finer than the samples show.
    """

    angle_rad: NDArray[np.float64]
    revolution: NDArray[np.int64]
    revolutions: float
    largest_arc_rad: float
    resolution_rad: float


def angle_coverage(theta_m: NDArray[np.float64], name: str = "theta_m") -> AngleCoverage:
    """Return the coverage of a mechanical angle, rad, shape (n,): wrapped or not, of either direction, at any
    times.

    An angle that starts over at 2 pi (or at a whole number of turns) is unwrapped by the shorter way between
    samples; one that counts turns is taken as it is.

    Raises:
        AnalysisError: not finite, constant, wrapping at other than a whole turn (degrees, for example), less
            than one revolution travelled, or more than there are samples.
    """
    angle = unwrapped_angle(theta_m, name)
    low = float(angle.min())
    revolutions = (float(angle.max()) - low) / TURN
    if revolutions < 1.0:
        raise AnalysisError(
            f"'{name}' covers {revolutions:.3g} mechanical revolutions, at least one is needed for orders: "
            f"record longer, and check that the angle is mechanical and in rad"
        )
    if revolutions > len(angle):
        raise AnalysisError(
            f"'{name}' covers {revolutions:.3g} revolutions in {len(angle)} samples, at least one sample for "
            f"each is needed: check the unit of the angle, or record at a higher rate"
        )
    on_circle = np.sort(np.mod(angle, TURN))
    arcs = np.diff(on_circle, append=on_circle[0] + TURN)
    distinct = 1 + np.count_nonzero(np.diff(np.sort(angle)) > _SAME_RAD)
    is_coarse = len(angle) > _COARSE * distinct
    return AngleCoverage(
        angle,
        np.floor((angle - low) / TURN).astype(np.int64),
        revolutions,
        float(arcs.max()),
        float(np.median(arcs[arcs > _SAME_RAD])) if is_coarse else 0.0,
    )


def few_revolutions(angle_rad: NDArray[np.float64], name: str, least: float) -> str:
    """Return why an angle without wraps, rad, shape (n,), has too few revolutions for orders; empty if it has
    enough."""
    covered = float(np.ptp(angle_rad)) / TURN
    if covered >= least:
        return ""
    if covered < _STANDS:
        return f"'{name}' stands still, {least:g} mechanical revolutions are needed for orders"
    return (
        f"'{name}' covers {covered:.2f} mechanical revolutions, at least {least:g} are needed for orders: "
        f"record a longer window"
    )


def least_step_rad(angle_rad: NDArray[np.float64]) -> float:
    """Return the least arc between two places on the circle of an angle, shape (n,): the step of one that
    counts, and of any other next to nothing. The rounding of an angle that starts over is none."""
    arcs = np.diff(np.sort(np.mod(angle_rad, TURN)))
    return float(np.min(arcs[arcs > _SAME_RAD], initial=TURN))


def without_counts(angle_rad: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an angle without jumps, shape (n,), read at `times`, along a polynomial of these that is within
    its counts everywhere; as it is where none is.

    The steps of an angle that counts are an error that repeats in every revolution where rows and counts keep
    step: order k of it folds order m of a signal to orders m - k and m + k.
    """
    within = _WITHIN_COUNTS * least_step_rad(angle_rad)
    for degree in range(1, _HIGHEST_DEGREE + 1):
        smooth = np.polynomial.Polynomial.fit(times, angle_rad, degree)(times)
        if float(np.max(np.abs(angle_rad - smooth))) < within:
            return np.asarray(smooth)
    return angle_rad


def between_updates(angle_rad: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an angle without jumps, shape (n,), read at `times` oftener than it is updated, as by a bus that
    is slower than the samples: straight from one update to the next, and on beyond the outer ones.

    It is held where rows repeat it, and then moves by more than its least step on the circle; an angle that
    repeats because it counts in steps is returned as it is. A held angle lags by up to an update, in which a
    signal turns on: order k would read low by sinc(k hold / turn).
    """
    updates = np.flatnonzero(np.abs(np.diff(angle_rad)) > _SAME_RAD) + 1
    if len(updates) < 2 or len(angle_rad) < _ROWS_PER_UPDATE * len(updates):
        return angle_rad
    moves = np.abs(np.diff(angle_rad[updates]))
    if float(np.median(moves)) < _COUNTS_PER_UPDATE * least_step_rad(angle_rad):
        return angle_rad
    at, angle = times[updates], angle_rad[updates]
    slope = np.diff(angle) / np.diff(at)
    followed = np.interp(times, at, angle)
    before, after = slice(0, updates[0]), slice(updates[-1], None)
    followed[before] = angle[0] + slope[0] * (times[before] - at[0])
    followed[after] = angle[-1] + slope[-1] * (times[after] - at[-1])
    return np.asarray(followed)


def across_gaps(angle_rad: NDArray[np.float64], times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return an angle without jumps, shape (n,), that was unwrapped by the shorter way from row to row at
    `times`, with the whole turns in gaps between them that the speed on either side tells."""
    steps, advance = np.diff(times), np.diff(angle_rad)
    is_gap = steps > _GAP * np.median(steps)
    rows = np.flatnonzero(~is_gap & (steps > 0.0))  # coarse stamps stand still
    if not len(rows):
        return angle_rad
    speeds = advance[rows] / steps[rows]
    fastest = float(np.percentile(np.abs(speeds), 99.0))
    for gap in np.flatnonzero(is_gap & (fastest * steps > 0.25 * TURN)):
        at = int(np.searchsorted(rows, gap))
        speed = float(np.median(speeds[max(0, at - _BESIDE_A_GAP) : at + _BESIDE_A_GAP]))
        advance[gap] += TURN * np.round((speed * steps[gap] - advance[gap]) / TURN)
    return np.asarray(angle_rad[0] + np.concatenate([[0.0], np.cumsum(advance)]))


def revolution_rows(angle_rad: NDArray[np.float64], turn_rad: float = TURN) -> NDArray[np.int64]:
    """Return the rows at which turns of `turn_rad` are first complete, of an angle without wraps, shape (n,).

    The rows may be at any times. Starts at row 0, shape (turns + 1,); a rotor that swings back does not begin
    a turn again.
    """
    travelled = np.maximum.accumulate((angle_rad - angle_rad[0]) * np.sign(angle_rad[-1] - angle_rad[0]))
    turns = int(min(travelled[-1] / turn_rad, len(angle_rad)))
    return np.searchsorted(travelled, turn_rad * np.arange(turns + 1)).astype(np.int64)


def unwrapped_angle(theta_m: NDArray[np.float64], name: str = "theta_m") -> NDArray[np.float64]:
    """Return angle, rad, shape (n,), without its jumps where it starts over: by whole turns, or not at all.

    Raises:
        AnalysisError: not finite, constant, or wrapping at other than a whole turn (degrees, for example).
    """
    require_signal(theta_m, name)
    steps, span = np.diff(theta_m), float(np.ptp(theta_m))
    jumps = np.abs(steps) > _SMALLEST_JUMP * span
    if not jumps.any() or 2 * np.count_nonzero(jumps) >= len(steps):
        return np.asarray(theta_m, dtype=np.float64)
    # it starts over one sample's step past its range, which the other steps tell; where rows are missing
    # there, by as much as elsewhere, further on
    others = np.abs(steps[~jumps])
    step, largest = float(np.median(others)), float(np.max(others))
    period = span + step
    turns = max(1, round(period / TURN))
    missing = turns * TURN - span
    in_degrees = abs(period - 360.0) < _WRAP_TOLERANCE * 360.0  # which is near 57 turns of 2 pi
    is_whole = -_WRAP_TOLERANCE * TURN <= missing <= _WRAP_TOLERANCE * TURN + max(2.0 * step, largest)
    if in_degrees or turns > _MOST_TURNS or not is_whole:
        raise AnalysisError(
            f"'{name}' starts over at about {period:.3g}, a whole turn of {TURN:.4g} rad is expected: state "
            f"the unit of the angle (deg, rev)"
        )
    return np.unwrap(theta_m, period=turns * TURN)
