"""Frequency of the fundamental, and whether it is suitable as a reference."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy import fft
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.periods import PhaseTrack, repeated_in_periods
from benchtool.analysis.quantisation.counted_line import CountedLine, line_through_counts, of_slow_beats
from benchtool.analysis.sensitivity import NO_SENSORS
from benchtool.analysis.spectra.continuation import FEWEST, continuation
from benchtool.analysis.spectra.converter_lines import aliased_quantisation
from benchtool.analysis.spectra.noise import harmonic_noise
from benchtool.analysis.spectra.noise_of_lines import hann_quadrature, line_noise
from benchtool.analysis.spectra.phase_following import Wander
from benchtool.analysis.spectra.spectrum import FIRST_ROW, CoherentSamples, CoherentSpectrum, rows_of
from benchtool.analysis.statistics.regimes import STANDS_OUT, change_of_regime
from benchtool.analysis.statistics.repeatability import wander_of_difference
from benchtool.analysis.statistics.scatter import MeanError, error_of_series
from benchtool.analysis.uncertainty import Contribution, combined

_HANN_FIT = math.sqrt(54.463)
"""Standard uncertainty of a frequency by the fit of `track_tone`, in units of that of the mean phase over
the duration: root of int w^4 t^2 dt / (int w^2 t^2 dt)^2, w = cos^2(pi t), t from -1/2 to 1/2; unweighted it
is sqrt(12)."""

_OF_FOLDED = 0.6 / math.sqrt(2.0)  # cycles over the record, of a line a bin away, of any phase
_LESS_THAN_A_COUNT = 1.0 - 1e-6
_LEAKS = 4.0  # times the power under a Hann window: what the rectangular one leaks, beyond chance
_ABOVE_FLOOR = 4.0  # of the rms amplitude of a bin of noise: by chance once in ten million
_BLOCKS = 64
_FEWEST_AT_END = 12  # samples of an angle for a cubic
_FEWEST_BLOCKS = 8
_AT_ENDS = 4  # periods
_MOSTLY = 0.5  # of a variance
# of a bend: a mean over a period is a 24th off its middle, and half of that is left
_WITHIN = 1.0 / 48.0
_HIGHEST_TURNED, _QUARTERS, _TURNS = 13, 4, 0.5
_LARGEST_WANDER_RAD = 0.1  # at which harmonic 5 reads an eighth low


@dataclass(frozen=True)
class Soundness:
    """Reasons why amplitudes, or ratios to the fundamental, are undefined; empty where they are defined."""

    of_amplitudes: str
    of_ratios: str


def soundness(spectrum: CoherentSpectrum, seen: Wander, invalid: str, name: str) -> Soundness:
    """Return whether the record is of one regime and on a phase, and the fundamental out of the noise;
    `invalid` is why it is not for other reasons."""
    reason = (
        invalid
        or change_of_regime(seen.amplitude, f"the amplitude of {name}")
        or _jump(seen, name)
        or _off_phase(seen, name)
    )
    amplitude = spectrum.fundamental
    noise = line_noise(spectrum, np.array([spectrum.periods])).in_phase[0]
    floor = math.sqrt(2.0) * harmonic_noise(spectrum, 1)[0]
    if not amplitude > 0.0:
        return Soundness(reason, reason or "the fundamental is zero")
    if amplitude < STANDS_OUT * noise or amplitude < _ABOVE_FLOOR * floor:
        lost = f"the fundamental of {amplitude:.3g} does not stand out of the noise around it"
        return Soundness(reason, reason or lost)
    return Soundness(reason, reason)


def turned_around(coherent: CoherentSamples, seen: Wander, name: str) -> str:
    """Return why a record without an angle is of two regimes by its two strongest harmonics; empty if not.

    A current that reverses where it is greatest or least goes on as before, but for the phases of these.
    """
    table = coherent.values.reshape(coherent.periods, coherent.per_period)
    highest = min(_HIGHEST_TURNED, coherent.per_period // 2 - 1)
    parts = min(_QUARTERS, coherent.periods // 2)
    if parts < 2 or highest < 2:
        return ""
    order = np.arange(2, highest + 1)
    phasors = fft.rfft(table, axis=1)[:, 2 : highest + 1] * np.exp(
        -1j * np.outer(seen.phase_rad[: coherent.periods], order)
    )
    groups = np.array_split(phasors, parts)
    means = np.array([np.mean(each, axis=0) for each in groups])
    noise = np.sqrt(np.mean([np.var(each, axis=0, ddof=1) / len(each) for each in groups], axis=0))
    size = np.mean(np.abs(means), axis=0)
    change = np.max(np.abs(means[:, np.newaxis] - means), axis=(0, 1))
    turned = (change > _TURNS * size + STANDS_OUT * noise) & (size > STANDS_OUT * noise)
    for strongest in np.argsort(-size)[:2]:
        if turned[strongest]:
            return (
                f"harmonic {order[strongest]} of {name} turns against the fundamental between parts of the "
                f"window: it reversed or changed its load; choose a window in steady state"
            )
    return ""


def frequency(
    spectrum: CoherentSpectrum,
    track: PhaseTrack,
    seen: Wander,
    basis: Basis,
    rate_relative: float | None,
    reason: str,
    step: float = 0.0,
    beside_rad: float = 0.0,
) -> Measurement:
    """Return the mean electrical frequency over the window, of a signal with steps of `step`; undefined for a
    `reason` where the signal itself gave it. `beside_rad` is what a line beside it leaves open of its phase
    over the record."""
    name, text = "fundamental_frequency", "mean electrical frequency of the window"
    by_tone = track.residual_rad is None or (track.departure is not None and "itself" in track.source)
    if by_tone and track.residual_rad is not None:
        text += f", of the signal; the angle alone gives {_of_angle_Hz(spectrum, track):.6g} Hz"
    if by_tone and reason:
        return Measurement.undefined(name, "Hz", text, reason, basis)
    rate_Hz = spectrum.samples / spectrum.duration_s
    per_rad_Hz = rate_Hz / (2.0 * math.pi * (track.samples - 1))
    turned_rad, lines, source = _turned(spectrum, track, seen, by_tone, step)
    if by_tone:
        lines.append(Contribution("a line beside the fundamental", "B", beside_rad))
    budget = [replace(each, standard=per_rad_Hz * each.standard) for each in lines]
    clock = "; the clock is left out" if rate_relative is None else ", and of the rate by the time stamps"
    # residue of Newton's method and rounding in a phase
    rounding_rad = 1e-9 + np.finfo(float).eps * 2.0 * math.pi * spectrum.periods
    budget.append(Contribution("rounding", "B", rounding_rad / (2.0 * math.pi * spectrum.duration_s)))
    if rate_relative is not None:
        of_rate = Contribution("sample rate", "B", rate_relative * spectrum.fundamental_Hz)
        budget.append(of_rate)
    uncertain = combined([each for each in budget if each.standard != 0.0], f"{source}{clock}")
    value_Hz = per_rad_Hz * turned_rad
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


def left_at_ends_rad(seen: Wander) -> float:
    """Return what is left of lines that were taken out of a fundamental, in the difference of its phases at
    both ends of a record, where it is most."""
    phase_rad = seen.phase_rad - np.mean(seen.phase_rad)
    return math.sqrt(sum(_shared2(phase_rad[rows]) for rows in (slice(_AT_ENDS), slice(-_AT_ENDS, None))))


def _shared2(phase_rad: NDArray[np.float64]) -> float:
    """Return the mean product of neighbouring phases, rad^2: what is not taken back from one period to the
    next, as a track that noise or lines pull to and fro is by the phases that are seen along it."""
    return max(0.0, float(np.mean(phase_rad[1:] * phase_rad[:-1])))


def _between_records(spectrum: CoherentSpectrum, track: PhaseTrack, seen: Wander) -> Contribution | None:
    """Return how much the mean frequency of another record differs because the speed wanders."""
    if track.measured_rad is not None:
        phase_rad, duration_s = track.measured_rad, spectrum.duration_s * track.samples / spectrum.samples
    else:
        marks = _marks(track, seen)
        rate_Hz = spectrum.samples / spectrum.duration_s
        phase_rad = track.at(marks) + seen.phase_rad
        duration_s = len(marks) * float(marks[1] - marks[0]) / rate_Hz
    wander = wander_of_difference(phase_rad)
    if not math.isfinite(wander.standard):
        return None
    name = "wander of the speed, by that of the phase within the record"
    return Contribution(name, "A", wander.standard / (2.0 * math.pi * duration_s), wander.dof)


def _turned(
    spectrum: CoherentSpectrum, track: PhaseTrack, seen: Wander, by_tone: bool, step: float
) -> tuple[float, list[Contribution], str]:
    """Return the phase, rad, from the first to the last row, its budget, and in words what that is from."""
    smooth_rad = 2.0 * math.pi * track.periods
    is_told = seen.excess_rad > 0.0 and len(seen.phase_rad) >= FEWEST
    if by_tone and (track.departure is not None or is_told):
        # what is too little to be followed for the amplitudes, but no noise, is in the phase of both ends
        is_followed = track.departure is not None
        what = "what is left of the followed phase" if is_followed else "noise of the phases of periods"
        source = f"{what}, and its continuation to both ends"
        turned_rad, standard = _to_both_ends(track, seen)
        return turned_rad, [Contribution(source, "A", standard, float(len(seen.phase_rad) - 1))], source
    if by_tone:
        source = "noise beside the fundamental, by the sine fit under a Hann window"
        noise = _of_sine_fit(spectrum)
        lines = [Contribution(source, "A", noise.standard, noise.dof)]
        if spectrum.fundamental:
            folded_rad = float(aliased_quantisation(spectrum, step)[0]) / spectrum.fundamental
            of_steps = 2.0 * math.pi * _OF_FOLDED * folded_rad
            lines.append(Contribution("steps that fold to beside the fundamental", "B", of_steps))
        return smooth_rad, lines, source
    counted = _of_counts(track)
    if counted is not None:
        source = "slopes that the counts of the angle allow"
        # a speed that is not quite constant shows nowhere but where counts pass
        standard = max(counted.standard * (track.samples - 1), _of_beats(track))
        return counted.slope * (track.samples - 1), [Contribution(source, "B", standard)], source
    bend_rad = _half_of_bend(track)
    scatter = _of_angle(track, bend_rad)
    if track.measured_rad is None or (track.departure is None and math.isfinite(scatter.standard)):
        source = "deviation of the angle from its fit, by parts of the record"
        of_bend = Contribution("swing slower than the record, of the rotor or its sensor", "B", abs(bend_rad))
        lines = [Contribution(source, "A", scatter.standard, scatter.dof), of_bend]
        if track.resolution_rad > 0.0:
            lines.append(Contribution("steps of the angle that beat with the rows", "B", _of_beats(track)))
        return smooth_rad + bend_rad, lines, source
    turned_rad, of_ends = _by_ends(track, track.measured_rad)
    # what the signal does not do with the angle may be an error of the angle, at each end another
    departed = Contribution("departure of the signal", "B", math.sqrt(2.0) * seen.excess_rad)
    return turned_rad, [*of_ends, departed], "noise, bend and resolution of the angle at both ends"


def _of_counts(track: PhaseTrack) -> CountedLine | None:
    """Return the phase per row, rad, of an angle in counts that a constant speed explains; None where it does
    not."""
    if track.measured_rad is None or track.departure is not None or not track.resolution_rad > 0.0:
        return None
    rows = np.arange(track.samples, dtype=np.float64)
    return line_through_counts(track.measured_rad, rows, _LESS_THAN_A_COUNT * track.resolution_rad)


def _of_beats(track: PhaseTrack) -> float:
    per_row = 2.0 * math.pi * track.periods / (track.samples - 1) / track.resolution_rad
    return of_slow_beats(track.resolution_rad, per_row, track.samples, track.residual_rad or 0.0)


def _of_sine_fit(spectrum: CoherentSpectrum) -> MeanError:
    """Return the uncertainty, by noise, of the phase over the record of a sine fit under a Hann window."""
    noise = line_noise(spectrum, np.array([spectrum.periods]))
    beside = MeanError(float(noise.quadrature[0]), float(noise.dof[0]))
    windowed = hann_quadrature(spectrum)
    if _LEAKS * windowed.standard**2 < beside.standard**2:
        beside = windowed
    phase_rad = beside.standard / spectrum.fundamental if spectrum.fundamental else math.nan
    return MeanError(_HANN_FIT * phase_rad, beside.dof)


def _of_angle(track: PhaseTrack, bend_rad: float) -> MeanError:
    """Return the uncertainty of the phase over the record of an angle's fit, by the scatter over its parts.

    The slope is the sum of (t - mean t) times deviation over the sum of (t - mean t)^2. What the angle does
    in every period alike is not in the fit, and a cubic course by `_half_of_bend` is no scatter.
    """
    if track.measured_rad is None or track.residual_rad is None:
        return MeanError(math.nan, math.nan)
    count = track.samples
    parts = min(_BLOCKS, max(_FEWEST_BLOCKS, int(track.periods)))
    edges = np.linspace(0, count, parts + 1).astype(np.int64)
    moments = []
    repeated_rad = repeated_in_periods(track.measured_rad, track.phase, track.resolution_rad)
    measured_rad = track.measured_rad - repeated_rad
    for begin, end in itertools.pairwise(edges):
        number = np.arange(begin, end, dtype=np.float64)
        left = measured_rad[begin:end] - track.at(number) - bend_rad * _cubic(number, count)
        moments.append(float((number - 0.5 * (count - 1)) @ left))
    scatter = error_of_series(np.array(moments))
    slope = scatter.standard * parts / (count * (count**2 - 1.0) / 12.0)
    return MeanError(slope * (count - 1), min(scatter.dof, parts - 3.0))


def _half_of_bend(track: PhaseTrack) -> float:
    """Return half of the phase, rad, from the first to the last row of a cubic course of the angle about its
    fit, where that is most of what it does; else 0.

    A swing of the rotor that is slower than the record has turned it by all of that, and an error of the
    sensor, as once in a revolution, by none: each is as likely, and half of it a standard deviation away.
    """
    if track.measured_rad is None:
        return 0.0
    number = np.arange(track.samples, dtype=np.float64)
    left = track.measured_rad - track.at(number)
    size = 7.0 * float(np.mean(_cubic(number, track.samples) * left))
    return size if size**2 / 7.0 > _MOSTLY * float(np.var(left)) else 0.0


def _cubic(number: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return Legendre's polynomial of third degree at sample numbers, shape (n,), of so many: it is -1 and 1
    at their ends, of mean square 1/7."""
    x = 2.0 * number / (count - 1.0) - 1.0
    return np.asarray(0.5 * x * (5.0 * x**2 - 3.0))


