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
_CONCAVE = 0.3  # of the way back along a line: that of an answer that gets slower, or of a steep one
_FURTHER, _HALF_WAY = 3.0, 0.5  # times the level that clears the noise; of the step, up to which
_TO_THE_ENDS = 1.05  # standard uncertainties from the middle to such a start and to one along a parabola


def departure(step: Step, curve: NoisyCurve) -> Instant | None:
    """Return where the signal leaves its level before the step.

    The curve clears the noise later than that: the start is extrapolated from there and from three times as
    far, or twice where that is beyond half the step. It lies between a part of the way along a line, as of an
    answer that gets slower, and a parabola, as a second-order lag begins: the middle of both is taken. What
    noise makes of it is drawn, as noise that moves the one place moves the other too.
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
    times = _FURTHER if _FURTHER * threshold <= _HALF_WAY * step.height else 2.0
    further = curve.passage(times * threshold, of_level)
    if further is None:
        return None
    near, far = _back(left.place, further.place, times, least / threshold)
    of_draws = np.add(*_back(left.places, further.places, times, least / threshold))
    found = left.moved(left.place - 0.5 * float(near + far), left.places - 0.5 * of_draws)
    between = float(far - near) / (2.0 * _TO_THE_ENDS)
    return Instant(found.place, math.hypot(found.standard, between))


def _back(
    left: float | Floats, further: float | Floats, times: float, share: float
) -> tuple[Floats | float, Floats | float]:
    """Return how far before the place `left`, where a curve is beyond a level, it was at a `share` of that:
    by a line, or a steeper start, and by a parabola, both through where it is `further`, `times` as far
    beyond."""
    apart = np.maximum(0.0, np.subtract(further, left))
    line = np.minimum(left, apart * (1.0 - share) / (times - 1.0))
    parabola = np.minimum(left, apart * (1.0 - math.sqrt(share)) / (math.sqrt(times) - 1.0))
    return _CONCAVE * line, parabola
