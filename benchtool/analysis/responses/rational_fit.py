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
_PLACES = 12  # of a pole beside a zero, that are tried
_SHOWN = 3.0  # by which such a pair has to lower the sum of squares: its two unknowns do so by 2 by chance
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
    def zeros(self) -> int:
        return len(self.numerator) - 1

    @property
    def poles(self) -> int:
        return len(self.denominator)

    @property
    def unknowns(self) -> int:
        return len(self.numerator) + len(self.denominator)


@dataclass(frozen=True)
class _Points:
    """Powers of s, shape (n, powers), responses, and inverse errors of one component, both of shape (n,)."""

    powers: Complex
    response: Complex
    weight: Floats

    def split(self, unknowns: Floats, zeros: int) -> _Split:
        """Return the parts of a ratio at the points."""
        poles = len(unknowns) - zeros - 1
        numerator = self.powers[:, : zeros + 1] @ unknowns[: zeros + 1]
        denominator = 1.0 + self.powers[:, 1 : poles + 1] @ unknowns[zeros + 1 :]
        left = (self.response - numerator / denominator) * self.weight
        squares = left.real**2 + left.imag**2
        total = float(np.sum(squares))
        return _Split(
            unknowns, numerator, denominator, left, squares, total if total < math.inf else math.inf
        )


@dataclass(frozen=True)
class _Split:
    """A ratio of these unknowns at points: numerator, denominator, what it leaves in units of the errors, all
    of shape (n,), the squares of that, and their sum, infinite where the ratio is not defined."""

    unknowns: Floats
    numerator: Complex
    denominator: Complex
    left: Complex
    squares: Floats
    total: float


def rational_fit(
    powers: Complex,
    response: Complex,
    spread: Floats,
    zeros: int,
    poles: int,
    begin: RationalFit | None = None,
    within: RationalFit | None = None,
) -> RationalFit:
    """Return the fit with so many zeros and poles to responses, shape (n,), whose components have the
    standard deviations `spread`; `powers`, shape (n, more than `poles`), are those of s from 0 on.

    Linear least squares with the last denominator as the weight (Sanathanan and Koerner, IEEE Trans. Autom.
    Control 8 (1963) 56), from 1 on and from that of a fit `begin` with fewer of both; or the fit `within`,
    with one zero and one pole fewer, and a pole beside a zero where that lowers most what it leaves, which
    linear least squares of many points above these miss; and from the best of these on by damped Gauss-Newton
    steps (Marquardt, J. SIAM 11 (1963) 431).
    """
    points = _Points(powers, response, 1.0 / spread)
    unknowns = np.zeros(zeros + poles + 1)
    denominators = [np.ones(len(response), dtype=np.complex128)]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if begin is not None:
            unknowns[: len(begin.numerator)] = begin.numerator
            unknowns[zeros + 1 : zeros + 1 + len(begin.denominator)] = begin.denominator
        best = points.split(unknowns, zeros)
        if begin is not None:
            denominators.append(best.denominator)
        linear = np.hstack((powers[:, : zeros + 1], -response[:, np.newaxis] * powers[:, 1 : poles + 1]))
        for weighting in denominators:
            denominator = weighting
            for _ in range(_LINEAR_ROUNDS if poles else 1):
                weight = points.weight / np.abs(denominator)
                product, at, size = _normal(linear * weight[:, np.newaxis], response * weight)
                found = points.split(np.linalg.solve(product, at) / size, zeros)
                denominator = found.denominator
                if found.total < best.total:
                    best = found
        if within is not None and (pair := _with_a_pair(points, within)) is not None:
            best = min(best, points.split(pair, zeros), key=lambda each: each.total)
    return _refined(points, best, zeros, poles)


def _with_a_pair(points: _Points, within: RationalFit) -> Floats | None:
    """Return the unknowns of a fit times 1 + g + e / (1 + s / a), a pole beside a zero: of several a between
    the points the one that leaves least, with the least-squares g and e; None where it leaves no less than
    chance does."""
    fit = points.split(np.concatenate((within.numerator, within.denominator)), len(within.numerator) - 1)
    values = (fit.numerator / fit.denominator * points.weight)[:, np.newaxis]
    f = np.abs(points.powers[:, 1])
    places = np.geomspace(f[0], f[-1], _PLACES)
    columns = values / (1.0 + points.powers[:, 1:2] / places)
    gg = float(np.sum(np.abs(values) ** 2))
    ge = np.sum((np.conj(values) * columns).real, axis=0)
    ee = np.sum(np.abs(columns) ** 2, axis=0)
    left = fit.left[:, np.newaxis]
    g, e = np.sum((np.conj(values) * left).real), np.sum((np.conj(columns) * left).real, axis=0)
    determinant = np.maximum(gg * ee - ge**2, _RIDGE * gg * ee)
    gains, extras = (ee * g - ge * e) / determinant, (gg * e - ge * g) / determinant
    less = gains * g + extras * e  # by which the sum of squares is less
    at = int(np.argmax(less))
    if not less[at] > _SHOWN:
        return None
    gain, extra, slow = 1.0 + float(gains[at]), float(extras[at]), 1.0 / float(places[at])
    numerator = np.convolve(within.numerator, [gain + extra, gain * slow])
    denominator = np.convolve(np.concatenate(([1.0], within.denominator)), [1.0, slow])
    return np.concatenate((numerator, denominator[1:]))


def _refined(points: _Points, best: _Split, zeros: int, poles: int) -> RationalFit:
    damping = _DAMPING
    product, at, size = _tangent(points, best, zeros, poles)
    for _ in range(_ROUNDS):
        before = best.total
        for _ in range(_TRIES):
            step = np.linalg.solve(product + damping * np.eye(len(at)), at) / size
            if (found := points.split(best.unknowns + step, zeros)).total < best.total:
                best, damping = found, damping * _DAMPED_LESS
                break
            damping /= _DAMPED_LESS
        if not best.total < before:
            break
        product, at, size = _tangent(points, best, zeros, poles)
        if before - best.total < _SETTLED:
            break
    variance = float(np.linalg.inv(product)[0, 0]) / float(size[0]) ** 2
    return RationalFit(best.unknowns[: zeros + 1], best.unknowns[zeros + 1 :], variance, best.squares)


def _tangent(points: _Points, at: _Split, zeros: int, poles: int) -> tuple[Floats, Floats, Floats]:
    """Return the normal equations of a step from the unknowns, as `_normal`."""
    by_zero = points.weight / at.denominator
    by_pole = -by_zero * at.numerator / at.denominator
    columns = np.empty((len(at.left), zeros + 1 + poles), dtype=np.complex128)
    np.multiply(points.powers[:, : zeros + 1], by_zero[:, np.newaxis], out=columns[:, : zeros + 1])
    np.multiply(points.powers[:, 1 : poles + 1], by_pole[:, np.newaxis], out=columns[:, zeros + 1 :])
    return _normal(columns, at.left)


def _normal(columns: Complex, values: Complex) -> tuple[Floats, Floats, Floats]:
    """Return the normal equations of real unknowns, of columns of unit length, and their lengths before."""
    conjugate = columns.conj().T
    product = (conjugate @ columns).real
    size = np.sqrt(np.diagonal(product))
    size = np.where(size > 0.0, size, 1.0)
    product = product / (size[:, np.newaxis] * size)
    product.flat[:: len(product) + 1] += _RIDGE  # of the diagonal
    return product, (conjugate @ values).real / size, size