def _marks(track: PhaseTrack, seen: Wander) -> NDArray[np.float64]:
    """Return the middles of all whole periods, in rows, as of a constant speed."""
    count = len(seen.phase_rad)
    return FIRST_ROW + rows_of(track, count) / count * (np.arange(count, dtype=np.float64) + 0.5)


def _to_both_ends(track: PhaseTrack, seen: Wander) -> tuple[float, float]:
    """Return the phase of a followed tone from the first to the last row, and its standard uncertainty, rad.

    The phases of periods reach to half a period from there, or one and a half: the rest is a continuation.
    What a bend within a period does to its phase is alike at both ends, but for how the bend varies.
    """
    marks = _marks(track, seen)
    per_period = float(marks[1] - marks[0])
    phase_rad = track.at(marks) + seen.phase_rad
    going_on = continuation(phase_rad)
    within_rad = _WITHIN * float(np.std(np.diff(track.at(marks), n=2)))
    before, after = (rows / per_period for rows in (float(marks[0]), track.samples - 1.0 - float(marks[-1])))
    ends_rad = [
        float(going_on.weights(by) @ phases[-going_on.size :])
        for by, phases in ((before, phase_rad[::-1]), (after, phase_rad))
    ]
    left2 = seen.noise_rad**2
    if track.departure is not None:
        left2 = going_on.noise2 + _shared2(seen.phase_rad - np.mean(seen.phase_rad))
    square = 2.0 * (left2 + within_rad**2)
    square += going_on.error2(before) + going_on.error2(after)
    return ends_rad[1] - ends_rad[0], math.sqrt(square)


