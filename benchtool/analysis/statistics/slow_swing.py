"""A slow swing in a series of few values, one of each period: a sinusoid that explains nearly all of it.

Its incomplete cycles move a mean by an amount that is known, and what is left over is the noise. Red noise, a
random walk as well as 1/f noise, leaves more than a twentieth unexplained by any one sinusoid, of 24 to 100
values in all of some thousand records, but for 1 % of those whose density falls with the cube of frequency.
Where the swing is in white noise, which leaves more of it, the rest is white: of 40 values and more red noise
left less than three tenths, and neighbours of these that are not alike, in 5 of 4800 records.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.statistics.neighbours import neighbours_alike

Floats = NDArray[np.float64]

_FEWEST = 24  # values
_LEAST_CYCLES = 1.2  # in the series: a slower one is not told from the mean
_FASTEST = 0.25  # cycles from one value to the next
_LEFT = 0.05  # of the variance
_LEFT_WHITE, _ALIKE, _FEWEST_WITH_NOISE = 0.3, 1.5, 40  # of the variance; standard deviations; values
_FINER = 4  # places of a spectrum in a bin
_NEAR = 0.5  # cycles
_EXACTLY = 1e-4  # cycles
_FITTED = 4.0  # constants: mean, cosine, sine and frequency


@dataclass(frozen=True)
class SlowSwing:
    """What a series, shape (n,), is about its swing: its mean and the `rest`, shape (n,), by least squares.

    Noise moves the mean `of_mean` times as much as it would move one without a swing, with the constants
    that were fitted taken off the number of values. A mean that the swing is in, has `moved`, by the rms over
    all places that the swing may begin at.
    """

    mean: float
    rest: Floats
    of_mean: float
    moved: float


def slow_swing(values: Floats) -> SlowSwing | None:
    """Return the swing of values, shape (n,), at equal distances; None where it is not nearly all that they
    do, but for white noise."""
    count = len(values)
    if count < _FEWEST:
        return None
    deviation = values - np.mean(values)
    square = float(deviation @ deviation)
    if not square > 0.0:
        return None
    place = (np.arange(count) + 0.5) / count
    found = sinusoid_of(deviation, place, _LEAST_CYCLES)
    if found is None:
        return None
    left = float(found.rest @ found.rest) / square
    is_white = count >= _FEWEST_WITH_NOISE and neighbours_alike(found.rest) < _ALIKE
    if not left < (_LEFT_WHITE if is_white else _LEFT):
        return None
    basis = swing_basis(place, found.cycles)
    of_mean = math.sqrt(count * float(np.linalg.inv(basis.T @ basis)[0, 0]) * count / (count - _FITTED))
    size = math.hypot(*found.constants[1:].tolist())
    moved = size * abs(float(np.sinc(found.cycles))) / math.sqrt(2.0)
    return SlowSwing(float(np.mean(values) + found.constants[0]), found.rest, of_mean, moved)


@dataclass(frozen=True)
class Sinusoid:
    """A sinusoid of so many `cycles` over a record, about a constant or a line: the constants of
    `swing_basis`, shape (3,) or (4,), and what it leaves of the values, shape (n,)."""

    cycles: float
    constants: Floats
    rest: Floats


def sinusoid_of(
    values: Floats, place: Floats, least_cycles: float, middle: float | None = None
) -> Sinusoid | None:
    """Return the sinusoid that leaves least of values of mean zero, shape (n,), at places from 0 to 1 in a
    record, of no fewer cycles over it and at most one in four values; None of too few values. It is about a
    line where the `middle` of that is given, as in `swing_basis`.

    The maximum of a periodogram begins the search for the least squares.
    """
    count = len(values)
    first, last = math.ceil(_FINER * least_cycles), int(_FINER * _FASTEST * count)
    if not first < last:
        return None
    level = values if middle is None else values - np.polynomial.Polynomial.fit(place, values, 1)(place)
    power = np.abs(fft.rfft(level, _FINER * count)[first:last]) ** 2
    near = (first + int(np.argmax(power))) / _FINER

    def left(cycles: float) -> float:
        rest = _fitted(values, swing_basis(place, cycles, middle))[1]
        return float(rest @ rest)

    from scipy.optimize import minimize_scalar  # takes longer than all else here

    bounds = max(least_cycles, near - _NEAR), near + _NEAR
    cycles = float(minimize_scalar(left, bounds=bounds, method="bounded", options={"xatol": _EXACTLY}).x)
    return Sinusoid(cycles, *_fitted(values, swing_basis(place, cycles, middle)))


def swing_basis(place: Floats, cycles: float, middle: float | None = None) -> Floats:
    """Return a constant and a sinusoid of so many cycles over a record, at places from 0 to 1 in it, and a
    line that is 0 in the `middle`, if one is given, shape (n, 3) or (n, 4)."""
    turned = 2.0 * np.pi * cycles * place
    columns = [np.ones(len(place)), np.cos(turned), np.sin(turned)]
    return np.stack(columns if middle is None else [*columns, place - middle], axis=1)


def _fitted(values: Floats, basis: Floats) -> tuple[Floats, Floats]:
    """Return the constants of a basis, shape (3,) or (4,), and what they leave of the values, shape (n,)."""
    found = np.asarray(np.linalg.solve(basis.T @ basis, basis.T @ values), dtype=np.float64)
    return found, values - basis @ found
