"""What the bandwidth and the resolution of a stated sensor do to a measurement, by the kind of number it is.

The kind is the content that its sensitivities state, the change that of the recorded waveform.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

from benchtool.analysis.measurement import Measurement
from benchtool.analysis.sensitivity import (
    Component,
    Extremes,
    Harmonics,
    Largest,
    Level,
    Line,
    Noise,
    Power,
    Sensitivity,
)
from benchtool.analysis.sensors.lag import Estimate, Lag, Response
from benchtool.analysis.sensors.waveform import (
    Waveform,
    by_steps,
    enlarged_harmonics,
    enlarged_largest,
    moved_small_line,
)
from benchtool.analysis.uncertainty import coverage_factor

_ROOT_3: Final = math.sqrt(3.0)
_FEW_STEPS = 2.5
_ROUNDING = 1e-9  # of a step


def top_Hz(each: Measurement) -> float:
    """Return the highest frequency that contributes; nan if it is unknown."""
    match each.sensitivities.content:
        case Line() | Component():
            return _or_nan(each.basis.frequency_Hz)
        case Harmonics(fundamental_Hz) if each.basis.harmonics is not None:
            return each.basis.harmonics * fundamental_Hz
        case _:
            return _or_nan(each.basis.bandwidth_Hz)


def before_the_sensors(
    each: Measurement, lags: Sequence[Lag | None], waveforms: Sequence[Waveform | None]
) -> Estimate | None:
    """Return a number as it was before the lags of its sensors; None where that cannot be told.

    Without even samples it is known of the highest frequency alone, which is the most that any loses.
    """
    content, highest_Hz = each.sensitivities.content, top_Hz(each)
    if isinstance(content, Component):
        return _component_before(each.value, content, highest_Hz, lags, waveforms)
    (waveform, lag), *_ = ((each, lag) for each, lag in zip(waveforms, lags, strict=True) if lag is not None)
    by_waveform = waveform is not None and not isinstance(content, Line)
    if not math.isfinite(highest_Hz) and not (by_waveform and isinstance(content, Power | Extremes)):
        return None
    if waveform is None and not isinstance(content, Line):
        lag = replace(lag, tolerance=None)

    def factor(response: Response) -> float:
        if waveform is None or not by_waveform:
            return response.enlarges(highest_Hz)
        match content:
            case Largest(fundamental_Hz):
                at_Hz = _or_nan(each.basis.frequency_Hz)
                return enlarged_largest(waveform, fundamental_Hz, at_Hz, highest_Hz, response)
            case Harmonics(fundamental_Hz, as_ratio):
                return enlarged_harmonics(waveform, fundamental_Hz, highest_Hz, response, as_ratio=as_ratio)
            case Power():
                read, before = (part.rms for part in waveform.before(response))
            case Extremes(beyond_percent):
                read, before = (part.range_within(beyond_percent) for part in waveform.before(response))
            case _:
                read, before = (part.peak_to_peak for part in waveform.before(response))
        return before / read if read > 0.0 else 1.0

    return lag.estimate(each.value, [each.value * factor(response) for response in lag.responses])


def _or_nan(frequency_Hz: float | None) -> float:
    return math.nan if frequency_Hz is None else frequency_Hz


def _component_before(
    value: float,
    of: Component,
    at_Hz: float,
    lags: Sequence[Lag | None],
    waveforms: Sequence[Waveform | None],
) -> Estimate | None:
    """Return a symmetrical component, or a ratio of two, as it was before the lags of its three phases.

    Equal lags turn all phases alike, which is no unbalance; others are taken off the phasors of the recorded
    phases. What is not known of each lag is taken as independent, as neither a guarantee nor a tolerance says
    that three sensors are alike: it turns the lag's phase, a third of which is in every component. None where
    it cannot be told.
    """
    alike = len(set(lags)) == 1
    recorded = [each for each in waveforms if each is not None]
    if not math.isfinite(at_Hz) or not (alike or len(recorded) == len(lags)):
        return None
    stated = [each for each in lags if each is not None]
    if any(each.tolerance is None for each in stated):
        lags = [each and replace(each, tolerance=None) for each in lags]
    slowest = min((each for each in lags if each is not None), key=lambda each: each.bandwidth_Hz)
    phasors = [each.line(at_Hz) for each in recorded]
    as_stated = 1.0
    if len(phasors) == len(lags) and not of.in_percent:
        as_stated = of.positive / _component(Component("positive", of.positive), phasors)

    def before(way: int) -> float:
        inverses = [1.0 if each is None else complex(each.responses[way].inverse(at_Hz)) for each in lags]
        if alike:
            return value * (1.0 if of.in_percent else abs(inverses[0]))
        read = _component(of, phasors)
        whole = _component(of, [p * each for p, each in zip(phasors, inverses, strict=True)])
        return abs(value + as_stated * (whole - read))

    estimate = slowest.estimate(value, [before(way) for way in range(len(slowest.responses))])
    turned = [0.0 if each is None else _turned(each, at_Hz) for each in lags]
    scale = 100.0 if of.in_percent else of.positive
    apart = 0.0 if of.which == "positive" else scale * math.hypot(*turned) / 3.0
    # of a magnitude that turns may have made all of it counts, of another what is in phase with it
    if len(phasors) == len(lags) and coverage_factor(math.inf) * apart < estimate.value:
        apart = as_stated * _by_turns(of, phasors, turned)
    if of.which == "positive":
        return Estimate(estimate.value, math.hypot(estimate.standard, apart))
    # of a ratio the positive sequence, its reference, is as much larger
    enlarges = (
        1.0
        if of.in_percent
        else slowest.estimate(1.0, [each.enlarges(at_Hz) for each in slowest.responses]).value
    )
    return Estimate(estimate.value, math.hypot(estimate.standard, apart), enlarges)


def _turned(lag: Lag, at_Hz: float) -> float:
    """Return the standard uncertainty of a phasor behind a lag, relative to its length: rectangular, of all
    that a guarantee allows or within the tolerance."""
    if lag.tolerance is None:
        return 0.5 * max(abs(complex(each.inverse(at_Hz)) - 1.0) for each in lag.responses) / _ROOT_3
    return lag.tolerance * at_Hz / lag.bandwidth_Hz / _ROOT_3


def _by_turns(of: Component, phasors: Sequence[complex], turned: Sequence[float]) -> float:
    """Return the standard uncertainty of a component of phasors, each of which may be turned by so much, rad,
    to either side."""
    own = _component(of, phasors)
    changes = [
        _component(of, [p * cmath.exp(1j * by) if k == phase else p for k, p in enumerate(phasors)]) - own
        for phase, most in enumerate(turned)
        for by in (-most, most)
    ]
    return math.sqrt(0.5 * sum(change**2 for change in changes))


def _component(of: Component, phasors: Sequence[complex]) -> float:
    """Return a symmetrical component of phasors, or what it is in percent of the positive one, whichever way
    they turn."""
    zero, one, other = (
        abs(sum(p * cmath.exp(2j * math.pi * k * turn / 3.0) for k, p in enumerate(phasors))) / 3.0
        for turn in range(3)
    )
    positive, negative = max(one, other), min(one, other)
    found = {"positive": positive, "negative": negative, "zero": zero}[of.which]
    return 100.0 * found / positive if of.in_percent else found


def moved_by_steps(
    part: Sensitivity, each: Measurement, resolution: float, waveform: Waveform | None
) -> float:
    """Return the standard uncertainty by the steps in which a sensor reads, in the number's unit.

    Where no waveform tells how far their errors average out, it is that of the declaration; so it is of
    extremes, each a single reading, and of what no offset moves, such as a slope. Of a waveform that spans
    few steps no other tells by how much: it may have been several times larger or smaller.
    """
    content = each.sensitivities.content
    if waveform is None or isinstance(content, Extremes):
        return part.resolution * resolution
    if isinstance(content, Level):
        if part.offset == 0.0:
            return part.resolution * resolution
        return abs(part.offset) * by_steps(waveform, resolution, lambda of: of.mean)
    feature = _feature(each)
    read = abs(feature(waveform))
    if not read > _ROUNDING * resolution:
        return part.resolution * resolution
    scale = part.gain if isinstance(content, Component) else each.value
    moved = by_steps(waveform, resolution, feature)
    if isinstance(content, Line | Component):
        moved = math.hypot(moved, moved_small_line(waveform, resolution, read))
    if isinstance(content, Line | Power) and waveform.peak_to_peak < _FEW_STEPS * resolution:
        moved = max(moved, resolution / math.sqrt(12.0))
    return abs(scale) * moved / read


def _feature(each: Measurement) -> Callable[[Waveform], complex]:
    """Return the feature of a waveform that such a number is proportional to, 0 where it is not known."""
    line_Hz = _or_nan(each.basis.frequency_Hz)
    match each.sensitivities.content:
        case Line() | Largest() | Component("positive"):
            return lambda of: of.amplitude(line_Hz)
        case Component():
            # small beside the phases, whose errors may move it at any angle
            return lambda of: of.line(line_Hz)
        case Harmonics(fundamental_Hz, as_ratio):
            highest_Hz = top_Hz(each)

            def harmonics(of: Waveform) -> float:
                whole = math.hypot(*(amplitude for _, amplitude in of.harmonics(fundamental_Hz, highest_Hz)))
                return whole / of.amplitude(fundamental_Hz) if as_ratio and whole else whole

            return harmonics
        case Noise(fundamental_Hz):
            return lambda of: of.between(fundamental_Hz)
        case _:
            return lambda of: of.rms
