"""A cubic through the five values of a curve nearest to a place, and what polynomials of higher order change.

Of values that no parabola follows, their errors are small against how the curve bends. What a cubic leaves
out then shows in the quartic through the same five values, and in the sextic through the nearest seven: each
alone may agree with it by chance.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

NEAREST = 7
"""Values that tell what a cubic leaves out."""

_CUBIC, _FIVE = 4, 5  # terms; values
_REAL = 1e-9  # imaginary part of a real root


@dataclass(frozen=True)
class LocalCubic:
    """Weighted least-squares cubic about 0: coefficients of places over `reach`, their covariance, and the
    coefficients of polynomials `beyond` it."""

    coefficients: Floats
    covariance: Floats
    beyond: tuple[Floats, ...]
    reach: float

    @classmethod
    def through(cls, places: Floats, values: Floats, weights: Floats, scatter: float) -> LocalCubic:
        """Fit the first five of values at places, with weights of one over the squared errors, all of shape
        (n,), nearest to 0 first, by whose mean square times `scatter` they scatter."""
        near = slice(None, _FIVE)
        reach = float(np.max(np.abs(places[near])))
        root = np.sqrt(weights[near])
        columns = np.vander(places[near] / reach, min(_CUBIC, len(places)), increasing=True)
        columns *= root[:, np.newaxis]
        solution, *_ = np.linalg.lstsq(columns, values[near] * root, rcond=None)
        beyond = tuple(
            np.asarray(np.linalg.solve(np.vander(places[:count] / reach, increasing=True), values[:count]))
            for count in _counts(len(places))
        )
        covariance = np.asarray(np.linalg.pinv(columns.T @ columns) * scatter)
        return cls(np.asarray(solution), covariance, beyond, reach)

    def at_zero(self) -> tuple[float, float]:
        """Return the value at 0 and its standard uncertainty."""
        level = float(self.coefficients[0])
        left = (float(each[0]) - level for each in self.beyond)
        return level, math.hypot(math.sqrt(self.covariance[0, 0]), *left)

    def zero(self, level: float, level_error: float) -> tuple[float, float]:
        """Return the place nearest to 0, within five values, where it has a level of this standard
        uncertainty, and that of the place; nan without one."""
        place, *others = (_zero(each, level) for each in (self.coefficients, *self.beyond))
        slope = _at(place, np.asarray(np.polynomial.polynomial.polyder(self.coefficients)))
        if not abs(place) <= 1.0 or slope == 0.0:
            return math.nan, math.nan
        powers = place ** np.arange(len(self.coefficients))
        error = math.hypot(math.sqrt(float(powers @ self.covariance @ powers)), level_error)
        # one that does not pass the level is off by what it differs there
        left = (
            other - place if abs(other) <= 1.0 else (_at(place, each) - level) / slope
            for each, other in zip(self.beyond, others, strict=True)
        )
        return self.reach * place, self.reach * math.hypot(error / slope, *left)


def _at(place: float, coefficients: Floats) -> float:
    return float(np.polynomial.polynomial.polyval(place, coefficients))


def _counts(values: int) -> Sequence[int]:
    """Return through how many of the nearest values polynomials tell what a cubic leaves out; of few values
    one of a lower order does."""
    return sorted({_FIVE, min(NEAREST, values)}) if values >= _FIVE else (max(1, values - 1),)


def _zero(coefficients: Floats, level: float) -> float:
    """Return the place nearest to 0 at which a polynomial has a level; nan without one."""
    roots = np.polynomial.polynomial.polyroots(np.concatenate([[coefficients[0] - level], coefficients[1:]]))
    places = roots.real[np.abs(roots.imag) < _REAL]
    return float(places[np.argmin(np.abs(places))]) if len(places) else math.nan
