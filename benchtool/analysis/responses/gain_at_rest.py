"""Gain of a frequency response continued to zero frequency."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_LONGER = 1.5
_FITS = 2.0  # standard deviations of the mean squared residual above 1: a fit that describes its points
_CLEARLY = 3.0  # standard deviations of a normal value that is as rare as what a piece leaves: there are many
_MOST_TERMS = 5
_REWEIGHTED = 3  # fits, each with the weights of the one before
_LEAST_ERROR = 1e-9  # least error, so that a fit of exact values has weights
_NO_ZERO = np.ones(1)
_ZEROS = np.geomspace(0.5, 40.0, 14)
"""By what a zero multiplies gain^2 at the last of some frequencies, evenly in its logarithm: zeros from a
sixth of that frequency on, and antiresonances from 1.4 times it on."""


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
    poles a parabola, whatever their damping. A zero at f_z, as a controller with an integral part has,
    divides it by 1 + (f / f_z)^2, which a polynomial does not follow beyond f_z. Of the fits to the lowest
    frequencies that describe their points, and that no richer ones change by more than their uncertainty, the
    most certain richer one is the answer: the mean of a polynomial with a term more and of those of as many
    terms over a zero, each by how well it describes the points. What it changes beyond its own scatter is in
    the uncertainty. Where none does, the lowest gain stands for it, as far off as it is from the next at
    least.
    """
    inverse = -2.0 * np.log(gain / gain[0])
    standard = np.maximum(2.0 * error, _LEAST_ERROR)
    square = (frequency_Hz / frequency_Hz[-1]) ** 2
    independent = np.cumsum(np.ones(len(gain)) if shared is None else 1.0 / shared)
    apart = abs(float(gain[:2][-1] / gain[0]) - 1.0)
    best, least = GainAtRest(float(gain[0]), math.hypot(float(error[0]), apart)), math.inf
    count, counts = 3, []
    while count <= len(gain):
        counts.append(count)
        lowest = slice(None, count)
        points = square[lowest], inverse[lowest], standard[lowest]
        pieces = independent[np.array(counts) - 1]
        most = min(_MOST_TERMS, math.ceil(pieces[-1]) - 1)  # with a degree of freedom left
        fits = [_fits(*points, terms + 1, _NO_ZERO) for terms in range(most)]
        plain = [_mean([each], counts, pieces, terms + 1) for terms, each in enumerate(fits)]
        richer_of = [
            _mean([fits[terms], _fits(*points, terms, _ZEROS)], counts, pieces, terms + 1)
            for terms in range(1, most)
        ]
        for number, (fit, richer) in enumerate(zip(plain, richer_of, strict=False)):
            if fit is None or richer is None or not fit.describes or richer.standard >= least:
                continue
            if not fit.stays([*plain[number + 1 :], *richer_of[number:]]):
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

    def stays(self, richer: Sequence[_Intercept | None]) -> bool:
        """Return whether none of the richer fits is elsewhere."""
        return all(
            abs(each.value - self.value) <= _FITS * math.hypot(each.standard, self.standard)
            for each in richer
            if each is not None
        )


def _mean(
    fits: Sequence[tuple[Floats, Floats, Floats]], counts: Sequence[int], independent: Floats, terms: int
) -> _Intercept | None:
    """Return the mean of the values at zero of kinds of fits, each as likely as another before the points
    tell, by how well they describe them; None where that is not above zero.

    The lowest `counts` of points are so many `independent` ones, the last of these all. The best fit
    describes them if it misses no such piece by more than chance: many points far above would hide that.

    Variance within and between them (Hoeting, Madigan, Raftery and Volinsky, Statistical Science 14 (1999)
    382, equations 1 to 3).
    """
    values, variances, left = (np.concatenate(each) for each in zip(*fits, strict=True))
    squares = np.cumsum(left, axis=1)[:, np.array(counts) - 1]
    best, freedom = int(np.argmin(squares[:, -1])), float(independent[-1]) - terms
    squares, of_best = squares[:, -1], squares[best]
    least = float(of_best[-1])
    if not math.isfinite(least):
        return None
    scatter = max(1.0, least / freedom)
    before = np.concatenate([np.full(len(each), 1.0 / len(each)) for each, _, _ in fits])
    weights = before * np.exp(-0.5 * (squares - least) / scatter)
    weights /= np.sum(weights)
    value = float(weights @ values)
    variance = float(weights @ (scatter * variances + (values - value) ** 2))
    # quantile of chi squared (Wilson and Hilferty, Proc. Nat. Acad. Sci. 17 (1931) 684)
    ninth = 2.0 / (9.0 * independent)
    misses = np.any(of_best > independent * (1.0 - ninth + _CLEARLY * np.sqrt(ninth)) ** 3)
    describes = not misses and least / freedom <= 1.0 + _FITS * math.sqrt(2.0 / freedom)
    return _Intercept(value, math.sqrt(variance), describes) if value > 0.0 else None


def _fits(
    places: Floats, logarithms: Floats, error: Floats, terms: int, zeros: Floats
) -> tuple[Floats, Floats, Floats]:
    """Return the values at zero of polynomials over each of the zeros, whose logarithms at the places are
    given with their errors, as if uncorrelated; their variances; and the squares that they leave at each
    place, shape (fits, places), infinite where one falls to zero between.

    Logarithms of gains are not biased by their errors, which reciprocals are; and weights that follow from
    the polynomial do not prefer the values that are small by chance.
    """
    reach = places / places[-1]
    powers = reach[:, np.newaxis] ** np.arange(terms)
    logarithms = logarithms + np.log1p(np.multiply.outer(zeros - 1.0, reach))
    polynomial, left = np.exp(logarithms), np.zeros(logarithms.shape)
    above = np.ones(len(zeros), dtype=np.bool_)
    for _ in range(_REWEIGHTED):
        base, triangle = np.linalg.qr(powers / (error * polynomial)[:, :, np.newaxis])
        projected = base.transpose(0, 2, 1) @ ((1.0 + left) / error)[:, :, np.newaxis]
        solution = np.linalg.solve(triangle, projected)[:, :, 0]
        found = solution @ powers.T
        above &= np.all(found > 0.0, axis=1)
        polynomial = np.where(above[:, np.newaxis], found, polynomial)
        left = logarithms - np.log(polynomial)
    squares = np.where(above[:, np.newaxis], (left / error) ** 2, math.inf)
    variances = np.sum(np.linalg.inv(triangle)[:, 0, :] ** 2, axis=1)  # of the first of (A^T A)^-1
    return solution[:, 0], variances, squares
