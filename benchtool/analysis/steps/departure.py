"""Where a signal leaves its level before a step, through the noise that hides its start."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.noisy_curve import NoisyCurve, at_rest_error
from benchtool.analysis.steps.passages import Instant
from benchtool.analysis.steps.step_shape import Step

Floats = NDArray[np.float64]

_LEAST = 0.02  # of the step: the least that counts as a movement
SIGMAS = 3.0
"""Standard uncertainties of the curve: likewise."""
_HALF_WAY, _FURTHEST = 0.5, 0.85  # of the way: to where the order of an answer is read, and at most
_APART = 3.0  # times the level that clears the noise: to where it is read at least
_ORDERS = 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0  # beyond, what is before the level hardly changes


def departure(step: Step, curve: NoisyCurve) -> Instant | None:
    """Return where the signal leaves its level before the step.

    The curve clears the noise later than that: from there the start is extrapolated along a lag after a dead
    time. Of which order it is, the way on to half the step shows: from one that is fastest at its start to a
    curve in the shape of an S. What noise makes of all three places is drawn, and with it the order.
    """
    curve, least = curve.beyond(float(np.mean(step.y_before))), _LEAST * step.height
    clear = np.maximum(least, SIGMAS * curve.standard)
    # a level at rest is anywhere within half a step of a converter that its noise does not hide
    of_level = at_rest_error(step.y_before, step.y)
    left = curve.passage(clear, of_level)
    if left is None:
        return None
    threshold = float(clear[max(0, math.floor(left.place))])
    if threshold <= least:
        return left.instant
    height = min(step.height, float(np.max(curve.values)))
    near = threshold / height
    top = min(max(_HALF_WAY, _APART * near), _FURTHEST)
    if near >= top:
        return None
    levels = least / height, near, math.sqrt(near * top), top
    middle, last = (curve.passage(level * height, of_level) for level in levels[2:])
    if middle is None or last is None:
        return None
    start = _start(levels, left.place, middle.place, last.place)
    return left.moved(float(start), _start(levels, left.places, middle.places, last.places))


def _start(
    levels: tuple[float, ...], near: float | Floats, middle: float | Floats, last: float | Floats
) -> Floats:
    """Return where a lag passes the lowest of four `levels`, relative to its end, by its places at the other
    three, each of shape (draws,) or one.

    Lags of n equal time constants have answered by the distribution function of the gamma distribution of
    shape n (Johnson, Kotz and Balakrishnan, Continuous Univariate Distributions 1, 17); other n are between.
    """
    from scipy import special  # takes long to load

    apart = np.maximum(np.subtract(middle, near), 0.0)
    beyond = np.maximum(np.subtract(last, middle), 0.0)
    start, *at = (special.gammaincinv(_ORDERS, level) for level in levels)
    relative, back = (at[2] - at[1]) / (at[1] - at[0]), (at[0] - start) / (at[1] - at[0])
    ratio = np.divide(beyond, apart, out=np.full_like(apart, np.inf), where=apart > 0.0)
    return near - apart * np.interp(-ratio, -relative, back)
