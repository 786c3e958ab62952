"""A parabola through neighbouring values of a curve with errors, and what polynomials of higher order add."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FITS = 2.0  # standard deviations of the mean squared residual above 1: a fit that describes its points
_PARABOLA, _CUBIC, _QUARTIC = 3, 4, 5  # terms
_FAR = 0.25  # of the frequency: from there on few points are followed by a cubic, nearer ones scatter
_OF_LEFT = 0.1  # of what a parabola leaves: errors that are alike do not show in what they are stated to be
_REAL = 1e-9  # imaginary part of a real root


@dataclass(frozen=True)
class LocalParabola:
    """Weighted least-squares parabola about 0: coefficients, their covariance, and the mean square of what it
    leaves relative to the errors, at least that of all points of the curve; and whether it describes its own.

    `scatter` is the mean square that a cubic leaves, likewise. `cubic` and `quartic` are the coefficients
    of such polynomials through the same points, all within `reach`, or of lower order where there are too
    few.
    """

    coefficients: Floats
    covariance: Floats
    left: float
    scatter: float
    describes: bool
    cubic: Floats
    quartic: Floats
    reach: float

    @classmethod
    def through(cls, places: Floats, values: Floats, weights: Floats, scatter: float = 1.0) -> LocalParabola:
        """Fit values at places, with weights of one over the squared errors, all of shape (n,), by whose
        mean square times `scatter` they scatter at least."""
        terms = min(_PARABOLA, len(places) - 1) if len(places) > 1 else 1
        root = np.sqrt(weights)

        def fitted(terms: int) -> Floats:
            columns = places[:, np.newaxis] ** np.arange(terms) * root[:, np.newaxis]
            return np.asarray(np.linalg.lstsq(columns, values * root, rcond=None)[0])

        solution, columns = fitted(terms), places[:, np.newaxis] ** np.arange(terms)
        left = (values - columns @ solution) * root
        freedom = max(1, len(places) - terms)
        mean_square = float(left @ left) / freedom
        coefficients: Floats = np.zeros(_PARABOLA)
        covariance: Floats = np.zeros((_PARABOLA, _PARABOLA))
        coefficients[:terms] = solution
        inverse = np.linalg.pinv((columns * weights[:, np.newaxis]).T @ columns)
        covariance[:terms, :terms] = inverse * max(scatter, mean_square)
        cubic, beyond = coefficients, mean_square
        if len(places) > _CUBIC:
            cubic = fitted(_CUBIC)
            rest = (values - np.polynomial.polynomial.polyval(places, cubic)) * root
            beyond = float(rest @ rest) / (len(places) - _CUBIC)
        return cls(
            coefficients,
            covariance,
            max(scatter, mean_square),
            max(scatter, min(beyond, mean_square)),
            mean_square <= 1.0 + _FITS * math.sqrt(2.0 / freedom),
            cubic,
            fitted(_QUARTIC) if len(places) >= _QUARTIC else cubic,
            float(np.max(np.abs(places))),
        )

    @property
    def bridges(self) -> bool:
        """Whether it bends over points far apart by more than their errors, and does not follow them."""
        return not self.describes and self.reach > _FAR

    @property
    def vertex(self) -> float:
        """Place of the least value; nan where it bends downwards or not at all."""
        _, slope, bend = self.coefficients.tolist()
        return -slope / (2.0 * bend) if bend > 0.0 else math.nan

    @property
    def below_by_vertex(self) -> float:
        """By how much the least value is too low on average, as errors place the vertex where they lower it:
        the variance of its place times the bend."""
        powers = np.array([0.0, 1.0, 2.0 * self.vertex])
        return float(powers @ self.covariance @ powers) / (4.0 * float(self.coefficients[2]))

    def value_at(self, place: float) -> float:
        return float(np.polynomial.polynomial.polyval(place, self.coefficients))

    def error_at(self, place: float) -> float:
        """Standard uncertainty of the value there, by the errors or by what it leaves."""
        powers = place ** np.arange(_PARABOLA)
        return math.sqrt(float(powers @ self.covariance @ powers))

    def noise_at(self, place: float) -> float:
        """Standard uncertainty of the value there by the errors, as large as a cubic's points scatter, and a
        little of what the parabola leaves."""
        return self.error_at(place) * math.hypot(math.sqrt(self.scatter / self.left), _OF_LEFT)

    def left_out(self, place: float) -> float:
        """By how much a cubic differs there."""
        return float(np.polynomial.polynomial.polyval(place, self.cubic)) - self.value_at(place)

    @property
    def level(self) -> float:
        return float(self.coefficients[0])

    @property
    def standard(self) -> float:
        return math.sqrt(float(self.covariance[0, 0]))

    def slope_at(self, place: float) -> float:
        return float(self.coefficients[1] + 2.0 * self.coefficients[2] * place)

    def zero(self, level: float) -> tuple[float, float]:
        """Place nearest to 0 at which it has a level, and its standard uncertainty; nan without one."""
        constant, b, c = self.coefficients.tolist()
        a = constant - level
        root = b * b - 4.0 * a * c
        if root < 0.0 or b == 0.0:
            return math.nan, math.nan
        place = -2.0 * a / (b + math.copysign(math.sqrt(root), b))
        slope = self.slope_at(place)
        return (place, self.error_at(place) / abs(slope)) if slope else (math.nan, math.nan)

    def zero_of(self, coefficients: Floats, level: float) -> float:
        """Return the place nearest to 0, within its reach, at which the cubic or quartic has a level; nan
        without one."""
        roots = np.polynomial.polynomial.polyroots(
            np.concatenate([[coefficients[0] - level], coefficients[1:]])
        )
        places = roots.real[np.abs(roots.imag) < _REAL]
        nearest = float(places[np.argmin(np.abs(places))]) if len(places) else math.nan
        return nearest if abs(nearest) <= self.reach else math.nan
