"""A parabola through neighbouring values of a curve with errors, and what a cubic adds."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FITS = 2.0  # standard deviations of the mean squared residual above 1: a fit that describes its points
_PARABOLA, _CUBIC = 3, 4  # terms
_FAR = 0.25  # of the frequency: errors hide how a curve bends over more than that
_ALONG = 9  # places
_MOST = 9.0  # mean squared residual of five values, reached by chance once in e^9


@dataclass(frozen=True)
class LocalParabola:
    """Weighted least-squares parabola about 0: coefficients, their covariance, by the errors or by what it
    leaves; whether it describes its points, and the mean square, in their errors, of what it leaves.

    `cubic` are the coefficients of one through the same points, all within `reach`, or of the parabola where
    there are too few, and `last` is the last of them.
    """

    coefficients: Floats
    covariance: Floats
    describes: bool
    mean_square: float
    cubic: Floats
    reach: float
    last: float

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
        mean_square, reach = float(left @ left) / freedom, float(np.max(np.abs(places)))
        coefficients: Floats = np.zeros(_PARABOLA)
        covariance: Floats = np.zeros((_PARABOLA, _PARABOLA))
        coefficients[:terms] = solution
        inverse = np.linalg.pinv((columns * weights[:, np.newaxis]).T @ columns)
        covariance[:terms, :terms] = inverse * max(scatter, mean_square)
        return cls(
            coefficients,
            covariance,
            mean_square <= 1.0 + _FITS * math.sqrt(2.0 / freedom),
            mean_square,
            fitted(_CUBIC) if len(places) > _CUBIC else coefficients,
            reach,
            float(np.max(places)),
        )

    @property
    def misses(self) -> bool:
        """Whether it misses its points by more than errors make it do."""
        return self.mean_square > _MOST

    @property
    def bridges(self) -> bool:
        """Whether it misses its points, or they are so far apart that errors hide how the curve bends."""
        return self.misses or self.reach > _FAR

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

    def left_out(self, place: float) -> float:
        """By how much a cubic differs there."""
        return float(np.polynomial.polynomial.polyval(place, self.cubic)) - self.value_at(place)

    def most_below(self, level: float, place: float) -> float:
        """Return by how much it is below a level at most, in standard uncertainties, from a place on up to
        the last of its points."""
        along = np.linspace(place, max(place, self.last), _ALONG)
        return max((level - self.value_at(at)) / self.error_at(at) for at in along.tolist())

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
