"""Response of a signal to a step of its reference, or to a pulse as a torque limit makes of a speed step.

Times and excursions are those of the smooth curve through the samples (`noisy_curve`), so that noise is not
taken for a movement; least and greatest values of a plateau, and tracking errors, are those of the samples,
because the ripple belongs to them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.declaration import Analysis, Findings, Measured, Quantity, UnitOf
from benchtool.analysis.distributions import above_zero
from benchtool.analysis.drawings import TORQUE
from benchtool.analysis.measurement import Measurement, MeasurementJson, measurements_to_json
from benchtool.analysis.numbers import count_of
from benchtool.analysis.statistics.scatter import means_of_parts
from benchtool.analysis.steps.corners import corner_near
from benchtool.analysis.steps.departure import SIGMAS, departure
from benchtool.analysis.steps.noisy_curve import CALM, NoisyCurve
from benchtool.analysis.steps.passages import Instant
from benchtool.analysis.steps.ringing import Ringing, ringing_about
from benchtool.analysis.steps.slopes import Slope, without_drift
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.step_drift import find_drift, wanders
from benchtool.analysis.steps.step_samples import plateau_numbers, tracking_numbers
from benchtool.analysis.steps.step_shape import TAIL, Step, find_step
from benchtool.analysis.steps.step_validity import UNDECIDED, why_unknown
from benchtool.analysis.steps.tails import LITTLE, Tail
from benchtool.analysis.steps.treads import HELD
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined_by_names
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.document import Section

Floats = NDArray[np.float64]

_LOW, _HIGH = 0.1, 0.9
_ARRIVED = HELD  # of the step: tolerance of reaching it, and the least settling band
_AT_REST = 2.0  # times the settling time, at least
_LONGER = 2.0  # times the samples whose mean is the final value
_EXTREME = 4.0  # standard uncertainties of an overshoot that has a peak time
_SHOWN = 2.0  # likewise, of a peak that noise hardly makes
_BLUNTED, _OF_BLUNTED = 0.5, 0.8  # of what a longer window does to a peak; rms of the rest, -1/4 to 3/2
_OF_SAMPLES = "plateau_", "tracking_error_"  # what the samples are, whatever moves them
_FEWEST_SAMPLES = 20  # whose scatter says something
_ROUNDING = 1e-7  # of the step: a smaller overshoot is rounding


@dataclass(frozen=True)
class StepResponse:
    """Result of `analyze_step`; times are since the step of the reference, values in the signal's unit."""

    measurements: tuple[Measurement, ...]
    step_row: int

    def to_json(self) -> dict[str, MeasurementJson]:
        return measurements_to_json(self.measurements)


def analyze_step(block: Block, signal: str, reference: str, *, held: bool = False) -> StepResponse:
    """Return latency, rise, overshoot, settling and remaining error after a step of `reference`.

    Where the step is, what a `held` reference is and which are none says `find_step`. Overshoot and plateau
    are measured against the greatest value of the reference, undershoot and settling against its final one,
    the mean of its last tenth.

    A signal counts as settled within 2 % of the step or, where the noise leaves the smooth curve more than a
    fifth of that uncertain, within five of its standard uncertainties. Where it drifts before the step
    (`find_drift`), times and excursions are undefined, and where it wanders at rest (`wanders`) all numbers.

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, units that differ, no step or several.
    """
    step = find_step(block, signal, reference, held=held)
    curve, at_rest = _curve(step)
    band = _band(step, curve)
    drift = find_drift(step, at_rest)
    drifting = curve.drifting(drift.doubt, len(step.y_before))
    found = tuple(_measurements(step, drifting, band, drift.slope))
    if step.repeats:
        repeats = count_of(step.repeats, "sample that repeats", "samples that repeat")
        found = tuple(_without(found, f"{repeats} the one before"))
    if step.clicks:
        clicks = count_of(step.clicks, "sample that is", "samples that are")
        found = tuple(_without(found, f"{clicks} far from the neighbours"))
    if drift.reason:
        found = tuple(_without_drift(found, drift.reason))
    wandering = wanders(step, at_rest, drifts=bool(drift.reason) or drift.doubt > 0.0)
    if reason := why_unknown(step, band) or wandering:
        found = tuple(_undefined(each, reason) for each in found)
    return StepResponse(found, step.row)


