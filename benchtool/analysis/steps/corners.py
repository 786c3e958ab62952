"""The peak of an answer at a corner, as of one that is limited in its rate: where two courses meet.

Windows of a smooth curve cut a corner off: its height falls, and its place moves towards the flatter side.
Whether two parabolas that meet describe the samples about it better than a smooth course of as many
parameters, their likelihoods tell (model averaging: Hoeting et al., Statistical Science 14 (1999) 382).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.statistics.straight_lines import places_about_middle
from benchtool.analysis.steps.converter_levels import HIDES
from benchtool.analysis.steps.smoothing import Noise

Floats = NDArray[np.float64]

_LEAST_REACH, _MOST_REACH, _LONGER = 6, 120, 1.3  # rows to either side of the greatest value
_PARAMETERS = 6
_DESCRIBED = 2.0  # standard deviations of a sum of squares beyond what noise leaves
_PLACES, _WITHIN = 161, 0.5  # where a corner is looked for, over what of the reach to either side
_SHORTER, _OF_CHANGE = 2, 0.25  # stretches; what a stretch of 1.3^2 leaves out grows as its cube
_BY_CHANCE, _OF_MEMORY = 2.0, 3  # standard deviations of a correlation; times its length
_PRIOR, _IMPROBABLE = 0.2, 1e-4  # probability of a corner before the samples are seen; of hardly a corner


@dataclass(frozen=True)
class Corner:
    """Height of a corner, and its place in rows, with their standard uncertainties; `probability` is that of
    a corner against a smooth peak, and `reach` the rows to either side within which it is."""

    height: float
    height_error: float
    place: float
    place_error: float
    probability: float
    reach: int = 0

    def averaged(self, smooth: tuple[float, float], corner: tuple[float, float]) -> tuple[float, float]:
        """Return a value and its standard uncertainty of a `smooth` peak or of a `corner`, each as likely as
        it is."""
        share = self.probability
        apart = corner[0] - smooth[0]
        square = share * corner[1] ** 2 + (1.0 - share) * smooth[1] ** 2 + share * (1.0 - share) * apart**2
        return smooth[0] + share * apart, math.sqrt(square)


def corner_near(samples: Floats, noise: Noise, top: int, step: float = 0.0) -> Corner | None:
    """Return the corner near row `top` of samples, shape (n,), in this noise; None where there is no noise,
    where neither course describes the samples, or where there is hardly a corner.

    The longest stretch about `top` that one of them describes tells most. Errors of the `step` of a converter
    that show on the way through its levels alone, as noise at rest does not hide them, are noise there.
    """
    if not noise.rms > 0.0:
        return None
    if noise.rms < HIDES * step:
        covariance = noise.autocovariance.copy()
        covariance[0] += step**2 / 12.0
        noise = replace(noise, autocovariance=covariance)
    found: list[Corner] = []
    reach = float(_LEAST_REACH)
    while (rows := round(reach)) <= min(top, len(samples) - 1 - top, _MOST_REACH):
        fitted = _fitted(samples[top - rows : top + rows + 1], noise)
        if fitted is None:
            break
        if fitted.probability < _IMPROBABLE:
            return None
        found.append(fitted)
        reach *= _LONGER
    if not found:
        return None
    # how likely it is a long stretch tells best, where it is a shorter one, which leaves less out
    long, short = found[-1], found[max(0, len(found) - 1 - _SHORTER)]
    return Corner(
        short.height,
        math.hypot(short.height_error, _OF_CHANGE * (long.height - short.height)),
        top + short.place,
        math.hypot(short.place_error, _OF_CHANGE * (long.place - short.place)),
        long.probability,
        short.reach,
    )


def _fitted(samples: Floats, noise: Noise) -> Corner | None:
    """Return the corner about the middle of samples, shape (2 rows + 1,), with its place from there."""
    from scipy.linalg import cholesky, solve_triangular, toeplitz  # which most runs do not need

    count = len(samples)
    covariance = np.zeros(count)
    known = _significant(noise.autocovariance)
    lags = min(count, len(known))
    covariance[:lags] = known[:lags]
    covariance[0] *= 1.0 + 1e-9
    factor, rows = cholesky(toeplitz(covariance), lower=True), places_about_middle(count)
    white = solve_triangular(factor, samples, lower=True)

    of_smooth = _left(solve_triangular(factor, np.vander(rows / rows[-1], _PARAMETERS), lower=True), white)
    within = _WITHIN * rows[-1]
    places = np.linspace(-within, within, _PLACES)
    late = (rows[:, np.newaxis] - places) / rows[-1]
    before, after = np.minimum(late, 0.0), np.maximum(late, 0.0)
    courses = np.stack([np.ones_like(late), before, after, before**2, after**2])
    courses = solve_triangular(factor, courses.transpose(1, 2, 0).reshape(count, -1), lower=True)
    courses = courses.reshape(count, _PLACES, -1).transpose(1, 0, 2)
    inverse = np.linalg.inv(courses.transpose(0, 2, 1) @ courses)
    fits = np.einsum("pij,pj->pi", inverse, white @ courses)
    rises_and_falls = (fits[:, 1] > 0.0) & (fits[:, 2] < 0.0)
    residuals = white - np.einsum("pni,pi->pn", courses, fits)
    left = np.where(rises_and_falls, np.sum(residuals**2, axis=1), math.inf)
    heights, errors = fits[:, 0], np.sqrt(inverse[:, 0, 0])
    dof = count - _PARAMETERS
    least = float(np.min(left))
    if min(of_smooth, least) > dof + _DESCRIBED * math.sqrt(2.0 * dof):
        return None
    if not math.isfinite(least):
        return Corner(0.0, 0.0, 0.0, 0.0, 0.0)  # no parabolas that rise to it and fall
    weight = np.exp(-0.5 * (left - least))
    weight /= np.sum(weight)
    place, height = float(weight @ places), float(weight @ heights)
    odds = _PRIOR / (1.0 - _PRIOR) * math.exp(min(0.5 * (of_smooth - least), 50.0))
    return Corner(
        height,
        math.sqrt(float(weight @ (errors**2 + (heights - height) ** 2))),
        place,
        math.sqrt(float(weight @ (places - place) ** 2) + (places[1] - places[0]) ** 2 / 12.0),
        odds / (1.0 + odds),
        round(rows[-1]),
    )


def _significant(autocovariance: Floats) -> Floats:
    """Return an autocovariance, shape (lags,), of a piece four times as long, without those lags at which it
    is chance: courses would be fitted to it, and be found too certain. Tapered by Bartlett's window, its
    spectrum is nowhere negative."""
    by_chance = _BY_CHANCE / math.sqrt(4.0 * len(autocovariance)) * float(autocovariance[0])
    ended = np.flatnonzero(np.abs(autocovariance) < by_chance)
    last = int(ended[0]) if len(ended) else len(autocovariance)
    lags = 1 if last == 1 else min(_OF_MEMORY * last, len(autocovariance))
    return np.asarray(autocovariance[:lags] * (1.0 - np.arange(lags) / lags))


def _left(columns: Floats, white: Floats) -> float:
    """Return the sum of squares that a least-squares fit leaves."""
    fit, *_ = np.linalg.lstsq(columns, white, rcond=None)
    residual = white - columns @ fit
    return float(residual @ residual)
