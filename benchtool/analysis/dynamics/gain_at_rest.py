"""Gain of a frequency response continued to zero frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_LONGER = 1.5
_FITS = 2.0  # standard deviations of the mean squared residual above 1: a fit that describes its points
_MOST_TERMS = 5
_REWEIGHTED = 3  # fits, each with the weights of the one before
_LEAST_ERROR = 1e-9  # least error, so that a fit of exact values has weights


@dataclass(frozen=True)
class GainAtRest:
    """Gain of a response at zero frequency and its standard uncertainty relative to it."""

    gain: float
    relative_error: float


def gain_at_rest(
    frequency_Hz: Floats, gain: Floats, error: Floats, shared: Floats | None = None
) -> GainAtRest:
    """Return the gain continued to zero frequency, from gains of shape (n,) with their relative errors as if
    uncorrelated; `shared` of them each tell as much as one, all different ones without it.

    1 / gain^2 is a polynomial of f^2 wherever the response has no zeros: of a first-order lag a line, of two
    poles a parabola, whatever their damping. Of the fits to the lowest frequencies that describe their
    points, and that no further terms change by more than their uncertainty, each with a term more, the most
    certain; what that term changes beyond its own scatter is part of the uncertainty. Where none does, the
    lowest gain stands for it, as far off as it is from the next at least.
    """
    inverse = -2.0 * np.log(gain / gain[0])
    standard = np.maximum(2.0 * error, _LEAST_ERROR)
    square = (frequency_Hz / frequency_Hz[-1]) ** 2
    independent = np.cumsum(np.ones(len(gain)) if shared is None else 1.0 / shared)
    apart = abs(float(gain[:2][-1] / gain[0]) - 1.0)
    best, least = GainAtRest(float(gain[0]), math.hypot(float(error[0]), apart)), math.inf
    count = 3
    while count <= len(gain):
        lowest = slice(None, count)
        found = (
            _intercept(square[lowest], inverse[lowest], standard[lowest], terms, independent[count - 1])
            for terms in range(1, _MOST_TERMS + 1)
        )
        fits = [each for each in found if each is not None and each.value > 0.0]
        for number, (fit, richer) in enumerate(pairwise(fits)):
            if not fit.describes or richer.standard >= least or not fit.stays(fits[number + 1 :]):
                continue
            least = richer.standard
            # a term more scatters by the difference of the variances (Hausman, Econometrica 46 (1978) 1251)
            by_chance = max(0.0, richer.standard**2 - fit.standard**2)
            changed = max(0.0, (richer.value - fit.value) ** 2 - by_chance)
            spread = math.sqrt(richer.standard**2 + changed)
            best = GainAtRest(float(gain[0]) / math.sqrt(richer.value), 0.5 * spread / richer.value)
        count = math.ceil(_LONGER * count)
    return best


@dataclass(frozen=True)
class _Intercept:
    value: float
    standard: float
    describes: bool

    def stays(self, richer: Sequence[_Intercept]) -> bool:
        """Return whether none of the fits with more terms is elsewhere."""
        return all(
            abs(each.value - self.value) <= _FITS * math.hypot(each.standard, self.standard)
            for each in richer
        )


def _intercept(
    places: Floats, logarithms: Floats, error: Floats, terms: int, independent: float
) -> _Intercept | None:
    """Return the value at zero of a polynomial whose logarithms at the places are given with their errors, as
    if uncorrelated, where so many of them are; None with fewer of these than it has terms.

    Logarithms of gains are not biased by their errors, which reciprocals are; and weights that follow from
    the polynomial do not prefer the values that are small by chance.
    """
    freedom = independent - terms
    if not freedom > 0.0:
        return None
    powers = (places / places[-1])[:, np.newaxis] ** np.arange(terms)
    polynomial, left = np.exp(logarithms), np.zeros(len(places))
    for _ in range(_REWEIGHTED):
        columns = powers / (error * polynomial)[:, np.newaxis]
        solution, *_ = np.linalg.lstsq(columns, (1.0 + left) / error, rcond=None)
        polynomial = powers @ solution
        if not np.all(polynomial > 0.0):
            return None
        left = logarithms - np.log(polynomial)
    mean_square = float(np.sum((left / error) ** 2)) / freedom
    variance = float(np.linalg.pinv(columns.T @ columns)[0, 0]) * max(1.0, mean_square)
    return _Intercept(
        float(solution[0]), math.sqrt(variance), mean_square <= 1.0 + _FITS * math.sqrt(2.0 / freedom)
    )
