"""Fits of N(s) / D(s) with real coefficients to a frequency response, s = j f."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]

_LINEAR_ROUNDS = 3  # each with the denominator of the one before as its weight
_ROUNDS, _TRIES = 6, 3
_DAMPING, _DAMPED_LESS = 1e-3, 0.1
_SETTLED = 1e-3  # of a sum of squares in units of the errors
_RIDGE = 1e-12  # of columns of unit length: what rounding leaves of their products


@dataclass(frozen=True)
class RationalFit:
    """N(s) / D(s), D(0) = 1: `numerator` and `denominator`, the latter without its 1, rising powers of s.

    `at_rest` is its value at zero frequency and `variance` that of it, `squares`, shape (n,), what it leaves
    at each frequency, of both components together and in units of the variance of one.
    """

    numerator: Floats
    denominator: Floats
    variance: float
    squares: Floats

    @property
    def at_rest(self) -> float:
        return float(self.numerator[0])

    @property
    def unknowns(self) -> int:
        return len(self.numerator) + len(self.denominator)


@dataclass(frozen=True)
class _Points:
    """Powers of s, shape (n, powers), responses, and inverse errors of one component, both of shape (n,)."""

    powers: Complex
    response: Complex
    weight: Floats

    def split(self, unknowns: Floats, zeros: int) -> tuple[Complex, Complex, Complex]:
        """Return numerator, denominator and what these leave in units of the errors, each of shape (n,)."""
        poles = len(unknowns) - zeros - 1
        numerator = self.powers[:, : zeros + 1] @ unknowns[: zeros + 1]
        denominator = 1.0 + self.powers[:, 1 : poles + 1] @ unknowns[zeros + 1 :]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            left = (self.response - numerator / denominator) * self.weight
        return numerator, denominator, left

    def squares(self, unknowns: Floats, zeros: int) -> float:
        total = float(np.sum(np.abs(self.split(unknowns, zeros)[2]) ** 2))
        return total if math.isfinite(total) else math.inf


def rational_fit(
    powers: Complex,
    response: Complex,
    spread: Floats,
    zeros: int,
    poles: int,
    begin: RationalFit | None = None,
) -> RationalFit:
    """Return the fit with so many zeros and poles to responses, shape (n,), whose components have the
    standard deviations `spread`; `powers`, shape (n, more than `poles`), are those of s from 0 on.

    Linear least squares with the last denominator as the weight (Sanathanan and Koerner, IEEE Trans. Autom.
    Control 8 (1963) 56), from 1 on and from that of a fit `begin` with fewer of both, and from the better
    of these on by damped Gauss-Newton steps (Marquardt, J. SIAM 11 (1963) 431).
    """
    points = _Points(powers, response, 1.0 / spread)
    best, least = np.zeros(zeros + poles + 1), math.inf
    denominators = [np.ones(len(response), dtype=np.complex128)]
    if begin is not None:
        best[: len(begin.numerator)] = begin.numerator
        best[zeros + 1 : zeros + 1 + len(begin.denominator)] = begin.denominator
        least = points.squares(best, zeros)
        denominators.append(points.split(best, zeros)[1])
    for weighting in denominators:
        denominator = weighting
        for _ in range(_LINEAR_ROUNDS if poles else 1):
            weight = points.weight / np.abs(denominator)
            columns = (powers[:, : zeros + 1], -response[:, np.newaxis] * powers[:, 1 : poles + 1])
            product, at, size = _normal(np.hstack(columns) * weight[:, np.newaxis], response * weight)
            found = np.linalg.solve(product, at) / size
            denominator = points.split(found, zeros)[1]
            squares = points.squares(found, zeros)
            if squares < least:
                best, least = found, squares
    return _refined(points, best, zeros, poles)


def _refined(points: _Points, unknowns: Floats, zeros: int, poles: int) -> RationalFit:
    squares, damping = points.squares(unknowns, zeros), _DAMPING
    product, at, size = _tangent(points, unknowns, zeros, poles)
    for _ in range(_ROUNDS):
        before = squares
        for _ in range(_TRIES):
            step = np.linalg.solve(product + damping * np.eye(len(at)), at) / size
            if (found := points.squares(unknowns + step, zeros)) < squares:
                unknowns, squares, damping = unknowns + step, found, damping * _DAMPED_LESS
                break
            damping /= _DAMPED_LESS
        if not squares < before:
            break
        product, at, size = _tangent(points, unknowns, zeros, poles)
        if before - squares < _SETTLED:
            break
    variance = float(np.linalg.inv(product)[0, 0]) / float(size[0]) ** 2
    left = np.abs(points.split(unknowns, zeros)[2]) ** 2
    return RationalFit(unknowns[: zeros + 1], unknowns[zeros + 1 :], variance, left)


def _tangent(points: _Points, unknowns: Floats, zeros: int, poles: int) -> tuple[Floats, Floats, Floats]:
    """Return the normal equations of a step from the unknowns, as `_normal`."""
    numerator, denominator, left = points.split(unknowns, zeros)
    by_pole = -(numerator / denominator**2)[:, np.newaxis] * points.powers[:, 1 : poles + 1]
    columns = (points.powers[:, : zeros + 1] / denominator[:, np.newaxis], by_pole)
    return _normal(np.hstack(columns) * points.weight[:, np.newaxis], left)


def _normal(columns: Complex, values: Complex) -> tuple[Floats, Floats, Floats]:
    """Return the normal equations of real unknowns, of columns of unit length, and their lengths before."""
    product = np.real(columns.conj().T @ columns)
    size = np.sqrt(np.diagonal(product))
    size = np.where(size > 0.0, size, 1.0)
    product = product / np.outer(size, size) + _RIDGE * np.eye(len(size))
    return product, np.real(values @ columns.conj()) / size, size
