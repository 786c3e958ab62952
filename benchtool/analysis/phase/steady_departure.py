"""Steady departure of a signal from the angle that its periods are told by, as of an encoder that slips."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above

_BY_CHANCE = 1e-3
_HIGHEST = 7  # degree of the polynomials that show how a phase moves otherwise
_FEWEST_PERIODS = 3

Floats = NDArray[np.float64]


def steady_departure(phase_rad: Floats, amplitude: Floats) -> float:
    """Return by how much a fundamental's phase about a track rises in a period; 0 where that is by chance.

    The phase in each period and the amplitude, both of shape (periods,), are split into orthogonal
    polynomials. Noise is in all of them, and alike in both (relative to the amplitude); a slip is the line of
    the phase alone. What moves the amplitude alone, as a load, is no reason to doubt the phase.
    """
    periods, middle = len(phase_rad), float(np.mean(amplitude))
    if periods < _FEWEST_PERIODS or not middle > 0.0:
        return 0.0
    place = (np.arange(periods) + 0.5) / periods * 2.0 - 1.0
    basis, triangle = np.linalg.qr(legendre.legvander(place, min(_HIGHEST, periods - 1)))
    of_phase, of_amplitude = basis.T @ phase_rad, basis.T @ (amplitude / middle)
    line, others = float(of_phase[1]) ** 2, of_phase[2:]
    if not any(_stands_out(line, each) for each in (others, np.append(others, of_amplitude[1:]))):
        return 0.0
    return float(of_phase[1] / triangle[1, 1]) * 2.0 / periods


def _stands_out(square: float, others: Floats) -> bool:
    usual = float(np.mean(others**2))
    ratio = square / usual if usual > 0.0 else math.inf
    return square > 0.0 and fisher_above(1, len(others), ratio) < _BY_CHANCE
