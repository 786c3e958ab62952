"""Drift of a signal before a step, on which its answer would be superimposed."""

from __future__ import annotations

import math

import numpy as np

from benchtool.analysis.dynamics.step_shape import Step
from benchtool.analysis.scatter import error_of_series, means_of_parts

_SIGMAS = 5.0  # standard uncertainties of a slope that noise alone hardly ever has
_TOLERATED = 0.02  # of the step, over the time after it: the least settling band


def drift_before(step: Step) -> str:
    """Return why the answer is not told from a drift; empty where none is significant.

    The slope of the signal before the step is fitted to means of parts, about which their scatter, and its
    correlation, give its standard uncertainty. It is significant where it is beyond noise and, continued to
    the end of the record, moves the signal by more than the tolerance of settling.
    """
    means = means_of_parts(step.y_before)
    if not len(means):
        return ""
    parts = len(means)
    apart = len(step.y_before) // parts  # samples from part to part
    place = apart * (np.arange(parts) - 0.5 * (parts - 1))
    square = float(place @ place)
    slope = float(place @ means) / square
    left = means - float(np.mean(means)) - slope * place
    standard = error_of_series(left).standard * math.sqrt(parts / square)  # of correlated parts too
    moved = slope * len(step.y)
    if abs(slope) <= _SIGMAS * standard or abs(moved) <= _TOLERATED * step.height:
        return ""
    rate, after_s = step.sign * slope / step.period_s, len(step.y) * step.period_s
    return (
        f"the signal drifts by {rate:.4g} {step.unit}/s before the step, which is "
        f"{100.0 * abs(moved) / step.height:.2g} % of the step over the {after_s:.4g} s after it: "
        f"let it settle before the step, or record less after it"
    )
