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
_CLEARLY = 1.5  # times the level that clears the noise: noise hardly makes the curve pass it early
_APART = 3.0  # times the level that clears the noise: to where it is read at least
_ORDERS = 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0  # beyond, what is before the level hardly changes


def departure(step: Step, curve: NoisyCurve) -> Instant | None:
    """Return where the signal leaves its level before the step.

    Where it clears the noise later than that, the start is extrapolated along a lag after a dead time from
    where no noise makes it pass early. Of which order the lag is, the way on to half the step shows: from
    one that is fastest at its start to a curve in the shape of an S. What noise makes of all three places is
    drawn, and with it the order.
    """
    curve, least = curve.beyond(float(np.mean(step.y_before))), _LEAST * step.height
    clear = np.maximum(least, SIGMAS * curve.standard)
    # a level at rest is anywhere within half a step of a converter that its noise does not hide
    of_level = at_rest_error(step.y_before, step.level_step)
    is_beyond = curve.values >= clear
    if not np.any(is_beyond):
        return None
    threshold = float(clear[np.argmax(is_beyond)])
    if threshold <= least:
        left = curve.passage(clear, of_level)
        return None if left is None else left.instant
    height = min(step.height, float(np.max(curve.values)))
    low = _CLEARLY * threshold / height
    high = min(max(_HALF_WAY, _APART * low), _FURTHEST)
    if low >= high:
        return None
    between = low, math.sqrt(low * high), high
    near, middle, last = (curve.passage(level * height, of_level) for level in between)
    if near is None or middle is None or last is None:
        return None
    levels = least / height, *between
    start = float(_start(levels, near.place, middle.place, last.place))
    return near.moved(start, _start(levels, near.places, middle.places, last.places))


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
    return np.asarray(near - apart * np.interp(-ratio, -relative, back))
