"""Response of one DFT to another where both are smooth over neighbouring bins: the local polynomial method.

Over a few bins around f, Y = H X + T, with the response H a parabola of frequency and T, what the two ends of
the record leave in (the output still moving at its start, cut off at its end), a line or a parabola. Least
squares separate them, and the residual is the noise (Pintelon and Schoukens, System Identification: A
Frequency Domain Approach, 2nd ed., 7.2). Where a resonance is sharper than a parabola follows, and that
shows, the response is a parabola over a line, which has a pole (local rational method: McKelvey and Guérin,
IFAC Proc. 45 (2012) no. 16).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

REACH = 8  # bins to either side
_CURVED = 3  # terms of a parabola
_SHARP = 3.0  # times the variance that a pole leaves: a parabola does not follow
_BATCH = 1024  # bins at a time: their matrices stay in the cache

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LocalFit:
    """At every `at`, all of shape (m,): response, its standard uncertainty relative to it, mean input power.

    The uncertainty is of one component, along the response or across it.
    """

    response: Complex
    error: Floats
    power: Floats


def local_fit(x: Complex, y: Complex, at: NDArray[np.int64], *, at_rest: bool) -> LocalFit:
    """Fit the response of bins `y` to bins `x`, shape (bins,), around bins `at`, each `REACH` from the ends.

    A record that begins and ends `at_rest` has no T. Otherwise what a parabola in place of a line for T
    changes is taken as an error of its own: where a sweep begins and ends, H X looks like T.
    """
    parts = [_fit(x, y, at[start : start + _BATCH], at_rest) for start in range(0, len(at), _BATCH)]
    response, error, power = (np.concatenate(each) for each in zip(*parts, strict=True))
    return LocalFit(response, error, power)


def degrees_of_freedom(*, at_rest: bool) -> int:
    """Return the complex equations less unknowns of one fit."""
    return 2 * REACH + 1 - _CURVED - (0 if at_rest else 2)


def _fit(x: Complex, y: Complex, at: NDArray[np.int64], at_rest: bool) -> tuple[Complex, Floats, Floats]:
    offset = np.arange(-REACH, REACH + 1)
    near_x, near_y = x[at[:, np.newaxis] + offset], y[at[:, np.newaxis] + offset]
    power = np.mean(np.abs(near_x) ** 2, axis=1)
    scale = np.sqrt(np.maximum(power, np.finfo(np.float64).tiny))
    near_x = near_x / scale[:, np.newaxis]
    if at_rest:
        response, variance = _smooth_or_sharp(near_x, near_y, 0)
    else:
        response, variance = _smooth_or_sharp(near_x, near_y, 2)
        variance = variance + np.abs(_smooth_or_sharp(near_x, near_y, _CURVED)[0] - response) ** 2
    size = np.maximum(np.abs(response), np.finfo(np.float64).tiny)
    return response / scale, np.sqrt(0.5 * variance) / size, power


def _smooth_or_sharp(near_x: Complex, near_y: Complex, ends: int) -> tuple[Complex, Floats]:
    """Return response at the middle with `ends` terms of T, and its complex variance, both of shape (m,)."""
    response, variance = _solve(near_x, near_y, ends, poles=0)
    sharp, variance_sharp = _solve(near_x, near_y, ends, poles=1)
    better = variance > _SHARP * variance_sharp
    return np.where(better, sharp, response), np.where(better, variance_sharp, variance)


def _solve(near_x: Complex, near_y: Complex, ends: int, poles: int) -> tuple[Complex, Floats]:
    """Return the fit of a response with `poles` poles."""
    count, width = near_x.shape
    powers = np.linspace(-1.0, 1.0, width)[:, np.newaxis] ** np.arange(_CURVED)
    columns = np.empty((count, width, _CURVED + ends + poles), dtype=np.complex128)
    columns[:, :, :_CURVED] = near_x[:, :, np.newaxis] * powers
    columns[:, :, _CURVED : _CURVED + ends] = powers[:, :ends]
    columns[:, :, _CURVED + ends :] = -near_y[:, :, np.newaxis] * powers[:, 1 : 1 + poles]
    orthogonal, triangular = np.linalg.qr(columns)
    along = np.conj(orthogonal.transpose(0, 2, 1)) @ near_y[:, :, np.newaxis]
    left = near_y - (orthogonal @ along)[:, :, 0]
    noise = np.sum(np.abs(left) ** 2, axis=1) / (width - columns.shape[2])
    first_row = np.linalg.pinv(triangular)[:, 0, :]
    response = np.sum(first_row * along[:, :, 0], axis=1)
    return response, noise * np.sum(np.abs(first_row) ** 2, axis=1)
