"""Mean frequency of the fundamental over a window, with its budget."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import replace

import numpy as np

from benchtool.analysis.coherent.spectrum import CoherentSpectrum
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.continuation import FEWEST
from benchtool.analysis.phase.turned_angle import tells_its_turn, turned_by_angle
from benchtool.analysis.phase.turned_phase import Turned, middles_of_periods, turned_by_tone
from benchtool.analysis.phase.wander import Wander
from benchtool.analysis.sensitivity import NO_SENSORS
from benchtool.analysis.statistics.repeatability import wander_of_difference
from benchtool.analysis.uncertainty import Contribution, combined

_LEAST_DEPARTURE_RAD = 0.2  # electrical, over the record
_CLEARLY = 3.0  # expanded uncertainties
_TOO_SHORT = (
    "an error of the angle's sensor does not show within {:.2g} revolutions, and the signal has {} whole "
    "periods, at least {} are needed to tell its own phase: record longer"
)


def frequency(
    spectrum: CoherentSpectrum,
    track: PhaseTrack,
    seen: Wander,
    basis: Basis,
    rate_relative: float | None,
    reason: str,
    step: float = 0.0,
    beside_rad: float = 0.0,
    within_periods: Callable[[Turned], Turned | None] = lambda _: None,
) -> Measurement:
    """Return the mean electrical frequency over the window, of a signal with steps of `step`; undefined for a
    `reason` where the signal itself gave it. `beside_rad` is what a line beside it leaves open of its phase
    over the record, and `within_periods` gives that of a signal that swings within few of them, where means
    over periods do not tell it as well."""
    name, text = "fundamental_frequency", "mean electrical frequency of the window"
    if len(seen.phase_rad) < FEWEST and tells_its_turn(steady := replace(track, departure=None)):
        track = steady  # too few periods to tell the signal's own phase
    by_tone = track.measured_rad is None or track.follows_signal or not tells_its_turn(track)
    is_told = not reason and len(seen.phase_rad) >= FEWEST
    if by_tone and not reason and not is_told and track.measured_rad is not None:
        reason = _TOO_SHORT.format(track.periods / track.pole_pairs, len(seen.phase_rad), FEWEST)
    is_asked = is_told or (by_tone and not reason)
    tone = turned_by_tone(spectrum, track, seen, step, beside_rad) if is_asked else None
    turned = tone if by_tone else turned_by_angle(track, seen, tone)
    quick = within_periods(turned) if is_told and turned is not None else None
    if (by_tone or quick is not None) and track.measured_rad is not None:
        of_angle_Hz = _of_angle_Hz(spectrum, track)
        text += f", of the signal; the angle alone gives {of_angle_Hz:.6g} Hz"
        basis = replace(basis, angle_Hz=of_angle_Hz)
    if turned is None:
        return Measurement.undefined(name, "Hz", text, reason, basis)
    rate_Hz = spectrum.samples / spectrum.duration_s
    per_rad_Hz = rate_Hz / (2.0 * math.pi * (track.samples - 1))
    turned = quick or turned
    budget = [replace(each, standard=per_rad_Hz * each.standard) for each in turned.budget]
    by_stamps = "" if rate_relative is None else ", and of the rate by the time stamps"
    # residue of Newton's method and rounding in a phase
    rounding_rad = 1e-9 + np.finfo(float).eps * 2.0 * math.pi * spectrum.periods
    budget.append(Contribution("rounding", "B", rounding_rad / (2.0 * math.pi * spectrum.duration_s)))
    if rate_relative is not None:
        of_rate = Contribution("sample rate", "B", rate_relative * spectrum.fundamental_Hz)
        budget.append(of_rate)
    uncertain = combined([each for each in budget if each.standard != 0.0], f"{turned.source}{by_stamps}")
    value_Hz = per_rad_Hz * turned.phase_rad
    whole = replace(basis, samples=track.samples, duration_s=track.samples / rate_Hz)
    return Measurement(
        name,
        value_Hz,
        "Hz",
        text,
        whole,
        uncertain,
        repeatability=_between_records(spectrum, track, seen),
        sensitivities=NO_SENSORS,
    )


def _between_records(spectrum: CoherentSpectrum, track: PhaseTrack, seen: Wander) -> Contribution | None:
    """Return how much the mean frequency of another record differs because the speed wanders."""
    if track.measured_rad is not None:
        phase_rad, duration_s = track.measured_rad, spectrum.duration_s * track.samples / spectrum.samples
    else:
        marks = middles_of_periods(track, seen)
        rate_Hz = spectrum.samples / spectrum.duration_s
        phase_rad = track.at(marks) + seen.phase_rad
        duration_s = len(marks) * float(marks[1] - marks[0]) / rate_Hz
    wander = wander_of_difference(phase_rad)
    if not math.isfinite(wander.standard):
        return None
    name = "wander of the speed, by that of the phase within the record"
    return Contribution(name, "A", wander.standard / (2.0 * math.pi * duration_s), wander.dof)


def angle_remarks(measurements: Iterable[Measurement]) -> tuple[str, ...]:
    """Return the remark that a signal and a rotor angle do not turn together, if they do not."""
    return tuple(filter(None, map(_departure, measurements)))


def _departure(each: Measurement) -> str:
    of_angle_Hz, duration_s = each.basis.angle_Hz, each.basis.duration_s
    if of_angle_Hz is None or duration_s is None or each.uncertainty is None:
        return ""
    apart_Hz = abs(each.value - of_angle_Hz)
    apart_rad = 2.0 * math.pi * apart_Hz * duration_s
    if not (apart_rad > _LEAST_DEPARTURE_RAD and apart_Hz > _CLEARLY * each.uncertainty.expanded):
        return ""
    return (
        f"by its own phase the current is at {each.value:.6g} Hz, by angle and pole pairs at "
        f"{of_angle_Hz:.6g} Hz, {math.degrees(apart_rad):.3g}° electrical apart within the record: the "
        f"encoder slips or loses counts, the load changes, or the machine is one that slips; orders rest on "
        f"that angle"
    )


def _of_angle_Hz(spectrum: CoherentSpectrum, track: PhaseTrack) -> float:
    begin, end = float(track.phase(0)), float(track.phase(track.samples - 1))
    rate_Hz = spectrum.samples / spectrum.duration_s
    return (end - begin) / (2.0 * math.pi) * rate_Hz / (track.samples - 1)
