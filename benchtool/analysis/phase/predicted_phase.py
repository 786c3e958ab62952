"""Phases beyond the first and the last one of what swings on, by weights that foresee it within the record.

The phase of a rotor whose speed swings once in a revolution, of few periods, bends more from one period to
the next than any polynomial follows, and always alike: linear prediction, by least squares in both directions
of time (Marple, IEEE Transactions on Acoustics, Speech, and Signal Processing 28 (1980) 441).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_DEGREE = 2  # of phases that are foreseen exactly: a speed that drifts
_SIZES = (5, 7, 10, 14)
_TAPS, _SHAPE = 8, 6.0  # to either side of a place between phases, of a sinc under Kaiser's window
_ROWS_EACH = 5  # places at least within the record, for each weight


@dataclass(frozen=True)
class Prediction:
    """The weights of the last `size` of all phases `phase_rad`, shape (n,), that foresee those within the
    record best; the next one they miss by the mean square `missed2`, rad^2, and `noise2` is that of noise
    from phase to phase."""

    phase_rad: Floats
    size: int
    missed2: float
    noise2: float

    def weights(self, by: float) -> Floats:
        """Return the weights of the last phases, shape (size,), in the phase `by` periods after the last."""
        return _foreseen(self.phase_rad, self.size, by)[0]

    def error2(self, by: float) -> float:
        """Return the mean square error of the phase `by` periods after the last, rad^2."""
        return _foreseen(self.phase_rad, self.size, by)[1]


def prediction(phase_rad: Floats, noise2: float) -> Prediction | None:
    """Return the one that misses the next phase by the least, of phases, shape (n,); None of too few."""
    sizes = [each for each in _SIZES if _is_told(len(phase_rad), each)]
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
    missed, bends = [], []
    for phases in (phase_rad, phase_rad[::-1]):
        before, after = _with_later(phases, size, by)
        missed.append(after - before @ polynomial)
        bends.append(before @ differences.T)
    missing, bend = np.concatenate(missed), np.concatenate(bends)
    shares = np.asarray(np.linalg.lstsq(bend, missing, rcond=None)[0])
    left2 = float(np.mean(np.square(missing - bend @ shares)))
    rows, told = len(missed[0]), len(shares)  # both directions are of the same phases
    return polynomial + shares @ differences, left2 * (rows + told) / (rows - told)


def _with_later(phase_rad: Floats, size: int, by: float) -> tuple[Floats, Floats]:
    """Return `size` phases each, shape (rows, size), and the one `by` periods after them, shape (rows,)."""
    windows, whole = sliding_window_view(phase_rad, size), int(np.floor(by))
    if by == whole:
        return windows[: len(phase_rad) - size + 1 - whole], phase_rad[size - 1 + whole :]
    place = np.arange(len(phase_rad), dtype=np.float64)
    smooth = np.polynomial.Polynomial.fit(place, phase_rad, _DEGREE + 1)
    taps = np.arange(1 - _TAPS, _TAPS + 1) - (by - whole)
    kernel = np.sinc(taps) * np.i0(_SHAPE * np.sqrt(np.maximum(0.0, 1.0 - (taps / _TAPS) ** 2)))
    kernel /= np.sum(kernel)
    swings = sliding_window_view(phase_rad - smooth(place), 2 * _TAPS)
    # the first value lies between the phases _TAPS - 1 and _TAPS
    last = np.arange(len(swings)) + _TAPS - 1 - whole
    kept = (last >= size - 1) & (last < len(phase_rad))
    at = last[kept]
    return windows[at - size + 1], (swings @ kernel)[kept] + smooth(at + by)