def _rest(step: Step, settled: Instant, tail: Tail) -> int:
    """Return the row from which on a signal that has `settled` is at rest.

    After m times as long since the step, or since a pulse fell, an exponential decay has left the m-th power
    of the 2 % that it had: so many that this is little against the noise, which it would be taken for. Of
    several the slowest is left, its `tail`.
    """
    times = _AT_REST
    if (noise := LITTLE * step.y_noise.rms) > 0.0:
        times = max(times, math.log(noise / step.height) / math.log(_ARRIVED))
    begin = math.ceil(step.fall + times * max(0.0, settled.place - step.fall))
    later = tail.end(step.y_noise.rms)
    return later if begin < later <= (1.0 - _LONGER * TAIL) * len(step.y) else begin


def _without(found: Iterable[Measurement], left_out: str) -> Iterator[Measurement]:
    """Yield the numbers; what is of the smooth curve says which samples are not in it, and what is of the
    samples which may be in it."""
    for each in found:
        is_of_samples = each.name.startswith(_OF_SAMPLES)
        told = f"the record has {left_out}" if is_of_samples else f"without {left_out}"
        yield replace(each, definition=f"{each.definition}; {told}")


def _without_drift(found: Iterable[Measurement], reason: str) -> Iterator[Measurement]:
    """Yield the numbers; those that a drift would be taken for the answer in are undefined."""
    for each in found:
        if each.name.startswith(_OF_SAMPLES):
            yield each
        else:
            yield _undefined(each, reason)


def _undefined(each: Measurement, reason: str) -> Measurement:
    return Measurement.undefined(each.name, each.unit, each.definition, reason, each.basis)


def _measurements(step: Step, curve: NoisyCurve, band: float, drift: Slope | None) -> Iterator[Measurement]:
    arrival = curve.passage(step.greatest - _ARRIVED * step.height, step.greatest_error)
    arrived = None if arrival is None else arrival.instant
    ringing = _ringing(step, curve)
    settled = curve.last_outside(step.final, band, step.fall)
    if ringing is not None and settled is not None and not step.fall:
        settled = ringing.last_outside(step.final, band) or settled
    yield from _times(step, curve, arrived, ringing)
    settling = _time(step, "settling_time", _settling_text(step, band), settled, "it does not settle")
    yield _resting_on(settling, band=band)
    yield from _excursions(step, curve, arrived, ringing)
    for each in plateau_numbers(step, curve, arrived, band, drift):
        yield _resting_on(each, span_s=(step.leaves - step.zero) * step.period_s)
    for each in tracking_numbers(step, curve, settled, band, drift):
        yield _resting_on(each, band=band, span_s=(len(step.y) - step.zero) * step.period_s)


def _resting_on(each: Measurement, *, band: float | None = None, span_s: float | None = None) -> Measurement:
    """Return a number that hangs on when the signal settles within a band, or on how long it counts after the
    step."""
    return replace(each, basis=replace(each.basis, band=band, span_s=span_s))


