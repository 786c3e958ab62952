"""Drift of a signal before a step, on which its answer would be superimposed."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.statistics.lowest_frequencies import slow_noise, walk_probability
from benchtool.analysis.statistics.straight_lines import places_about_middle, slope_weights
from benchtool.analysis.steps.noisy_curve import at_rest_error
from benchtool.analysis.steps.slopes import Slope
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.step_shape import Step

Floats = NDArray[np.float64]

_DOUBTFUL = 2.5  # standard uncertainties of a slope that may be there
_WANDERS, _LATE, _FEW = 0.4, 0.25, 0.6  # probability of a walk; of a signal at rest late, and for few rows
_SHOWS = 0.7  # octaves by which noise rises below the lowest frequency of a piece; white noise hardly does
_GROWS = 0.75  # of what it moves by in a half or a quarter of the time; a walk mostly 1.4 and 2 times
_LONG = 6  # parts of a record that Allan's variance is of
_FEWEST, _FEWEST_AT_REST = 20, 64  # samples whose lowest frequencies tell a walk: of few rows, and else
_OF_ALLAN = 1.5  # of the variance of a difference of means side by side: that of a walk over their length
_TOLERATED = 0.02  # of the step, over the time after it: the least settling band
_LITTLE = 1.5e-3  # of the step: a wander that is slow noise, and hides no answer
_LITTLE_ABOUT, _RETURNS = 2.5e-3, 0.1  # likewise, about a level that moves by so much of what a walk does


@dataclass(frozen=True)
class Drift:
    """Drift of a signal: `reason` why the answer is not told from it, empty where it is; its `slope` where
    noise alone hardly has that; `doubt` is the standard uncertainty, per sample, of a drift that is too small
    to hide the answer, or cannot be excluded."""

    reason: str = ""
    slope: Slope | None = None
    doubt: float = 0.0


def wanders(step: Step, at_rest: Floats, *, drifts: bool) -> str:
    """Return why the level of a signal is not known, empty where it is: it wanders, as a random walk does.

    What it moved by between the samples before the step and those `at_rest` after it is then not known. Each
    of both shows few of the lowest frequencies; that the density of their noise rises towards zero frequency
    more steeply than that of 1/f noise is told by both together. So seems that of a line of which they hold
    no whole periods, but within a longer time it moves by less. It is what the signal does about its
    reference, which may move too, as that of an inner loop. Where it `drifts`, that is about one slope of
    both, as a drift goes on.

    A walk may keep a signal from its level for so long that few samples are at rest: the later half of the
    record stands for them then. Where those before the step are few as well, slow noise of any kind moves
    more than both show, and a line or hum of which they hold no whole period is slow noise too.

    A control takes a signal back to its level: where that is after the step as it was before, within a tenth
    of what a walk as large would have moved it by, a larger wander is slow noise, too.
    """
    is_late = len(at_rest) < _FEWEST_AT_REST
    has_few = is_late and len(step.y_before) < _FEWEST_AT_REST
    least = _FEWEST if has_few else _FEWEST_AT_REST
    if is_late and not has_few:
        at_rest = step.y_clear[len(step.y) // 2 :]
    about = (step.y_before - step.r_before, at_rest - step.r[len(step.r) - len(at_rest) :])
    pieces = [each for each in about if len(each) >= least]
    if drifts and not has_few:
        pieces = _about_one_slope(pieces)
    if not pieces:
        return ""
    longest = max(pieces, key=len)
    size = len(longest) // _LONG
    wander, *shorter = (math.sqrt(_allan_variance(longest, max(1, size // each))) for each in (1, 2, 4))
    little = _LITTLE
    if len(pieces) == len(about) and not has_few and _returns(about, len(step.y), wander**2 / size):
        little = _LITTLE_ABOUT
    if wander < max(little * step.height, 0.0 if has_few else _GROWS * max(shorter)):
        return ""
    # what only follows the step is how the answer creeps to its level
    noise = slow_noise(pieces[0]) if len(step.y_before) >= least else None
    if noise is None or noise.rise < _SHOWS:
        return ""
    probability = walk_probability(pieces)
    if probability is None or probability < (_FEW if has_few else _LATE if is_late else _WANDERS):
        return ""
    return (
        f"the signal wanders at rest, by {wander:.2g} {step.unit} rms within {size * step.period_s:.4g} s, "
        f"and more the longer it is watched: find what moves it, step further, or record less before and "
        f"after the step"
    )


def _returns(about: tuple[Floats, Floats], rows: int, square: float) -> bool:
    """Return whether a signal is as far from its reference at the end of so many rows after a step as before
    that, both of shape (n,), by what a walk moves it by whose Allan variance is so many times its rows."""
    before, after = about
    apart = rows + 0.5 * (len(before) - len(after)) - (len(before) + len(after)) / 6.0
    moved = abs(float(np.mean(after)) - float(np.mean(before)))
    return moved < _RETURNS * math.sqrt(_OF_ALLAN * square * apart)


def _about_one_slope(pieces: list[Floats]) -> list[Floats]:
    """Return pieces, each of shape (n,), about lines of one slope, that of least squares."""
    places = [places_about_middle(len(each)) for each in pieces]
    square = sum(float(each @ each) for each in places)
    slope = sum(float(place @ each) for place, each in zip(places, pieces, strict=True)) / max(square, 1.0)
    return [each - slope * place for place, each in zip(places, pieces, strict=True)]


def _allan_variance(samples: Floats, size: int) -> float:
    """Return the mean square of the difference of means of so many samples side by side (twice what Allan
    defines, Proc. IEEE 54 (1966) 221)."""
    total = np.concatenate([[0.0], np.cumsum(samples - np.mean(samples))])
    means = (total[size:] - total[:-size]) / size
    return float(np.mean((means[size:] - means[:-size]) ** 2))


def find_drift(step: Step, at_rest: Floats) -> Drift:
    """Return the drift of a signal by its samples before the step and, where it has settled, `at_rest`.

    A slope before the step is significant where it is beyond noise and, continued to the end of the record,
    moves the signal by more than the tolerance of settling. One that is less, or that noise or the steps of a
    converter hide there, is a doubt where the samples at rest have it too: a drift goes on.
    """
    before = Slope.of(step.y_before)
    if before is None:
        return Drift()
    slope = before.value
    moved = slope * len(step.y)
    # the level of a converter is anywhere within a step at both ends
    hidden = 2.0 * at_rest_error(step.y_before, step.level_step) / len(step.y_before)
    with_steps = Slope(slope, math.hypot(before.standard, hidden))
    if before.is_certain and abs(moved) > _TOLERATED * step.height:
        rate, after_s = step.sign * slope / step.period_s, len(step.y) * step.period_s
        reason = (
            f"the signal drifts by {rate:.4g} {step.unit}/s before the step, which is "
            f"{100.0 * abs(moved) / step.height:.2g} % of the step over the {after_s:.4g} s after it: "
            f"let it settle before the step, or record less after it"
        )
        return Drift(reason, with_steps)
    both = _of_both(_under_noise_of(at_rest, len(step.y_before), with_steps), Slope.of(at_rest))
    doubt = abs(both.value) if abs(both.value) > _DOUBTFUL * both.standard else 0.0
    return Drift(slope=with_steps if with_steps.is_certain else None, doubt=doubt)


def _under_noise_of(at_rest: Floats, count: int, before: Slope) -> Slope:
    """Return the slope of so many samples before a step, as uncertain as the noise of more samples at rest
    makes it where that is more: few samples of slow noise may show little of it by chance."""
    if not len(at_rest) > count:
        return before
    of_noise = Noise.of(at_rest).of_sum(slope_weights(count))
    return Slope(before.value, max(before.standard, of_noise))


def _of_both(before: Slope, after: Slope | None) -> Slope:
    """Return the slope that two pieces have in common, each by its weight; that before a step where there is
    no other, or where that is another for certain, as of an answer that creeps."""
    if after is None or not after.standard > 0.0:
        return before
    apart = math.hypot(before.standard, after.standard)
    if after.is_certain_at_rest and not after.is_like(before):
        return before
    share = (after.standard / apart) ** 2
    mean = share * before.value + (1.0 - share) * after.value
    return Slope(mean, before.standard * after.standard / apart)
