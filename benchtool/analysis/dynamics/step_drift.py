"""Drift of a signal before a step, on which its answer would be superimposed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.dynamics.noisy_curve import at_rest_error
from benchtool.analysis.dynamics.smoothing import without_a_line
from benchtool.analysis.dynamics.step_shape import Step
from benchtool.analysis.lowest_frequencies import slow_noise
from benchtool.analysis.scatter import error_of_series, means_of_parts

Floats = NDArray[np.float64]

_SIGMAS = 3.5  # standard uncertainties of a slope that noise alone hardly ever has
_DOUBTFUL = 2.5  # likewise, of one that may be there
_AT_REST = 5.0  # likewise, of one after the signal has settled
_AGREES = 3.0  # standard uncertainties between both
_LOST = 3.4  # octaves by which noise rises below the lowest frequency of a piece, of two on average
_OF_A_WALK = 4.8  # octaves: 1/f noise rises by 4.6 down to the lowest frequency of the models
_LONG, _SHORT, _GROWS = 6, 24, 1.8  # parts of a record that Allan's variances are of; over the other
_FEWEST_AT_REST = 64  # samples
_TOLERATED = 0.02  # of the step, over the time after it: the least settling band


@dataclass(frozen=True)
class Drift:
    """Drift of a signal: `reason` why the answer is not told from it, empty where it is; `doubt` is the
    standard uncertainty, per sample, of a drift that cannot be excluded."""

    reason: str
    doubt: float


@dataclass(frozen=True)
class _Slope:
    """Of a line through samples, per sample, and its standard uncertainty."""

    value: float
    standard: float

    @classmethod
    def of(cls, samples: Floats) -> _Slope | None:
        """Fit a line to means of parts, about which their scatter, and its correlation, give its uncertainty;
        None of too few samples."""
        means = means_of_parts(samples)
        if not len(means):
            return None
        parts = len(means)
        apart = len(samples) // parts  # samples from part to part
        place = apart * (np.arange(parts) - 0.5 * (parts - 1))
        square = float(place @ place)
        slope = float(place @ means) / square
        left = means - float(np.mean(means)) - slope * place
        standard = error_of_series(left).standard * math.sqrt(parts / square)  # of correlated parts too
        return cls(slope, standard)


def wanders(step: Step, at_rest: Floats, *, drifts: bool) -> str:
    """Return why the level of a signal is not known, empty where it is: it wanders, as a random walk does.

    The density of its noise rises then so far below the lowest frequencies of the samples before the step,
    and of those `at_rest` after it where there are some, that what it moved by between both is not known, and
    Allan's variance grows with the time that is averaged over; that of 1/f noise is constant, that of a line
    falls. Of few samples Allan's variance says little: a density that rises by more than that of 1/f noise
    does is that of a walk in any case. Where it `drifts`, that is about its drift.
    """
    pieces = [each for each in (step.y_before, at_rest) if len(each) >= _FEWEST_AT_REST]
    if drifts:
        pieces = [without_a_line(each) for each in pieces]
    noises = [found for each in pieces if (found := slow_noise(each)) is not None]
    if not pieces or len(noises) < len(pieces):
        return ""
    rise, longest = sum(each.rise for each in noises) / len(noises), max(pieces, key=len)
    size = len(longest) // _LONG
    longer = _allan_variance(longest, size)
    grows = longer >= _GROWS * _allan_variance(longest, len(longest) // _SHORT)
    if rise < _LOST or not (grows or rise > _OF_A_WALK):
        return ""
    return (
        f"the signal wanders at rest, by {math.sqrt(longer):.2g} {step.unit} rms within "
        f"{size * step.period_s:.4g} s, and more the longer it is watched: find what moves it, or record "
        f"less before and after the step"
    )


def _allan_variance(samples: Floats, size: int) -> float:
    """Return the mean square of the difference of means of so many samples side by side (twice what Allan
    defines, Proc. IEEE 54 (1966) 221)."""
    total = np.concatenate([[0.0], np.cumsum(samples - np.mean(samples))])
    means = (total[size:] - total[:-size]) / size
    return float(np.mean((means[size:] - means[:-size]) ** 2))


def find_drift(step: Step, at_rest: Floats) -> Drift:
    """Return the drift of a signal by its samples before the step and, where it has settled, `at_rest`.

    A slope before the step is significant where it is beyond noise and, continued to the end of the record,
    moves the signal by more than the tolerance of settling. One that is less, or that the signal has after it
    has settled and may have had before, where noise or the steps of a converter hide it, is a doubt.
    """
    before = _Slope.of(step.y_before)
    if before is None:
        return Drift("", 0.0)
    slope = before.value
    moved = slope * len(step.y)
    if not abs(slope) <= _SIGMAS * before.standard and abs(moved) > _TOLERATED * step.height:
        rate, after_s = step.sign * slope / step.period_s, len(step.y) * step.period_s
        reason = (
            f"the signal drifts by {rate:.4g} {step.unit}/s before the step, which is "
            f"{100.0 * abs(moved) / step.height:.2g} % of the step over the {after_s:.4g} s after it: "
            f"let it settle before the step, or record less after it"
        )
        return Drift(reason, 0.0)
    doubt = abs(slope) if abs(slope) > _DOUBTFUL * before.standard else 0.0
    after = _Slope.of(at_rest)
    if after is not None and abs(after.value) > _AT_REST * after.standard:
        # the level of a converter is anywhere within a step at both ends
        hidden = 2.0 * at_rest_error(step.y_before, step.y) / len(step.y_before)
        if abs(after.value - slope) <= _AGREES * math.hypot(before.standard, hidden, after.standard):
            doubt = max(doubt, abs(after.value))
    return Drift("", doubt)