def _curve(step: Step) -> tuple[NoisyCurve, Floats]:
    """Return the smooth curve, with the noise of all samples at rest where these are many more than the last;
    and the samples long after the signal has settled, of what a drift keeps from it the later half."""
    before = len(step.y_before)
    through = partial(
        NoisyCurve.through,
        step.y_clear,
        before=before,
        of_plateau=step.of_plateau,
        step=step.level_step,
        doubt=step.y_doubt,
    )
    curve = through(noise=step.y_noise)
    band = _band(step, curve)
    settled = curve.last_outside(step.final, band, step.fall)
    if settled is None or not math.isfinite(settled.standard):
        return curve, step.y_clear[len(step.y) // 2 :]
    tail = Tail.of(curve.values - float(np.mean(step.y_clear[-step.tail :])), band)
    rest = _rest(step, settled, tail)
    at_rest = step.y_clear[rest:]
    course = tail.goes_on_in(at_rest, rest)
    if course is not None:
        at_rest = at_rest - course + course[-1]
    if step.y_noise.rms == 0.0 or len(at_rest) < _LONGER * TAIL * len(step.y):
        return curve, at_rest
    y_before, y_settled = without_drift(step.y_before, at_rest)
    noise = step.noise_of(y_before, y_settled)
    offset = max(noise.offset, Noise.of(y_settled).offset)  # of the longer piece, be it the calmer
    if offset and len(at_rest) >= _FEWEST_SAMPLES:
        # slow noise is as far off after the step as it was before, and wanders as it does at rest
        away = float(np.mean(y_before)) - step.before
        wander = float(np.std(means_of_parts(y_settled)))
        noise = replace(noise, offset=max(offset, math.hypot(away, wander)))
    return through(noise=noise), at_rest


def _band(step: Step, curve: NoisyCurve) -> float:
    """Return half the width within which the curve counts as settled."""
    tail = max(1, round(TAIL * len(curve.values)))
    return max(_ARRIVED * step.height, CALM * float(np.median(curve.standard[-tail:])))


def _settling_text(step: Step, band: float) -> str:
    least = f"{_ARRIVED:.0%} of the step"
    why = least if band <= _ARRIVED * step.height else f"{CALM:g} x its uncertainty, as {least} is less"
    text = (
        f"from the step until the smoothed signal stays within {band:.4g} {step.unit} of the final "
        f"reference, the mean of its last tenth: {why}"
    )
    if step.leaves == len(step.r):
        return text
    held_s = (step.leaves - step.zero) * step.period_s
    return (
        f"{text}; the reference leaves its greatest value {held_s:.4g} s after the step, which this includes"
    )


def _times(
    step: Step, curve: NoisyCurve, arrived: Instant | None, ringing: Ringing | None
) -> Iterator[Measurement]:
    text = (
        f"from the step until the smoothed signal is {_ARRIVED:.0%} of the step beyond the mean before it; "
        f"where {SIGMAS:g} x its uncertainty is more, from there back along a lag of the order that it shows"
    )
    left = departure(step, curve)
    ahead = left is not None and max(0.0, left.place) < step.zero - left.standard
    reason = "it moves before the reference has come half the way" if ahead else "it does not move"
    yield _time(step, "step_latency", text, None if ahead else left, reason)

    low, high = (step.before + share * step.height for share in (_LOW, _HIGH))
    rise = None if ringing is None else ringing.rise(step.before, low, high)
    rise = rise or curve.rise(low, high)
    text = f"from {_LOW:.0%} to {_HIGH:.0%} of the step, of the smoothed signal"
    yield _interval(step, "rise_time", text, rise, "it is not reached")
    text = f"from the step until the smoothed signal has come {1 - _ARRIVED:.0%} of it"
    yield _time(step, "reach_time", text, arrived, "it is not reached")


def _time(step: Step, name: str, definition: str, found: Instant | None, reason: str) -> Measurement:
    """Return a time from the step to an instant, which is not negative: the median of the part of its
    distribution that is possible, with its rms deviation from that."""
    if found is None or not math.isfinite(found.standard):
        return _interval(step, name, definition, found, reason)
    since = found.place - step.zero + step.earlier
    place, standard = above_zero(since, math.hypot(found.standard, step.earlier))
    of_step = Contribution("when since the row before its own the step was made", "B", step.earlier)
    return _interval(step, name, definition, replace(found, place=place), reason, (of_step,), standard)


def _interval(
    step: Step,
    name: str,
    definition: str,
    found: Instant | None,
    reason: str,
    further: tuple[Contribution, ...] = (),
    standard: float | None = None,
) -> Measurement:
    """Return a time between two instants, with `further` contributions to its uncertainty, in rows, of which
    the part that is possible is of this `standard` uncertainty."""
    if found is not None and not math.isfinite(found.standard):
        found, reason = None, UNDECIDED
    if found is None:
        return Measurement.undefined(name, "s", definition, reason, step.basis)
    of_noise = Contribution("noise of the smoothed signal over its slope", "A", found.of_noise)
    of_rows = Contribution("its place between two samples and what windows do to it", "B", found.of_rows)
    uncertainty = _possible((of_noise, of_rows, *further), standard).scaled(step.period_s)
    return Measurement(name, found.place * step.period_s, "s", definition, step.basis, uncertainty)


def _possible(lines: Iterable[Contribution], standard: float | None) -> Uncertainty:
    """Return the uncertainty by these contributions, in proportion as small as what is possible leaves it."""
    budget = [each for each in lines if each.standard > 0.0]
    whole = math.hypot(*(each.standard for each in budget))
    share = standard / whole if standard is not None and whole > 0.0 else 1.0
    found = combined_by_names(each.scaled(share) for each in budget)
    assert found is not None, "of lines that are greater than zero"
    return found


def _excursions(
    step: Step, curve: NoisyCurve, arrived: Instant | None, ringing: Ringing | None
) -> Iterator[Measurement]:
    greatest, of_curve = curve.greatest(kinked=True)
    peak, of_windows = None, 0.0
    if greatest - step.greatest > _EXTREME * math.hypot(of_curve, step.greatest_error):
        lower, later = curve.blunted()
        greatest, of_windows = greatest + _BLUNTED * lower, _OF_BLUNTED * abs(lower)
        peak = curve.place_of_greatest()
        of_rows, wider = (math.hypot(each, _OF_BLUNTED * later) for each in (peak.of_rows, peak.standard))
        peak = Instant(peak.place - _BLUNTED * later, wider, of_rows=of_rows)
        top = int(np.argmax(curve.values))
        corner = corner_near(step.y_clear, step.plateau_noise, top, step.level_step)
        if corner is not None:
            height = corner.height, corner.height_error
            of_both = math.hypot(of_curve, of_windows)
            greatest, of_curve = corner.averaged((greatest, of_both), height)
            of_windows = min(of_windows, of_curve)
            of_curve = math.sqrt(of_curve**2 - of_windows**2)
            # whichever this one is, noise may have made another the greatest
            place = corner.place, math.hypot(corner.place_error, curve.greatest_elsewhere(corner.reach))
            at, wider = corner.averaged((peak.place, peak.standard), place)
            peak = Instant(at, wider, of_rows=min(peak.of_rows, wider))
        if ringing is not None:
            crest = ringing.crest
            greatest, of_curve, of_windows = crest.height, crest.height_error, 0.0
            peak = Instant(crest.place, crest.place_error)
    text = "greatest value of the smoothed signal beyond the greatest reference"
    errors = _errors(of_curve, of_windows, step.greatest_error)
    beyond, uncertain = _at_least_zero(step, greatest - step.greatest, errors)
    yield step.number("overshoot", text, beyond, uncertain)
    percent = 100.0 / step.height
    text = "100 x overshoot / height of the step of the reference"
    relative = uncertain.scaled(percent)
    yield Measurement("overshoot_percent", percent * beyond, "%", text, step.basis, relative)

    text = "from the step to the greatest value of the smoothed signal"
    peak = peak if beyond > 0.0 else None
    yield _time(step, "peak_time", text, peak, "it does not exceed the greatest reference beyond its noise")

    name = "undershoot"
    text = "greatest value of the smoothed signal short of the final reference after its own greatest value"
    if arrived is None:
        yield Measurement.undefined(name, step.unit, text, "98% of the step is not reached", step.basis)
        return
    lowest, of_curve = curve.least_after_greatest()
    of_windows = 0.0
    if ringing is not None:
        lowest, of_curve = ringing.trough.height, ringing.trough.height_error
    elif step.final - lowest > _SHOWN * math.hypot(of_curve, step.final_error):
        raised, _ = curve.since(int(np.argmax(curve.values))).against(-1.0).blunted()
        lowest, of_windows = lowest - _BLUNTED * raised, _OF_BLUNTED * abs(raised)
    errors = _errors(of_curve, of_windows, step.final_error)
    yield step.number(name, text, *_at_least_zero(step, step.final - lowest, errors))


def _ringing(step: Step, curve: NoisyCurve) -> Ringing | None:
    """Return the mode of an answer that rings in few rows a period, as samples at other times do not."""
    noise = math.hypot(step.plateau_noise.rms, step.converter_step / math.sqrt(12.0))
    return ringing_about(step.y_clear, int(np.argmax(curve.values)), noise)


def _errors(of_curve: float, of_windows: float, of_reference: float) -> tuple[Contribution, ...]:
    """Return the contributions to the uncertainty of an excursion beyond the reference."""
    of_noise = "noise of the smoothed signal and its course between samples"
    return (
        Contribution(of_noise, "A", of_curve),
        Contribution("what windows do to it", "B", of_windows),
        Contribution("noise of the reference", "A", of_reference),
    )


def _at_least_zero(step: Step, found: float, errors: tuple[Contribution, ...]) -> tuple[float, Uncertainty]:
    """Return the best estimate of what cannot be negative, and its uncertainty."""
    value, standard = above_zero(found, math.hypot(*(each.standard for each in errors)))
    return value if value > _ROUNDING * step.height else 0.0, _possible(errors, standard)


class StepSettings(Section):
    """The channel that follows and the one that steps; of one unit."""

    signal: str = "torque"
    """Channel that follows."""
    reference: str = "torque_reference"
    """Channel that steps. `stimulus`, which is added to the setpoint of a plan, counts from there."""


def _measure(window: Window, settings: StepSettings) -> Findings:
    block = window.block_of_reference(settings.reference)
    found = analyze_step(block, settings.signal, settings.reference, held=window.at_drive_ticks)
    return Findings(found.measurements, result=found)


_OF_SIGNAL: Final = UnitOf("signal")

STEP: Final = Analysis(
    name="step",
    title="step response",
    measure=_measure,
    quantities=(
        Quantity(
            ("step_latency",),
            "s",
            "until the curve is 2 % of `height` beyond the signal's mean before the step; where three of its "
            "standard uncertainties are more, from 1.5 times that level back along a lag after a dead time, "
            "of the order (1 to 4) that the way on to half of `height` shows. "
            "Undefined where the signal has moved before time zero, along a slow reference",
        ),
        Quantity(
            ("rise_time",),
            "s",
            "from 10 % to 90 % of `height`",
        ),
        Quantity(("reach_time",), "s", "to 98 % of `height`", label="reached in"),
        Quantity(
            ("settling_time",),
            "s",
            "until the curve stays within `max(2 % of height, 5 x its standard uncertainty)` of `final`; the "
            "definition states the width. Where noise leaves open which lobe is the last outside, it is the "
            "instant that is expected. Of a pulse that is after its fall, and the time that the reference "
            "was held is included",
        ),
        Quantity(
            ("overshoot",),
            _OF_SIGNAL,
            "greatest value of the curve minus `greatest`, less what noise adds to it on average; as it is "
            "at least 0, the median of the part of its distribution that is above",
            label="overshoot",
        ),
        Quantity(("overshoot_percent",), "%", "`100 x overshoot / height`"),
        Quantity(
            ("peak_time",),
            "s",
            "to the greatest value of the curve; undefined where that is not beyond `greatest` by four "
            "standard uncertainties",
        ),
        Quantity(
            ("undershoot",),
            _OF_SIGNAL,
            "`final` minus the least value of the curve after its greatest, likewise",
        ),
        Quantity(
            ("plateau_mean", "plateau_min", "plateau_max"),
            _OF_SIGNAL,
            "mean, least and greatest sample from `reach_time` until the reference falls below `greatest - "
            "2 % of height`",
        ),
        Quantity(
            ("tracking_error_mean", "tracking_error_rms", "tracking_error_max"),
            _OF_SIGNAL,
            "of signal minus reference, sample by sample, from `settling_time` to the end, or from behind "
            "the likeliest of several lobes that may be the last outside; `_max` is the greatest magnitude",
        ),
    ),
    settings=StepSettings,
    measured=Measured.ON_REQUEST,
    channel_settings=("signal", "reference"),
    one_unit=("signal", "reference"),
    figures=(TORQUE,),
    comparisons=(TORQUE,),
)
