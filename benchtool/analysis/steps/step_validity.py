"""Why an answer to a step is not known: what was recorded of it does not show it."""

from __future__ import annotations

import numpy as np

from benchtool.analysis.statistics.outlying_samples import too_many
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.step_shape import Step
from benchtool.analysis.validity import clipped_share

UNDECIDED = "because of noise this is undecided"
_MOST_OFFSET = 0.5  # of the step: how far a signal may be from its reference before it
_SURE = 3.0  # standard uncertainties of that
_FEWEST_ALIKE = 3  # samples of one value, which noise would not leave


def why_unknown(step: Step, band: float) -> str:
    """Return why no number of an answer is known, within a `band` about its levels; empty where it is."""
    reasons = (
        _reference_of_another(step),
        _noise_unknown(step),
        _clicks_too_many(step),
        _overshoot_clipped(step, band),
    )
    return next(filter(None, reasons), "")


def _reference_of_another(step: Step) -> str:
    """Return why a signal that is far from its reference before the step does not follow it, empty where it
    may: within half of the step it has an offset, beyond it would be counted as on its way or as arrived."""
    rest = step.y_before[: max(1, step.begin)]
    at_rest = float(np.mean(rest))
    apart, unsure = abs(at_rest - step.before), _SURE * step.y_noise.of_mean(len(rest))
    if apart <= _MOST_OFFSET * step.height + unsure:
        return ""
    signal, reference = (f"{step.sign * each + 0.0:.4g} {step.unit}" for each in (at_rest, step.before))
    return (
        f"before the step of {step.height:.4g} {step.unit} the signal is at {signal} and the reference at "
        f"{reference}, more than half of the step apart: name the reference that the signal follows, not "
        f"what is added to it, or start the signal where the reference starts"
    )


def _noise_unknown(step: Step) -> str:
    """Return why the noise of a signal is not known, empty where it is: it is read from samples at rest."""
    before = len(step.y_before)
    is_calm = before >= _FEWEST_ALIKE and np.ptp(step.y_before) == 0.0
    if is_calm or max(before, step.tail) >= Noise.FEWEST:
        return ""
    return (
        f"its noise is not known from {before} rows before the step and the last {step.tail} after it: "
        f"record {Noise.FEWEST} rows or more at rest"
    )


def _clicks_too_many(step: Step) -> str:
    """Return why the answer is not told from interference, empty where it is."""
    samples = step.begin + len(step.y)
    if not too_many(step.clicks, samples):
        return ""
    return (
        f"{step.clicks} of {samples} samples are far from their neighbours, too many to be left out: "
        f"check the wiring of the channel, or filter it"
    )


def _overshoot_clipped(step: Step, band: float) -> str:
    """Return why an answer that stays at a greatest value beyond a `band` about its levels is not known."""
    greatest = float(np.max(step.y))
    at_rest = float(np.max(step.y[-step.tail :]))
    if greatest <= max(step.greatest, at_rest) + band or not (share := clipped_share(step.y)):
        return ""
    return (
        f"{100.0 * share:.2g} % of the samples after the step are at {step.sign * greatest:.4g}, beyond it: "
        f"the overshoot is clipped, choose a wider range"
    )
