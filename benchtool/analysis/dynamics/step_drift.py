"""Drift of a signal before a step, on which its answer would be superimposed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.dynamics.noisy_curve import at_rest_error
from benchtool.analysis.dynamics.step_shape import Step
from benchtool.analysis.lowest_frequencies import slow_noise
from benchtool.analysis.scatter import error_of_series, means_of_parts

_SIGMAS = 3.5  # standard uncertainties of a slope that noise alone hardly ever has
_DOUBTFUL = 2.5  # likewise, of one that may be there
_AT_REST = 5.0  # likewise, of one after the signal has settled
_AGREES = 3.0  # standard uncertainties between both
_LOST = 4.2  # octaves by which noise rises below the lowest frequency of a piece, of two on average
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
    def of(cls, samples: NDArray[np.float64]) -> _Slope | None:
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


def wanders(step: Step, at_rest: NDArray[np.float64]) -> str:
    """Return why the level of a signal is not known, empty where it is: it wanders, as a random walk does.

    The density of its noise rises then so far below the lowest frequencies of the samples before the step,
    and of those `at_rest` after it, that what it moved by between both is anyone's guess.
    """
    before, after = slow_noise(step.y_before), slow_noise(at_rest)
    if before is None or after is None or before.rise + after.rise < 2.0 * _LOST:
        return ""
    moved = float(np.std(means_of_parts(at_rest)))
    return (
        f"the signal wanders at rest, by {moved:.2g} {step.unit} rms over the last "
        f"{len(at_rest) * step.period_s:.4g} s, and more the longer it is watched: find what moves it, or "
        f"measure its level closer to the step"
    )


def find_drift(step: Step, at_rest: NDArray[np.float64]) -> Drift:
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
