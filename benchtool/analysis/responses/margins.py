"""Stability margins of a loop from the response of the controlled quantity to its reference.

With unity feedback the closed loop is T = L / (1 + L), so that the open loop is L = T / (1 - T), and the
sensitivity S = 1 / (1 + L) = 1 - T (Åström and Murray, Feedback Systems, 2nd ed., 10.3 and 12.1). Of the
control error, which is the stimulus less the controlled quantity, the response is L itself.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.numbers import raw
from benchtool.analysis.responses.estimated_response import NEPER_DB, decibels, without_jumps
from benchtool.analysis.responses.local_reciprocal import LocalReciprocal
from benchtool.analysis.responses.response_curve import Point, ResponseCurve
from benchtool.analysis.uncertainty import Uncertainty

Floats = NDArray[np.float64]

_LEAST = 1e-9  # of 1 - T: a loop that is perfect except for rounding
_MOST_UNCERTAIN = 0.1  # of the sensitivity
_SMALL_DB = 1.0
_SMALL_RAD = 0.1
_KNOWN = 4.0  # standard uncertainties of 1 - T: its angle is known to a quarter of a radian
_CLEARLY = 2.0  # standard uncertainties
_FEWEST = 5  # frequencies of an open loop
_OF_OPEN_LOOP = {
    "crossover": ("Hz", "lowest frequency at which the open loop has the gain 1"),
    "phase_margin": ("deg", "180 degrees + phase of the open loop at crossover"),
    "gain_margin": (
        "dB",
        "gain of the open loop below 1 at the lowest frequency where its phase falls to -180 degrees",
    ),
}
_IS_ERROR = 0.2  # of the input and of the output: what the error differs from the input by, at most
_SOURCE = "random error of the response, propagated to the open loop"


class Loop(Enum):
    """What a response is of the loop that it is measured in; the value is how its definitions say it."""

    CLOSED = "; the response is the closed loop T, the open loop T / (1 - T)"
    OPEN = "; the response is the open loop L, the input being the stimulus less the output; T = L / (1 + L)"


def loop_of(x: Floats, y: Floats, stimulus: Floats | None) -> Loop:
    """Return whether the response of `y` to `x` is that of the open loop, by their samples and those of the
    stimulus, each of shape (n,): it is where the input is the stimulus less the output, to within rounding
    and noise."""
    if stimulus is None:
        return Loop.CLOSED
    left = float(np.std(stimulus - y - x))
    return Loop.OPEN if left < _IS_ERROR * min(float(np.std(x)), float(np.std(y))) else Loop.CLOSED


def margins(
    frequency_Hz: Floats,
    response: NDArray[np.complex128],
    error: Floats,
    basis: Basis,
    shared: Floats | None = None,
    loop: Loop = Loop.CLOSED,
) -> Iterator[Measurement]:
    """Yield the crossover, phase margin, gain margin and greatest sensitivity of the loop behind a response.

    `response` is that of the controlled quantity to its reference, or as `loop` says, to the control error,
    shape (n,), a pure number, `error` its standard uncertainty relative to it, along it and across it, as if
    uncorrelated; `shared` of them each tell as much as one.

    Below the crossover 1 - T is small, and where noise hides it the open loop has any phase: it is read from
    the frequency on above which 1 - T is known.
    """
    closed = response
    if loop is Loop.OPEN:
        closed = response / (1.0 + response)
        error = error / np.abs(1.0 + response)  # dT / T = dL / (L (1 + L))
    sensitivity = 1.0 - closed
    shared = np.ones(len(closed)) if shared is None else shared
    magnitude = np.maximum(np.abs(sensitivity), _LEAST)
    unsure = _KNOWN * error * np.abs(closed)
    is_open = magnitude - np.abs(closed) > unsure
    before = int(np.argmax(is_open)) if np.any(is_open) else len(closed)
    hidden = np.flatnonzero(magnitude[:before] < unsure[:before])
    first = int(hidden[-1]) + 1 if len(hidden) else 0
    if len(closed) - first >= _FEWEST:
        yield from _of_open_loop(
            frequency_Hz[first:],
            closed[first:] / np.where(magnitude <= _LEAST, _LEAST, sensitivity)[first:],
            (error / magnitude)[first:],  # dL / L = dT / (T (1 - T))
            shared[first:],
            basis,
            loop,
        )
    else:
        reason = (
            f"noise hides 1 - T up to {raw(frequency_Hz[-1], 4)} Hz: raise the stimulus, or record longer"
        )
        for name in _OF_OPEN_LOOP:
            unit, text = _of_open(name, loop)
            yield Measurement.undefined(name, unit, text, reason, basis)
    yield _sensitivity_peak(frequency_Hz, closed, error, shared, basis, loop)


def _of_open(name: str, loop: Loop) -> tuple[str, str]:
    """Return the unit and the definition of a number that is read from the open loop."""
    unit, text = _OF_OPEN_LOOP[name]
    return unit, text + loop.value


def _of_open_loop(
    frequency_Hz: Floats,
    opened: NDArray[np.complex128],
    spread: Floats,
    shared: Floats,
    basis: Basis,
    loop: Loop,
) -> Iterator[Measurement]:
    """Yield what is read from the open loop and its relative errors, all of shape (n,)."""
    gain = ResponseCurve.of_gain(frequency_Hz, opened, spread, _SMALL_DB, shared)
    phase = ResponseCurve.of_phase(frequency_Hz, opened, spread, _SMALL_RAD, shared)

    unit, text = _of_open("crossover", loop)
    crossover = gain.falls_to(0.0)
    reason = _why_not(crossover, frequency_Hz, "its gain stays above 1")
    if crossover is None or reason:
        yield Measurement.undefined("crossover", unit, text, reason, basis)
        unit, text = _of_open("phase_margin", loop)
        yield Measurement.undefined("phase_margin", unit, text, reason, basis)
    else:
        uncertain = Uncertainty(crossover.standard_Hz, _SOURCE)
        yield Measurement("crossover", crossover.frequency_Hz, unit, text, basis, uncertain)
        angle, angle_error = phase.at(crossover.frequency_Hz)
        along = phase.slope_at(crossover.frequency_Hz) * crossover.standard_Hz
        unit, text = _of_open("phase_margin", loop)
        uncertain = Uncertainty(math.degrees(math.hypot(angle_error, along)), _SOURCE)
        margin = math.remainder(180.0 + math.degrees(angle), 360.0)
        if (again_Hz := gain.rises_again_to(0.0)) is not None:
            again = raw(again_Hz, 4)
            why = f"the gain is above 1 again at {again} Hz, as of a resonance: its margin counts too"
            yield Measurement.undefined("phase_margin", unit, text, why, basis)
        else:
            yield Measurement("phase_margin", margin, unit, text, basis, uncertain)

    unit, text = _of_open("gain_margin", loop)
    if crossover is not None and not reason:
        first, turns = _branch(frequency_Hz, opened, crossover.frequency_Hz)
        above = slice(first, None)
        phase = ResponseCurve.of_phase(
            frequency_Hz[above], opened[above], spread[above], _SMALL_RAD, shared[above], turns=turns
        )
    turned = phase.falls_to(-math.pi)
    reason = _why_not(turned, frequency_Hz, "its phase stays above -180 degrees")
    if turned is None or reason:
        yield Measurement.undefined("gain_margin", unit, text, reason, basis)
    else:
        level_dB, level_error = gain.at(turned.frequency_Hz)
        along = gain.slope_at(turned.frequency_Hz) * turned.standard_Hz
        uncertain = Uncertainty(math.hypot(level_error, along), _SOURCE)
        yield Measurement("gain_margin", -level_dB, unit, text, basis, uncertain)


def _branch(frequency_Hz: Floats, opened: NDArray[np.complex128], crossover_Hz: float) -> tuple[int, int]:
    """Return from which frequency on the phase of an open loop, shape (n,), counts, and by how many turns
    that of the first is off from within half a turn.

    Of a loop with two integrators it begins near -180 degrees, where 1 - T is small and its error turns the
    phase to +180 degrees. At the crossover the branch is known: there it is nearest to -90 degrees. From
    where it is below -180 degrees for the last time before that, it does not fall to this.
    """
    phase = without_jumps(frequency_Hz, opened)
    at = min(int(np.searchsorted(frequency_Hz, crossover_Hz)), len(phase) - 1)
    phase -= 2.0 * math.pi * round((float(phase[at]) + 0.5 * math.pi) / (2.0 * math.pi))
    below = np.flatnonzero(phase[:at] <= -math.pi)
    first = int(below[-1]) + 1 if len(below) and phase[at] > -math.pi else 0
    return first, round((float(phase[first]) - float(np.angle(opened[first]))) / (2.0 * math.pi))


def _sensitivity_peak(
    frequency_Hz: Floats,
    closed: NDArray[np.complex128],
    error: Floats,
    shared: Floats,
    basis: Basis,
    loop: Loop,
) -> Measurement:
    """Return the greatest sensitivity.

    Far above the crossover every loop opens and S tends to 1, so that a greatest value below 1 is not that of
    the loop but of the frequencies used. Nor is one at the lowest of these, or one from which S has not
    fallen clearly within them, unless T is so small at the last of them that S, at most 1 + T, cannot be much
    greater above.
    """
    name, text = "sensitivity_peak", f"greatest magnitude of the sensitivity 1 - T, M_s{loop.value}"
    reciprocal = LocalReciprocal(frequency_Hz, 1.0 / closed, error, shared)

    def between(at: int, fine_Hz: Floats) -> tuple[Floats, Floats]:
        found, relative = reciprocal.between(at, fine_Hz)
        return _of_sensitivity(1.0 / found, relative)

    curve = ResponseCurve(frequency_Hz, *_of_sensitivity(closed, error), _SMALL_DB, between)
    peak_dB, peak_error_dB = curve.resonance()
    peak, relative = 10.0 ** (peak_dB / 20.0), peak_error_dB / NEPER_DB
    last_Hz = float(frequency_Hz[-1])
    last_dB, last_error_dB = curve.at(last_Hz)
    has_fallen = peak_dB - last_dB > _CLEARLY * math.hypot(peak_error_dB, last_error_dB)
    largest_above = 1.0 + float(np.median(np.abs(closed[-_FEWEST:])))
    reason = ""
    if not math.isfinite(relative):
        reason = "the response beside its peak is not known: raise the stimulus, or play more frequencies"
    elif not relative <= _MOST_UNCERTAIN:
        reason = f"it is uncertain by {raw(100.0 * relative, 2)} %: raise the stimulus"
    elif int(np.argmax(curve.smooth)) == 0:
        lowest = raw(frequency_Hz[0], 4)
        reason = f"it falls from {lowest} Hz on, the lowest frequency used: play lower frequencies"
    elif peak < 1.0:
        reason = (
            f"it is {raw(peak, 2)} up to {raw(last_Hz, 4)} Hz and reaches 1 above that: play higher "
            f"frequencies"
        )
    elif not has_fallen and largest_above > peak * (1.0 + relative):
        reason = (
            f"it has not clearly fallen from {raw(peak, 4)} up to {raw(last_Hz, 4)} Hz and may be up to "
            f"{raw(largest_above, 4)} above that: play higher frequencies"
        )
    if reason:
        return Measurement.undefined(name, "", text, reason, basis)
    return Measurement(name, peak, "", text, basis, Uncertainty(peak * relative, _SOURCE))


def _of_sensitivity(closed: NDArray[np.complex128], error: Floats) -> tuple[Floats, Floats]:
    """Return the magnitudes of 1 - T in dB and their standard uncertainties, by T and its relative errors."""
    magnitude = np.maximum(np.abs(1.0 - closed), _LEAST)
    return decibels(magnitude), NEPER_DB * error * np.abs(closed) / magnitude


def _why_not(found: Point | None, frequency_Hz: Floats, otherwise: str) -> str:
    """Return the reason why a crossing is undefined; empty if it is defined."""
    if found is None:
        return f"{otherwise} up to {raw(frequency_Hz[-1], 4)} Hz"
    return found.undefined_because
