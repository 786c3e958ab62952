"""What a converter reads on average over noise, and how much its readings scatter.

Of a value a fraction f of a step above a level, with noise between f and the edges half a step away, the mean
reading is known of any distribution of the noise (Widrow and Kollár, Quantization Noise, 2008, ch. 4). With
little noise it jumps at the edges: between two places of a waveform it is the mean over what lies between
them, by its integral, so that few places are enough.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

_EDGES = 3  # to either side of a reading: those beyond are three standard deviations of noise away
_CELLS = 32  # from a level to an edge
_FURTHEST, _PLACES = 8.0, 1 << 11  # standard deviations of noise, in a table
_LEAST_APART = 1e-6  # steps: neighbouring places that are less apart count as one

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Readings:
    """Errors and variance of readings, in steps, from one edge to the next, and their integrals from the
    first edge on, all of shape (draws, cells + 1)."""

    error: Floats
    variance: Floats
    error_before: Floats
    variance_before: Floats

    @staticmethod
    def of(noise: Floats, shape: Floats) -> Readings:
        """Return those under noise of an rms, in steps, and of a shape from Laplace's distribution (-1) over
        the normal one (0) to the rectangular one (1), both of shape (draws,)."""
        apart, inverse = np.arange(_CELLS + 1) / (2.0 * _CELLS), 1.0 / noise[:, np.newaxis]
        mean, square = (np.zeros((len(noise), _CELLS + 1)) for _ in range(2))
        for edge in range(_EDGES):
            above, below = (_below((each - (edge + 0.5)) * inverse, shape) for each in (apart, -apart))
            mean += above - below
            square += (2.0 * edge + 1.0) * (above + below)
        error, variance = mean - apart, square - mean**2
        error[:, -1] = 0.0  # midway between two levels each is read as often
        error = np.concatenate([-error[:, :0:-1], error], axis=1)
        variance = np.concatenate([variance[:, :0:-1], variance], axis=1)
        return Readings(error, variance, _integral(error), _integral(variance))

    def at(self, signals: Floats) -> tuple[Floats, Floats]:
        """Return the mean and the variance of readings of signals, in steps, shape (draws, places)."""
        place = _Place.of(signals)
        return signals + place.between(self.error), place.between(self.variance)

    def from_place_to_place(self, signals: Floats) -> tuple[Floats, Floats]:
        """Return the means of both from each place of periodic signals to the next, all of shape (draws,
        places)."""
        place, apart = _Place.of(signals), _to_next(signals)
        is_flat = np.abs(apart) < _LEAST_APART
        over = np.where(is_flat, 1.0, apart)
        error = _to_next(place.integral(self.error_before, self.error)) / over
        steps = self.variance_before[:, -1:] * place.nearest
        variance = _to_next(place.between(self.variance_before) + steps) / over
        if np.any(is_flat):
            error = np.where(is_flat, place.between(self.error), error)
            variance = np.where(is_flat, place.between(self.variance), variance)
        return signals + 0.5 * apart + error, variance


def _to_next(values: Floats) -> Floats:
    """Return by how much values at places of a period, shape (draws, places), differ from place to place."""
    return np.diff(values, axis=1, append=values[:, :1])


@dataclass(frozen=True)
class _Place:
    """Where signals lie between two edges: the `nearest` level, the cell in tables of all draws, and the
    `part` of a cell, all of shape (draws, places)."""

    nearest: Floats
    cell: NDArray[np.int64]
    part: Floats

    @staticmethod
    def of(signals: Floats) -> _Place:
        nearest = np.round(signals)
        cells = (signals - nearest + 0.5) * (2.0 * _CELLS)
        whole = np.minimum(cells.astype(np.int64), 2 * _CELLS - 1)
        of_draw = (2 * _CELLS + 1) * np.arange(len(signals))[:, np.newaxis]
        return _Place(nearest, whole + of_draw, cells - whole)

    def between(self, table: Floats) -> Floats:
        """Return the values of a table of shape (draws, cells + 1), on straight lines between them."""
        lower = table.take(self.cell)
        return np.asarray(lower + self.part * (table.take(self.cell + 1) - lower))

    def integral(self, whole: Floats, table: Floats) -> Floats:
        """Return the integral of a table, on straight lines, by that up to its cells."""
        lower = table.take(self.cell)
        within = lower + 0.5 * self.part * (table.take(self.cell + 1) - lower)
        return np.asarray(whole.take(self.cell) + self.part * within / (2.0 * _CELLS))


def _integral(table: Floats) -> Floats:
    sums = np.cumsum(table[:, 1:] + table[:, :-1], axis=1) / (4.0 * _CELLS)
    return np.concatenate([np.zeros((len(table), 1)), sums], axis=1)


def _below(value: Floats, shape: Floats) -> Floats:
    """Return the probability that noise of rms 1 is less than values of shape (draws, points): between that
    of the normal distribution (shape 0), of the rectangular one (1), and of Laplace's (-1)."""
    tables = _distributions()
    place = np.clip((value + _FURTHEST) * (_PLACES / _FURTHEST), 0.0, 2.0 * _PLACES).astype(np.int32)
    found = tables[0].take(place)
    other = tables.ravel().take(place + (tables.shape[1] * np.where(shape > 0.0, 1, 2))[:, np.newaxis])
    return np.asarray(found + np.abs(shape)[:, np.newaxis] * (other - found))


@cache
def _distributions() -> Floats:
    """Return the normal, the rectangular and Laplace's distribution function of rms 1 at the places of a
    table."""
    from scipy.special import ndtr

    value = (np.arange(2 * _PLACES + 1) + 0.5) * (_FURTHEST / _PLACES) - _FURTHEST
    tail = 0.5 * np.exp(-math.sqrt(2.0) * np.abs(value))
    laplace = np.where(value < 0.0, tail, 1.0 - tail)
    return np.array([ndtr(value), np.clip(0.5 + value / math.sqrt(12.0), 0.0, 1.0), laplace])
