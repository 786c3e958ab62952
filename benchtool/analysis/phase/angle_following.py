"""Tracks along a measured angle, and whether what it does in every electrical period is the rotor's.

An angle that departs from a steady rise in every period alike is either that of a rotor whose speed swings
so, or that of a sensor with an error: of a resolver once or twice in a period of its own. Neither moves the
phase of the fundamental from period to period. Either, taken for the other, modulates all harmonics alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.periods import PhaseTrack

OFF_RAD = 2e-3
"""How far, rms, a phase may be off a track that is kept: at which harmonic 50 reads 0.5 % low."""

_FEWEST_KNOTS = 5  # of a spline
_PER_PERIOD, _FINEST = 16, 128  # places at which an angle is followed, in each electrical period
_ROWS_OF_PART, _STEPS_OF_PART = 8, 16  # at least, between two of more places than the fewest
_NOISE_OF_PART_RAD = 0.1 * OFF_RAD
_OF_GAIN = 1.0 / 3.0  # of the power of second differences: a quarter of it is half of that of a mean
_SURELY, _AS_ONE = 3.0, 35.0 / 9.0  # standard deviations; twice the second differences that overlap, as one
_OFF_WITHIN_RAD = 0.1 * OFF_RAD  # rms, within periods: sidebands of a fundamental are on small harmonics
_OF_STEPS = 0.2  # standard deviation of steps that beat with the samples about once in a period
_HIGHEST_COMPARED = 25
_DECIDED = 3.0  # standard deviations of a share of one or of none
_LEAST_SHARE = 1e-6  # of the mean power of harmonics, below which it is rounding


@dataclass(frozen=True)
class AngleTracks:
    """Tracks along the measured angle, averaged over whole periods and over parts of one; None where that
    makes no change. `within_rad` is how far, rms, the latter departs from the former."""

    of_periods: PhaseTrack | None = None
    within: PhaseTrack | None = None
    within_rad: float = 0.0


@dataclass(frozen=True)
class WithinPeriods:
    """Whether what an angle does within periods is the rotor's, and the standard uncertainty of the amplitude
    of each harmonic, from 1 on, by that, shape (harmonics,); empty where it is decided."""

    are_of_rotor: bool
    standard: NDArray[np.float64]


def along_angle(track: PhaseTrack, samples_per_period: float) -> AngleTracks:
    """Return the tracks along the measured angle of `track`, where it has one that departs from it.

    What is left within a period may be the steps in which the angle counts, which beat with the samples near
    harmonics: where it is no more than these, the angle is only averaged over whole periods.
    """
    if track.measured_rad is None or not (track.residual_rad or 0.0) > _OFF_WITHIN_RAD:
        return AngleTracks()
    per_period = _places_per_period(track, track.measured_rad, samples_per_period)
    number, departure = _means(track, track.measured_rad, samples_per_period / per_period)
    whole_number, whole = _means(track, track.measured_rad, samples_per_period, to_the_end=False)
    of_periods = _departing(track, whole_number, whole, OFF_RAD)
    if len(whole) < _FEWEST_KNOTS:
        return AngleTracks(None, _departing(track, number, departure, OFF_RAD))
    inner = (number >= whole_number[0]) & (number <= whole_number[-1])
    within_rad = float(np.std(departure[inner] - np.interp(number[inner], whole_number, whole)))
    if within_rad < _OF_STEPS * track.resolution_rad:
        return AngleTracks(of_periods)
    return AngleTracks(of_periods, _departing(track, number, departure, _OFF_WITHIN_RAD), within_rad)


def _places_per_period(
    track: PhaseTrack, measured_rad: NDArray[np.float64], samples_per_period: float
) -> int:
    """Return at how many places in a period the angle is followed: as many as its noise and steps allow.

    A mean over a sixteenth of a period has a fifth less of what a rotor does six times in one, as cogging.
    Where the means differ by no more than noise makes them, half as many have less of it.
    """
    noise_rad = float(np.sqrt(np.mean(np.diff(measured_rad, 2) ** 2) / 6.0))
    places = _PER_PERIOD
    while 2 * places <= _FINEST:
        rows, turned_rad = samples_per_period / (2 * places), np.pi / places
        is_coarse = turned_rad < _STEPS_OF_PART * track.resolution_rad
        if rows < _ROWS_OF_PART or is_coarse or noise_rad > _NOISE_OF_PART_RAD * np.sqrt(rows):
            break
        places *= 2
    while places > 1 and not _tell_more(track, measured_rad, samples_per_period / places, noise_rad):
        places //= 2
    return places


def _tell_more(track: PhaseTrack, measured_rad: NDArray[np.float64], rows: float, noise_rad: float) -> bool:
    """Return whether means over so many rows show more of the angle than noise, rms of a row, adds to what
    twice as many rows show: by their second differences, of which white noise has six times its power.

    What is missed between means twice as far apart is half of a second difference, and its power a quarter of
    that; such means have half of the noise."""
    _, means = _means(track, measured_rad, rows)
    if len(means) <= _FEWEST_KNOTS:
        return True
    seen2 = float(np.mean(np.diff(means, 2) ** 2)) / 6.0
    by_chance = _SURELY * math.sqrt(_AS_ONE / len(means))
    return seen2 > (1.0 + max(_OF_GAIN, by_chance)) * noise_rad**2 / rows


def within_periods(without: NDArray[np.complex128], along: NDArray[np.complex128]) -> WithinPeriods:
    """Judge by the harmonics of a current `without` what the angle does within periods, and `along` it: peak
    phasors of harmonics 1, 2, 3 ..., shape (harmonics,), as of the same angle zero.

    What following changes in them stands in those without it if the rotor does what the angle says, and does
    not if the angle errs: its share, by least squares over harmonics 2 to 25, is one or none. The harmonics
    that the current has by itself are the noise of that, and are at least what is left of each in the better
    case. Where they hide it, the rotor is as likely as the sensor: the variance is half of the change
    squared.
    """
    count = min(len(without), len(along))
    compared = slice(1, min(count, _HIGHEST_COMPARED))
    base, followed = without[:count][compared], along[:count][compared]
    change = base - followed
    own2 = np.minimum(np.abs(base), np.abs(followed)) ** 2
    weights = (
        1.0 / np.maximum(own2, _LEAST_SHARE * float(np.mean(own2))) if np.any(own2) else np.ones(len(own2))
    )
    power = float(np.sum(weights * np.abs(change) ** 2))
    if not power > 0.0:
        return WithinPeriods(False, np.empty(0))
    share = float(np.sum(weights * (np.conj(change) * base).real)) / power
    are_of_rotor = share > 0.5
    if abs(share - 0.5) > _DECIDED * np.sqrt(0.5 / power):
        return WithinPeriods(are_of_rotor, np.empty(0))
    return WithinPeriods(are_of_rotor, apart(without, along) / np.sqrt(2.0))


def apart(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return by how much amplitudes along two tracks differ, shape (harmonics,)."""
    count = min(len(one), len(other))
    return np.asarray(np.abs(np.abs(one[:count]) - np.abs(other[:count])), dtype=np.float64)