def _by_ends(track: PhaseTrack, measured_rad: NDArray[np.float64]) -> tuple[float, tuple[Contribution, ...]]:
    """Return the phase from the first to the last row by the measured angle, and its uncertainty.

    At either end the angle's deviation from the smooth track by a parabola through an eighth of a period; a
    cubic in its place estimates the error of the parabola. Steps of the angle that pass there scatter about
    it, and are in its noise; what does not, as of steps that beat with the samples, is not.
    """
    size = max(_FEWEST_AT_END, round(track.samples / (8.0 * track.periods)))
    values, random, left_out, steps2 = [], [], [], []
    for rows in (slice(size), slice(track.samples - size, track.samples)):
        numbers = np.arange(track.samples, dtype=np.float64)[rows]
        left = measured_rad[rows] - np.asarray(track.phase(numbers))
        edge = numbers[0] if rows.start is None else numbers[-1]
        parabola, cubic = (Polynomial.fit(numbers, left, degree) for degree in (2, 3))
        values.append(float(parabola(edge) + track.phase(edge)))
        freedom = max(1, len(numbers) - 4)
        noise = math.sqrt(float(np.sum((left - cubic(numbers)) ** 2)) / freedom)
        # of the end of a parabola: nine times the variance of a mean
        random.append(3.0 * noise / math.sqrt(len(numbers)))
        left_out.append(float(cubic(edge) - parabola(edge)))
        steps2.append(max(0.0, track.resolution_rad**2 / 12.0 - noise**2))
    return values[1] - values[0], (
        Contribution("noise of the angle at both ends", "A", math.hypot(*random), 2.0 * size - 8.0),
        Contribution("bend of the angle at both ends", "B", math.hypot(*left_out)),
        Contribution("resolution of the angle", "B", math.sqrt(sum(steps2))),
    )


def _of_angle_Hz(spectrum: CoherentSpectrum, track: PhaseTrack) -> float:
    begin, end = float(track.phase(0)), float(track.phase(track.samples - 1))
    rate_Hz = spectrum.samples / spectrum.duration_s
    return (end - begin) / (2.0 * math.pi) * rate_Hz / (track.samples - 1)


def _jump(seen: Wander, name: str) -> str:
    if not seen.jump_rad:
        return ""
    if seen.jumps_alone:
        slipped = (
            "the encoder, its coupling or belt slipped, or lost counts"
            if seen.by_angle
            else "rows are missing"
        )
        return (
            f"the phase of {name} jumps by {seen.jump_rad:.2g} rad from one period to the next, and its "
            f"amplitude and frequency stay: {slipped}, or the load changed; choose a window without it"
        )
    return (
        f"the phase of {name} jumps by {seen.jump_rad:.2g} rad from one period to the next: it reversed, "
        f"stood still or changed its load; choose a window in steady state"
    )


def _off_phase(seen: Wander, name: str) -> str:
    if not seen.excess_rad > _LARGEST_WANDER_RAD:
        return ""
    return f"the phase of {name} wanders by {seen.excess_rad:.2g} rad rms about the best track of it"
