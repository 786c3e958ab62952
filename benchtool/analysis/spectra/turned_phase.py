"""Phase of a tone, or of a measured angle, from the first to the last row of a window, with its budget."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.periods import PhaseTrack, repeated_in_periods
from benchtool.analysis.quantisation.counted_line import line_through_counts, of_slow_beats
from benchtool.analysis.spectra.continuation import FEWEST, continuation
from benchtool.analysis.spectra.converter_lines import aliased_quantisation
from benchtool.analysis.spectra.noise_of_lines import hann_quadrature, line_noise
from benchtool.analysis.spectra.phase_following import Wander
from benchtool.analysis.spectra.spectrum import FIRST_ROW, CoherentSpectrum, rows_of
from benchtool.analysis.statistics.scatter import MeanError, error_of_series
from benchtool.analysis.uncertainty import Contribution

_HANN_FIT = math.sqrt(54.463)
"""Standard uncertainty of a frequency by the fit of `track_tone`, in units of that of the mean phase over
the duration: root of int w^4 t^2 dt / (int w^2 t^2 dt)^2, w = cos^2(pi t), t from -1/2 to 1/2; unweighted it
is sqrt(12)."""

_OF_FOLDED = 0.6 / math.sqrt(2.0)  # cycles over the record, of a line a bin away, of any phase
_LESS_THAN_A_COUNT = 1.0 - 1e-6
_LEAKS = 4.0  # times the power under a Hann window: what the rectangular one leaks, beyond chance
_BLOCKS = 64
_FEWEST_AT_END = 12  # samples of an angle for a cubic
_FEWEST_BLOCKS = 8
_AT_ENDS = 4  # periods
_MOSTLY = 0.5  # of a variance
# of a bend: a mean over a period is a 24th off its middle, and half of that is left
_WITHIN = 1.0 / 48.0


@dataclass(frozen=True)
class Turned:
    """Phase from the first to the last row, rad, its budget, rad, and in words what that is from."""

    phase_rad: float
    budget: tuple[Contribution, ...]
    source: str


def turned_by_tone(
    spectrum: CoherentSpectrum, track: PhaseTrack, seen: Wander, step: float, beside_rad: float
) -> Turned:
    """Return the phase of a tone in a signal with steps of `step`, along whose own phase it was tracked;
    `beside_rad` is what a line beside it leaves open."""
    beside = Contribution("a line beside the fundamental", "B", beside_rad)
    if track.departure is not None or (seen.excess_rad > 0.0 and len(seen.phase_rad) >= FEWEST):
        # what is too little to be followed for the amplitudes, but no noise, is in the phase of both ends
        what = "noise of the phases of periods"
        if track.departure is not None:
            what = "what is left of the followed phase"
        source = f"{what}, and its continuation to both ends"
        turned_rad, standard = _to_both_ends(track, seen)
        of_ends = Contribution(source, "A", standard, len(seen.phase_rad) - 1.0)
        return Turned(turned_rad, (of_ends, beside), source)
    source = "noise beside the fundamental, by the sine fit under a Hann window"
    noise = _of_sine_fit(spectrum)
    lines = [Contribution(source, "A", noise.standard, noise.dof)]
    if spectrum.fundamental:
        folded_rad = float(aliased_quantisation(spectrum, step)[0]) / spectrum.fundamental
        of_steps = 2.0 * math.pi * _OF_FOLDED * folded_rad
        lines.append(Contribution("steps that fold to beside the fundamental", "B", of_steps))
    return Turned(2.0 * math.pi * track.periods, (*lines, beside), source)


def turned_by_angle(track: PhaseTrack, seen: Wander) -> Turned:
    """Return the phase of the measured angle of a track, of which the signal departs by what was `seen`.

    Raises:
        ValueError: the track has no measured angle.
    """
    if track.measured_rad is None:
        raise ValueError("a track without a measured angle: give the phase of the tone")
    if track.departure is None:
        turned = _of_counts(track, track.measured_rad) or _of_fit(track, track.measured_rad)
        if turned is not None:
            return turned
    turned_rad, of_ends = _by_ends(track, track.measured_rad)
    # what the signal does not do with the angle may be an error of the angle, at each end another
    departed = Contribution("departure of the signal", "B", math.sqrt(2.0) * seen.excess_rad)
    return Turned(turned_rad, (*of_ends, departed), "noise, bend and resolution of the angle at both ends")


def left_at_ends_rad(seen: Wander) -> float:
    """Return what is left of lines that were taken out of a fundamental, in the difference of its phases at
    both ends of a record, where it is most."""
    phase_rad = seen.phase_rad - np.mean(seen.phase_rad)
    return math.sqrt(sum(_shared2(phase_rad[rows]) for rows in (slice(_AT_ENDS), slice(-_AT_ENDS, None))))


def _shared2(phase_rad: NDArray[np.float64]) -> float:
    """Return the mean product of neighbouring phases, rad^2: what is not taken back from one period to the
    next, as a track that noise or lines pull to and fro is by the phases that are seen along it."""
    return max(0.0, float(np.mean(phase_rad[1:] * phase_rad[:-1])))


def _of_sine_fit(spectrum: CoherentSpectrum) -> MeanError:
    """Return the uncertainty, by noise, of the phase over the record of a sine fit under a Hann window."""
    noise = line_noise(spectrum, np.array([spectrum.periods]))
    beside = MeanError(float(noise.quadrature[0]), float(noise.dof[0]))
    windowed = hann_quadrature(spectrum)
    if _LEAKS * windowed.standard**2 < beside.standard**2:
        beside = windowed
    phase_rad = beside.standard / spectrum.fundamental if spectrum.fundamental else math.nan
    return MeanError(_HANN_FIT * phase_rad, beside.dof)


def _to_both_ends(track: PhaseTrack, seen: Wander) -> tuple[float, float]:
    """Return the phase of a followed tone from the first to the last row, and its standard uncertainty, rad.

    The phases of periods reach to half a period from there, or one and a half: the rest is a continuation.
    What a bend within a period does to its phase is alike at both ends, but for how the bend varies.
    """
    marks = middles_of_periods(track, seen)
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


def middles_of_periods(track: PhaseTrack, seen: Wander) -> NDArray[np.float64]:
    """Return the middles of all whole periods, in rows, as of a constant speed."""
    count = len(seen.phase_rad)
    return FIRST_ROW + rows_of(track, count) / count * (np.arange(count, dtype=np.float64) + 0.5)


def _of_counts(track: PhaseTrack, measured_rad: NDArray[np.float64]) -> Turned | None:
    """Return the phase of an angle in counts that a constant speed explains; None where it does not."""
    if not track.resolution_rad > 0.0:
        return None
    rows = np.arange(track.samples, dtype=np.float64)
    counted = line_through_counts(measured_rad, rows, _LESS_THAN_A_COUNT * track.resolution_rad)
    if counted is None:
        return None
    source = "slopes that the counts of the angle allow"
    # a speed that is not quite constant shows nowhere but where counts pass
    standard = max(counted.standard * (track.samples - 1), _of_beats(track))
    return Turned(counted.slope * (track.samples - 1), (Contribution(source, "B", standard),), source)


def _of_beats(track: PhaseTrack) -> float:
    per_row = 2.0 * math.pi * track.periods / (track.samples - 1) / track.resolution_rad
    return of_slow_beats(track.resolution_rad, per_row, track.samples, track.residual_rad or 0.0)


def _of_fit(track: PhaseTrack, measured_rad: NDArray[np.float64]) -> Turned | None:
    """Return the phase of the smooth track through an angle; None where its scatter has no uncertainty."""
    bend_rad = _half_of_bend(track, measured_rad)
    scatter = _of_parts(track, measured_rad, bend_rad)
    if not math.isfinite(scatter.standard):
        return None
    source = "deviation of the angle from its fit, by parts of the record"
    lines = [
        Contribution(source, "A", scatter.standard, scatter.dof),
        Contribution("swing slower than the record, of the rotor or its sensor", "B", abs(bend_rad)),
    ]
    if track.resolution_rad > 0.0:
        lines.append(Contribution("steps of the angle that beat with the rows", "B", _of_beats(track)))
    return Turned(2.0 * math.pi * track.periods + bend_rad, tuple(lines), source)


def _of_parts(track: PhaseTrack, measured_rad: NDArray[np.float64], bend_rad: float) -> MeanError:
    """Return the uncertainty of the phase over the record of an angle's fit, by the scatter over its parts.

    The slope is the sum of (t - mean t) times deviation over the sum of (t - mean t)^2. What the angle does
    in every period alike is not in the fit, and a cubic course by `_half_of_bend` is no scatter.
    """
    count = track.samples
    parts = min(_BLOCKS, max(_FEWEST_BLOCKS, int(track.periods)))
    edges = np.linspace(0, count, parts + 1).astype(np.int64)
    moments = []
    measured_rad = measured_rad - repeated_in_periods(measured_rad, track.phase, track.resolution_rad)
    for begin, end in itertools.pairwise(edges):
        number = np.arange(begin, end, dtype=np.float64)
        left = measured_rad[begin:end] - track.at(number) - bend_rad * _cubic(number, count)
        moments.append(float((number - 0.5 * (count - 1)) @ left))
    scatter = error_of_series(np.array(moments))
    slope = scatter.standard * parts / (count * (count**2 - 1.0) / 12.0)
    return MeanError(slope * (count - 1), min(scatter.dof, parts - 3.0))


def _half_of_bend(track: PhaseTrack, measured_rad: NDArray[np.float64]) -> float:
    """Return half of the phase, rad, from the first to the last row of a cubic course of the angle about its
    fit, where that is most of what it does; else 0.

    A swing of the rotor that is slower than the record has turned it by all of that, and an error of the
    sensor, as once in a revolution, by none: each is as likely, and half of it a standard deviation away.
    """
    number = np.arange(track.samples, dtype=np.float64)
    left = measured_rad - track.at(number)
    size = 7.0 * float(np.mean(_cubic(number, track.samples) * left))
    return size if size**2 / 7.0 > _MOSTLY * float(np.var(left)) else 0.0


def _cubic(number: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return Legendre's polynomial of third degree at sample numbers, shape (n,), of so many: it is -1 and 1
    at their ends, of mean square 1/7."""
    x = 2.0 * number / (count - 1.0) - 1.0
    return np.asarray(0.5 * x * (5.0 * x**2 - 3.0))


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
