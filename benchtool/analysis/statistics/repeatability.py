"""How much the mean speed of another record differs, or the frequency of a line, by how the phase wanders."""

from __future__ import annotations

import math

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.statistics.scatter import MeanError, error_of_series
from benchtool.analysis.uncertainty import Contribution

_MOST_VALUES = 4096
_FEWEST_VALUES = 6
_FITTED = 3  # unknowns of a quadratic
_PARTS, _FEWEST_PARTS = 64, 16
_LONGEST, _LAGS = 8, 3  # such part of the record is the longest lag; each half of the next
_LET_GO = 0.4  # exponent of time with which the mean square of differences grows: held 0, random walk 1
_DOF_OF_ONE = 3.0


def wander_of_difference(phase_rad: NDArray[np.float64]) -> MeanError:
    """Return the standard deviation, over records, of the phase from the first to the last value, rad.

    `phase_rad`, shape (n,), are phases at equal times. What a quadratic leaves of them is rms sigma: of a
    phase that a control holds on to a constant speed the difference of its ends scatters by sqrt(2) sigma,
    however long it is, and the mean square of differences does not grow with the time between them. Where it
    does, from a thirtieth of the record to an eighth, the control lets the phase go, because the speed itself
    wanders: then it is the scatter of the mean of the speeds of 64 parts, with their correlation. The phases
    are means of these parts, which the noise of an encoder hides less. A speed that keeps its value for so
    long that the record holds few of them scatters by itself, as one value. nan with fewer than six values.
    """
    step = max(1, len(phase_rad) // _MOST_VALUES)
    phase_rad = phase_rad[::step]
    count = len(phase_rad)
    if count < _FEWEST_VALUES:
        return MeanError(math.nan, math.nan)
    number = np.arange(count, dtype=np.float64)
    left = phase_rad - Polynomial.fit(number, phase_rad, 2)(number)
    freedom = float(count - _FITTED)
    held = MeanError(math.sqrt(2.0 * float(left @ left) / freedom), freedom)
    size = max(1, count // _PARTS)
    marks = np.mean(left[: count // size * size].reshape(-1, size), axis=1)
    parts = len(marks) - 1
    if parts < _FEWEST_PARTS or not held.standard > 0.0 or _growth(marks) < _LET_GO:
        return held
    turned = np.diff(marks)
    of_mean = error_of_series(turned)
    let_go = MeanError(parts * of_mean.standard, of_mean.dof)
    if not math.isfinite(of_mean.standard):
        let_go = MeanError(parts * float(np.std(turned)) / math.sqrt(2.0), _DOF_OF_ONE)
    return max(held, let_go, key=lambda each: each.standard)


def wander_of_line(samples: NDArray[np.float64], rate_Hz: float, frequency_Hz: float) -> Contribution | None:
    """Return how much the mean frequency of a line, Hz, differs from record to record, because its phase
    wanders: by that of its component in 64 parts of samples, shape (n,). None where these are too few."""
    size = len(samples) // _PARTS
    if size < 1:
        return None
    row = np.arange(size * _PARTS)
    turned = samples[: len(row)] * np.exp(-2j * np.pi * frequency_Hz / rate_Hz * row)
    phase_rad = np.unwrap(np.angle(np.sum(turned.reshape(_PARTS, size), axis=1)))
    wander = wander_of_difference(phase_rad)
    if not math.isfinite(wander.standard):
        return None
    standard_Hz = wander.standard * rate_Hz / (2.0 * math.pi * len(row))
    return Contribution(
        "wander of the line, by that of its phase within the record", "A", standard_Hz, wander.dof
    )


def _growth(marks: NDArray[np.float64]) -> float:
    """Return the exponent of the time with which the mean square of differences grows."""
    lags = 2 ** np.arange(1 + int(math.log2(len(marks) // _LONGEST)))[-_LAGS:]
    squares = np.array([float(np.mean((marks[lag:] - marks[:-lag]) ** 2)) for lag in lags])
    if not np.all(squares > 0.0):
        return 0.0
    return float(np.polyfit(np.log(lags), np.log(squares), 1)[0])
