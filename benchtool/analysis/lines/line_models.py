"""Models of lines in the bins of a spectrum under a Hann window, fitted by least squares against its noise.

The phase is that in the middle of the record, where it and the frequency of a line are independent.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Integers = NDArray[np.int64]
Model = Callable[[Floats], tuple[Complexes, Complexes]]
"""Of real unknowns, shape (n,): what they make of the bins, shape (bins,), and its slopes, (bins, n)."""

DOF_OF_NOISE: Final = 30.0
"""Degrees of freedom of a median of sixty neighbouring bins, of which every other one is independent."""

_NEIGHBOURS = (1.0, 2.0 / 3.0, 1.0 / 6.0)  # correlations of noise under a Hann window
_STEPS, _ENOUGH, _DAMPED, _MOST_DAMPED = 40, 1e-6, 1e-3, 1e8
_STEP, _ON_BIN = 1e-4, 1e-9  # bins: of a slope, and what is on one
_PLACES = 2048  # of a course, in the record


@dataclass(frozen=True)
class Fit:
    """A model fitted to bins: its `unknowns`, shape (n,), what is left of the bins, shape (bins,), the mean
    square of that over the one that noise would leave, by chance no less with the probability `by_chance`,
    and the covariance of the unknowns by noise, shape (n, n)."""

    unknowns: Floats
    left: Complexes
    excess: float
    by_chance: float
    covariance: Floats


def middle_bins(bins: Complexes, number: Integers) -> Complexes:
    """Return the bins of these numbers, shape (n,), with the phase as in the middle of the record."""
    return np.asarray(bins[number] * alternating(number))


def alternating(number: Integers | Floats) -> Floats:
    """Return 1 for even numbers and -1 for odd ones, shape (n,)."""
    return np.where(number % 2, -1.0, 1.0)


def phasors_at(bins: Complexes, place: Floats, count: int) -> Complexes:
    """Return the phasors of lines at places, shape (n,), each by the bin next to it."""
    nearest = np.round(place).astype(np.int64)
    return np.asarray(middle_bins(bins, nearest) / hann_kernel(nearest - place, count))


def hann_kernel(apart: Floats, count: int) -> Floats:
    """Return the bins of a line of amplitude one under a Hann window at distances from it, for `count`
    samples.

    They are D(x) + (D(x - 1) + D(x + 1)) / 2 of Dirichlet's kernel D(x) = sin(pi x) exp(j pi x / n) / (n sin
    (pi x / n)), which is the real number here.
    """
    width, angle = np.pi / count, np.pi / count * apart
    nearest = np.round(apart)
    numerator = alternating(nearest) * np.sin(np.pi * (apart - nearest)) * np.cos(angle) * np.sin(width) ** 2
    beside = np.sin(width * (1.0 - apart)) * np.sin(width * (1.0 + apart))
    pole = (np.abs(apart - nearest) < _ON_BIN) & (np.abs(nearest) <= 1.0)
    at_pole = np.where(nearest == 0.0, 1.0, 0.5)
    return np.where(pole, at_pole, numerator / np.where(pole, 1.0, count * np.sin(angle) * beside))


def steady(number: Integers, count: int) -> Model:
    """Return the model of steady lines in bins `number`; unknowns (real, imaginary, place) of each."""

    def model(unknowns: Floats) -> tuple[Complexes, Complexes]:
        real, imaginary, place = unknowns.reshape(-1, 3).T
        apart = number[:, np.newaxis] - place
        one, less, more = hann_kernel(np.stack([apart, apart - _STEP, apart + _STEP]), count)
        slope = (less - more) / (2.0 * _STEP)
        phasors = real + 1j * imaginary
        slopes = np.stack([one, 1j * one, phasors * slope], axis=2)
        return np.asarray(one @ phasors), np.asarray(slopes.reshape(len(number), -1))

    return model


def changing(number: Integers, count: int, parts: Complexes) -> Model:
    """Return the model of a line whose logarithm, of amplitude and j times phase, has a course besides.

    Unknowns: (real, imaginary, place), and a factor for each of `parts`, shape (n, `places(count)`).
    """
    at = places(count)
    window = (1.0 + np.cos(2.0 * np.pi * at)) / len(at)

    def model(unknowns: Floats) -> tuple[Complexes, Complexes]:
        phasor, place = complex(unknowns[0], unknowns[1]), unknowns[2]
        middle = round(float(place))
        turned = np.exp(-2j * np.pi * np.outer(number - middle, at))
        shape = window * np.exp(unknowns[3:] @ parts + 2j * np.pi * (place - middle) * at)
        rows = np.concatenate([np.ones((1, len(at))), 2j * np.pi * at[np.newaxis], parts])
        own = turned @ (rows * shape).T
        return phasor * own[:, 0], np.concatenate([own[:, :1], 1j * own[:, :1], phasor * own[:, 1:]], axis=1)

    return model


def places(count: int) -> Floats:
    """Return times in a record of `count` samples, from -1/2 to 1/2, at which a course is known."""
    size = min(count, _PLACES)
    return np.asarray(np.arange(size) / size - 0.5)


def fitted(model: Model, start: Floats, measured: Complexes, number: Integers, noise: float) -> Fit | None:
    """Return the model fitted to measured bins (Levenberg and Marquardt); None where it does not converge, or
    there are not more bins than unknowns.

    Noise has the rms amplitude `noise` in each of the bins `number`, and the correlation of a Hann window
    between them.
    """
    unknowns, damped = start.astype(np.float64), _DAMPED
    if 2 * len(number) < len(start) + 2:
        return None
    made, slopes = model(unknowns)
    for _ in range(_STEPS):
        left, table = as_real(measured - made), as_real(slopes)
        scale = np.sqrt(np.sum(table**2, axis=0))
        if not np.all(np.isfinite(scale)) or not np.all(scale > 0.0):
            return None
        scaled = table / scale
        square = scaled.T @ scaled + damped * np.eye(len(unknowns))
        step = np.linalg.solve(square, scaled.T @ left) / scale
        with np.errstate(over="ignore", invalid="ignore"):
            tried, tried_slopes = model(unknowns + step)
        if not float(np.sum(np.abs(measured - tried) ** 2)) <= float(left @ left):
            damped *= 10.0
            if damped > _MOST_DAMPED:
                break
            continue
        damped *= 0.1
        unknowns, made, slopes = unknowns + step, tried, tried_slopes
        if float(np.sum((step * scale) ** 2)) < _ENOUGH * float(left @ left):
            break
    return _judged(unknowns, measured - made, slopes, number, noise)


def _judged(
    unknowns: Floats, left: Complexes, slopes: Complexes, number: Integers, noise: float
) -> Fit | None:
    """Return a fit with what its residual says: its sum of squares is distributed about as a multiple of
    chi-square of the degrees of freedom that its mean and variance give (Satterthwaite)."""
    table, lag = as_real(slopes), np.abs(number[:, np.newaxis] - number)
    correlation = np.where(lag < len(_NEIGHBOURS), np.take(_NEIGHBOURS, np.minimum(lag, 2)), 0.0)
    of_noise = 0.5 * noise**2 * np.kron(np.eye(2), correlation)
    inverse = np.linalg.pinv(table)
    rest = of_noise - table @ (inverse @ of_noise)
    mean, square = float(np.trace(rest)), float(np.sum(rest * rest.T))
    if not mean > 0.0:
        return None
    ratio = float(np.sum(np.abs(left) ** 2)) / mean
    by_chance = fisher_above(mean**2 / square, DOF_OF_NOISE, ratio)
    return Fit(unknowns, left, ratio, by_chance, inverse @ of_noise @ inverse.T)


def as_real(values: Complexes) -> Floats:
    """Return real parts, and imaginary parts behind them, along the first axis."""
    return np.concatenate([values.real, values.imag])
