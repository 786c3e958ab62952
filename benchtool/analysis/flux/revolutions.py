"""Whole revolutions of a rotating vector by its own angle, and what is fitted to it in each."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.periods import PhaseTrack, track_angle
from benchtool.errors import AnalysisError

ORDERS = (0, 1, -5, 7)
"""Centre, circle, and the orders that turn a circle into a hexagon."""

_CENTRINGS = 4  # each leaves about a tenth of the error of the one before
_FOLLOWINGS, _OFF_RAD, _FEWEST_KNOTS = 3, 2e-3, 5  # rms; revolutions
_ENOUGH = 48  # samples of a revolution to find the centre by
_HEAD = 1 << 16
_CHUNK = 1 << 14  # rows at a time: in the cache

Departure = Callable[[NDArray[np.float64]], NDArray[np.float64]]


def forwards(psi: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the trajectory, mirrored if it runs backwards."""
    some = psi[:_HEAD]
    steps = np.angle(some[1:] * np.conj(some[:-1]))
    return psi if np.sum(steps) >= 0.0 else np.conj(psi)


def revolutions_of(psi: NDArray[np.complex128]) -> tuple[PhaseTrack, list[slice]]:
    """Return the track of the angle about the centre, and the rows of its whole revolutions.

    It is quadratic in time, and follows order 1 where the speed swings about that. An offset makes the angle
    about zero wobble, and its track with it, so the centre is found by iteration, for which a few dozen
    samples of each revolution are enough.
    """
    step = _thinning(psi)
    some = psi[::step]
    centre = 0j
    for _ in range(_CENTRINGS):
        track = track_angle(np.unwrap(np.angle(some - centre)), 1)
        centre = complex(np.mean(fits(some, track, _whole(track))[:, 0]))
    for _ in range(_FOLLOWINGS):
        followed = _followed(some, track)
        if followed is None:
            break
        track = followed
    own = track.departure
    phase = track.phase(Polynomial([0.0, 1.0 / step]))
    at_rows: Departure | None = None if own is None else lambda rows: own(rows / step)
    track = PhaseTrack(phase, len(psi), track.source, track.residual_rad, departure=at_rows)
    return track, _whole(track)


def _followed(psi: NDArray[np.complex128], track: PhaseTrack) -> PhaseTrack | None:
    """Return the track along the phase that order 1 has in each revolution; None where it stays on it.

    Where the speed swings, revolutions by a quadratic track are no whole ones, and order 1 is left in all
    others.
    """
    revolutions = _whole(track)
    phase_rad = np.unwrap(np.angle(fits(psi, track, revolutions)[:, 1]))
    phase_rad -= np.mean(phase_rad)
    if len(revolutions) < _FEWEST_KNOTS or not float(np.std(phase_rad)) > _OFF_RAD:
        return None
    from scipy.interpolate import CubicSpline  # draws in scipy.optimize, which most runs do not need

    spline = CubicSpline([0.5 * (part.start + part.stop - 1) for part in revolutions], phase_rad)
    before = track.departure
    return replace(
        track, departure=spline if before is None else lambda numbers: before(numbers) + spline(numbers)
    )


def _thinning(psi: NDArray[np.complex128]) -> int:
    """Return every how many rows of a trajectory are enough to find its centre."""
    if len(psi) <= _HEAD:
        return 1
    head = psi[:_HEAD]
    step_rad = abs(float(np.mean(np.angle(head[1:] * np.conj(head[:-1])))))
    return max(1, int(2 * np.pi / (_ENOUGH * max(step_rad, 2 * np.pi / len(psi)))))


def _whole(track: PhaseTrack) -> list[slice]:
    """Return the rows of the whole revolutions."""
    begin = float(track.at(np.zeros(1))[0])
    marks = begin + 2 * np.pi * np.arange(math.floor(track.periods) + 1, dtype=np.float64)
    edges = [round(float(mark)) for mark in track.sample_numbers(marks)]
    return [slice(begin, end) for begin, end in itertools.pairwise(edges)]


def fits(psi: NDArray[np.complex128], track: PhaseTrack, revolutions: list[slice]) -> NDArray[np.complex128]:
    """Return the amplitudes of `ORDERS` in every revolution, shape (revolutions, 4), by least squares.

    Raises:
        AnalysisError: a revolution has too few rows to tell the orders from each other.
    """
    fewest, needed = min(each.stop - each.start for each in revolutions), max(ORDERS) - min(ORDERS) + 1
    if fewest < needed:
        raise AnalysisError(
            f"the flux turns once within {fewest} samples, {needed} or more are needed to tell its orders: "
            f"record at a higher rate, or at a lower and steadier speed"
        )
    found = []
    per_revolution = (revolutions[-1].stop - revolutions[0].start) // len(revolutions)
    together = max(1, _CHUNK // max(1, per_revolution))
    for first in range(0, len(revolutions), together):
        part = revolutions[first : first + together]
        rows = slice(part[0].start, part[-1].stop)
        begins = [each.start - rows.start for each in part]
        circle = np.exp(1j * track.at(np.arange(rows.start, rows.stop, dtype=np.float64)))
        columns = np.stack([circle**order for order in ORDERS])
        conjugate = np.conj(columns)
        normal = np.add.reduceat(conjugate[:, np.newaxis] * columns, begins, axis=2)
        right = np.add.reduceat(conjugate * psi[rows], begins, axis=1)
        found.append(np.linalg.solve(np.moveaxis(normal, 2, 0), right.T[:, :, np.newaxis])[:, :, 0])
    return np.concatenate(found)