def _departing(
    track: PhaseTrack, number: NDArray[np.float64], departure: NDArray[np.float64], least_rad: float
) -> PhaseTrack | None:
    """Return the track and a spline through its departures at sample numbers, both of shape (parts,); None
    where these are few, or no more than `least_rad`, rms."""
    if len(number) < _FEWEST_KNOTS or not float(np.std(departure)) > least_rad:
        return None
    from scipy.interpolate import CubicSpline  # draws in scipy.optimize, which most runs do not need

    spline = CubicSpline(number, departure)
    return replace(track, departure=spline, source=f"{track.source}, and the measured angle about it")


def _means(
    track: PhaseTrack, measured_rad: NDArray[np.float64], rows: float, *, to_the_end: bool = True
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return middles of parts of the record, and the mean departure of the angle from the track in each, both
    of shape (parts,): of about so many rows each and as far as the record goes, or of so many each, as where
    these are a period, of which the record has whole ones and a rest."""
    count, size = len(measured_rad), max(1, round(rows))
    if to_the_end:
        edges = np.round(np.linspace(0.0, count, max(1, round(count / size)) + 1)).astype(np.int64)
    else:
        edges = np.arange(0, count + 1, size)
    counts = np.diff(edges)
    number = edges[:-1] + 0.5 * (counts - 1.0)
    # of a part in which the speed is constant the mean is the value in the middle
    means = np.add.reduceat(measured_rad[: edges[-1]], edges[:-1]) / counts
    return number, np.asarray(means - track.phase(number), dtype=np.float64)
