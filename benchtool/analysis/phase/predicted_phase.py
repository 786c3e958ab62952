"""Phases beyond the first and the last one of what swings on, by weights that foresee it within the record.

The phase of a rotor whose speed swings once in a revolution, of few periods, bends more from one period to
the next than any polynomial follows, and always alike: linear prediction, by least squares in both directions
of time (Marple, IEEE Transactions on Acoustics, Speech, and Signal Processing 28 (1980) 441).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from benchtool.analysis.phase.swings import Swings

Floats = NDArray[np.float64]

_DEGREE = 2  # of phases that are foreseen exactly: a speed that drifts
_SIZES = (5, 7, 10, 14)
_TAPS = 8  # to either side of a place between phases
_REACH = 8  # periods
_ROWS_EACH = 5  # places at least within the record, for each weight
_LEAST_BEND = 0.01  # of the largest: by less, as by digits, weights are told that nothing at an end bears out


@dataclass(frozen=True)
class Prediction:
    """The weights of the last `size` of all phases `phase_rad`, shape (n,), that foresee those within the
    record best; the next one they miss by the mean square `missed2`, rad^2, and `noise2` is that of noise
    from phase to phase."""

    phase_rad: Floats
    size: int
    missed2: float
    noise2: float

    @property
    def reach(self) -> int:
        """How many periods it goes on, as far as a natural spline that ends there bends another way."""
        return _REACH

    def weights(self, by: float) -> Floats:
        """Return the weights of the last phases, shape (size,), in the phase `by` periods after the last."""
        return _foreseen(self.phase_rad, self.size, by)[0]

    def error2(self, by: float) -> float:
        """Return the mean square error of the phase `by` periods after the last, rad^2."""
        return _foreseen(self.phase_rad, self.size, by)[1]


def prediction(phase_rad: Floats, noise2: float, sizes: tuple[int, ...] = _SIZES) -> Prediction | None:
    """Return the one of these sizes that misses the next phase by the least, of phases, shape (n,); None of
    too few."""
    sizes = tuple(each for each in sizes if _is_told(len(phase_rad), each))
    found = [Prediction(phase_rad, each, _foreseen(phase_rad, each, 1.0)[1], noise2) for each in sizes]
    return min(found, key=lambda each: each.missed2, default=None)


def _is_told(count: int, size: int) -> bool:
    return count - size - _TAPS >= _ROWS_EACH * (size - _DEGREE - 1)


def _foreseen(phase_rad: Floats, size: int, by: float) -> tuple[Floats, float]:
    """Return the weights of `size` phases in the one `by` periods after them, and the mean square by which
    they miss others than those that told them, rad^2."""
    powers = np.vander(np.arange(size) - (size - 1.0), _DEGREE + 1)
    polynomial = np.vander([by], _DEGREE + 1)[0] @ np.linalg.pinv(powers)
    differences = np.diff(np.eye(size), _DEGREE + 1, axis=0)
    later, error2 = _later(phase_rad, by)
    missed, bends = [], []
    for phases, after in ((phase_rad, later[0]), (phase_rad[::-1], later[1])):
        last = np.flatnonzero(np.isfinite(after[size - 1 :])) + size - 1
        before = sliding_window_view(phases, size)[last - size + 1]
        missed.append(after[last] - before @ polynomial)
        bends.append(before @ differences.T)
    missing, bend = np.concatenate(missed), np.concatenate(bends)
    shares = np.asarray(np.linalg.lstsq(bend, missing, rcond=_LEAST_BEND)[0])
    left2 = float(np.mean(np.square(missing - bend @ shares)))
    rows, told = len(missed[0]), len(shares)  # both directions are of the same phases
    return polynomial + shares @ differences, left2 * (rows + told) / (rows - told) + error2


def _later(phase_rad: Floats, by: float) -> tuple[tuple[Floats, Floats], float]:
    """Return what the phase is `by` periods after each and, from the last on, before each, both of shape (n,)
    and nan where the record does not tell it, and the mean square error of that, rad^2."""
    count, whole = len(phase_rad), math.floor(by)
    found = Swings.of(phase_rad)
    swings, course = found.phase_rad, found.course
    kernel, error2 = _kernel(found, by - whole) if by > whole else (np.ones(1), 0.0)
    taps = len(kernel) // 2  # to either side of the place; the first value lies after phase taps - 1
    first = max(0, taps - 1)
    both = []
    for values, direction in ((swings, 1.0), (swings[::-1], -1.0)):
        later = np.full(count, np.nan)
        between = sliding_window_view(values, len(kernel)) @ kernel
        last = np.arange(len(between)) + first - whole
        kept = last >= 0
        at = last[kept] + by
        later[last[kept]] = between[kept] + course(at if direction > 0.0 else count - 1.0 - at)
        both.append(later)
    return (both[0], both[1]), error2


def _kernel(swings: Swings, fraction: float) -> tuple[Floats, float]:
    """Return the weights of the phases around a place that interpolate what has the spectrum of swings best,
    and the mean square of what they miss of it, rad^2."""
    away = np.arange(1 - _TAPS, _TAPS + 1) - fraction
    turned = np.exp(2j * np.pi * np.outer(fft.rfftfreq(len(swings.phase_rad)), away))
    size = np.sqrt(swings.power)
    basis = np.concatenate([size[:, np.newaxis] * turned.real, size[:, np.newaxis] * turned.imag])
    sought = np.concatenate([size, np.zeros(len(size))])
    kernel = np.asarray(np.linalg.lstsq(basis, sought, rcond=None)[0])
    return kernel, float(np.sum(np.square(basis @ kernel - sought)))
