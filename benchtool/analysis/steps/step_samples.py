"""Numbers of the samples once a signal has arrived: on the plateau, and of the error after settling."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.steps.arrived_samples import ArrivedSamples
from benchtool.analysis.steps.noisy_curve import CALM, NoisyCurve
from benchtool.analysis.steps.passages import Instant
from benchtool.analysis.steps.slopes import Slope
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.step_shape import TAIL, Step
from benchtool.analysis.steps.step_validity import UNDECIDED
from benchtool.analysis.steps.treads import HELD
from benchtool.analysis.uncertainty import Contribution, combined

Floats = NDArray[np.float64]


def plateau_numbers(
    step: Step, curve: NoisyCurve, arrived: Instant | None, band: float, drift: Slope | None
) -> Iterator[Measurement]:
    """Yield the numbers of the plateau: signal and reference both at their greatest, with a `drift` or
    without."""
    begin, end = step.holds, step.leaves
    since = Instant(float(begin), 0.0)
    if arrived is None or math.ceil(max(arrived.place, since.place)) >= end:
        since, end = Instant(0.0, 0.0), 0
    elif arrived.place > begin:
        since = arrived
    reason = ""
    if not end:
        is_held = step.leaves >= len(step.r)
        ends = "record ends" if is_held else "reference leaves its greatest value"
        reason = f"the {ends} before the signal reaches what the reference asks for"
    elif not math.isfinite(since.standard):
        reason = UNDECIDED
    values = step.sign * step.y[:end]
    course, noise = curve.against(step.sign), step.plateau_noise
    found = None if reason else _arrived(step, values, course, since, band, drift, noise)
    samples = len(values) - math.ceil(since.place)
    for name, which, of, uncertain in (
        ("plateau_mean", "mean", np.mean, ArrivedSamples.of_mean),
        ("plateau_min", "least", np.min, ArrivedSamples.of_least),
        ("plateau_max", "greatest", np.max, ArrivedSamples.of_greatest),
    ):
        text = (
            f"{which} sample from reaching 98% of the step until the reference leaves the {HELD:.0%} "
            f"below its greatest value, {samples} samples"
        )
        if found is None:
            yield Measurement.undefined(name, step.unit, text, reason, step.basis)
        else:
            value = float(of(found.values))
            yield step.number(name, text, value, uncertain(found))


def tracking_numbers(
    step: Step, curve: NoisyCurve, settled: Instant | None, band: float, drift: Slope | None
) -> Iterator[Measurement]:
    """Yield the numbers of the error after settling, with a `drift` or without."""
    undefined = partial(Measurement.undefined, unit=step.unit, basis=step.basis)
    if settled is not None:  # between two lobes it has settled behind neither
        settled = settled.at_likeliest
    left = 0 if settled is None else len(step.y) - math.ceil(settled.place)
    if settled is None or left < 2 or not math.isfinite(settled.standard):
        reason = "it does not settle" if left < 2 else UNDECIDED
        for name in ("mean", "rms", "max"):
            text = "signal minus reference after settling"
            yield undefined(f"tracking_error_{name}", definition=text, reason=reason)
        return
    error = step.sign * (step.y - step.r)
    course = curve.against(step.sign, step.r)
    # of a pulse no time since its rise counts
    found = _arrived(
        step, error, course, _once_inside(step, curve, settled, band), band, drift, step.y_noise, step.fall
    )
    window = f"signal minus reference, {left} samples after settling"
    mean = float(np.mean(found.values))
    text = f"mean of {window}"
    yield step.number("tracking_error_mean", text, mean, found.of_mean())
    yield _tracking_rms(step, found, window)
    greatest = float(np.max(np.abs(found.values)))
    text = f"greatest magnitude of {window}"
    yield step.number("tracking_error_max", text, greatest, found.of_magnitude())


def _once_inside(step: Step, curve: NoisyCurve, settled: Instant, band: float) -> Instant:
    """Return the instant at which a signal has `settled` within a `band`, of which noise makes none while it
    is surely outside, as before a pulse falls."""
    outside = np.flatnonzero(np.abs(curve.values - step.final) > band + CALM * curve.standard)
    if not len(outside) or not settled.drawn:
        return settled
    earlier = max(0.0, settled.place - float(outside[-1]))
    drawn = np.maximum(settled.drawn, settled.of_drawn - earlier)
    return replace(settled, drawn=tuple(drawn.tolist()))


def _tracking_rms(step: Step, found: ArrivedSamples, window: str) -> Measurement:
    """Return the rms of the error, without the power that noise leaves in a reference."""
    added = ", without what the steps of a converter add to its scatter" if found.added else ""
    name, text = "tracking_error_rms", f"rms, with the mean, of {window}{added}"
    square, uncertain = found.rms**2, found.of_rms()
    if not len(step.r_errors) or uncertain is None or not square > 0.0:
        return step.number(name, text, found.rms, uncertain)
    powers = np.mean(step.r_errors[:, -len(found.values) :] ** 2, axis=1)
    power, spread = float(np.mean(powers)), float(np.std(powers))
    text = f"{text}, without {math.sqrt(power):.2g} {step.unit} rms of noise left in the reference"
    # of a square, and with it of its root, less than a standard uncertainty is left
    least = math.hypot(spread, 2.0 * found.rms * uncertain.standard)
    if square - power < least:
        reason = "it is not told from the noise of the reference: record a reference that has less"
        return Measurement.undefined(name, step.unit, text, reason, step.basis)
    rms = math.sqrt(square - power)
    lines = (
        Contribution("that of the rms with this noise", "A", uncertain.standard * found.rms / rms),
        Contribution("power of noise left in the reference", "A", spread / (2.0 * rms)),
    )
    return step.number(name, text, rms, combined(lines, uncertain.source))


def _arrived(
    step: Step,
    values: Floats,
    course: NoisyCurve,
    since: Instant,
    band: float,
    drift: Slope | None,
    noise: Noise,
    event: int = 0,
) -> ArrivedSamples:
    if step.shown_late:  # the sample before the instant is shown for any part of the time after it
        late = 0.5 * step.shown_late
        drawn = tuple(each - late for each in since.drawn)
        since = replace(since, place=since.place - late, drawn=drawn).widened(late)
    if step.time_scatter > course.time_scatter:
        since = since.widened(math.sqrt(step.time_scatter**2 - course.time_scatter**2))
        course = replace(course, time_scatter=step.time_scatter)
    seen = None if drift is None else drift.seen_from(step.sign)
    last = round(TAIL * len(step.y))
    beside = (step.y_before, *([step.y_clear[-last:]] if len(values) <= len(step.y) - last else []))
    found = ArrivedSamples.of(values, course, since, band, noise, step.converter_step, event, seen, beside)
    known = replace(step.known_clicks, heights=step.sign * step.known_clicks.heights)
    return replace(found, clicks=known) if known.are_few else found
