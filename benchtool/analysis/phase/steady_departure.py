"""Steady departure of a signal from the angle that its periods are told by, as of an encoder that slips."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above, students_deviation

_BY_CHANCE, _DOUBTED = 1e-3, 0.05
_MOST_DOUBTED_RAD = 0.5  # over the record: noise that hides more leaves no tone whose phase is told
_MOST_NOISE_RAD = 0.5  # rms, from period to period
_HIGHEST = 7  # degree of the polynomials that show how a phase moves otherwise
_FEWEST_PERIODS = 3

Floats = NDArray[np.float64]


class SteadyDeparture(NamedTuple):
    """By how much a phase rises in a period about a track, and the standard uncertainty of that by noise,
    rad, with its degrees of freedom; both 0 where it rises by chance."""

    rise_rad: float = 0.0
    standard_rad: float = 0.0
    dof: float = math.inf


def steady_departure(phase_rad: Floats, amplitude: Floats) -> SteadyDeparture:
    """Return by how much a fundamental's phase about a track rises in a period, where that is no chance.

    The phase in each period and the amplitude, both of shape (periods,), are split into orthogonal
    polynomials. Noise is in all of them, and alike in both (relative to the amplitude); a slip is the line of
    the phase alone. What moves the amplitude alone, as a load, is no reason to doubt the phase. A small rise
    is doubted where noise alone has as much once in twenty records. Phases that move to and fro by more than
    half a radian are those of noise: from one to the next they may have turned either way.
    """
    periods, middle = len(phase_rad), float(np.mean(amplitude))
    if periods < _FEWEST_PERIODS or not middle > 0.0:
        return SteadyDeparture()
    place = (np.arange(periods) + 0.5) / periods * 2.0 - 1.0
    basis, triangle = np.linalg.qr(legendre.legvander(place, min(_HIGHEST, periods - 1)))
    of_phase, of_amplitude = basis.T @ phase_rad, basis.T @ (amplitude / middle)
    if not float(np.mean(of_phase[2:] ** 2)) < _MOST_NOISE_RAD**2:
        return SteadyDeparture()
    per_period = 2.0 / periods / float(triangle[1, 1])
    rise_rad = float(of_phase[1]) * per_period
    least = _DOUBTED if abs(rise_rad) * periods < _MOST_DOUBTED_RAD else _BY_CHANCE
    both = of_phase[2:], np.append(of_phase[2:], of_amplitude[1:])
    by_chance, others = min(
        ((_by_chance(float(of_phase[1]) ** 2, each), each) for each in both), key=lambda each: each[0]
    )
    if not by_chance < least:
        return SteadyDeparture()
    dof = float(len(others))
    noise_rad = math.sqrt(float(np.mean(others**2))) * students_deviation(dof)
    return SteadyDeparture(rise_rad, noise_rad * abs(per_period), dof)


def _by_chance(square: float, others: Floats) -> float:
    """Return the probability of so large a square beside others by noise alone."""
    if not square > 0.0:
        return 1.0
    usual = float(np.mean(others**2))
    return fisher_above(1, len(others), square / usual if usual > 0.0 else math.inf)
