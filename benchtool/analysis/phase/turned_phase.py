"""Phase of a tone from the first to the last row of a window, with its budget."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import FIRST_ROW, CoherentSpectrum, rows_of
from benchtool.analysis.lines.course import repeated_in_turns
from benchtool.analysis.noise.converter_lines import aliased_quantisation
from benchtool.analysis.noise.noise_of_lines import hann_quadrature, line_noise
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.continuation import FEWEST, continuation
from benchtool.analysis.phase.followed_swing import off_swing_rad
from benchtool.analysis.phase.settling_phase import settling_phase
from benchtool.analysis.phase.wander import Wander
from benchtool.analysis.statistics.scatter import MeanError
from benchtool.analysis.uncertainty import Contribution

_HANN_FIT = math.sqrt(54.463)
"""Standard uncertainty of a frequency by the fit of `track_tone`, in units of that of the mean phase over
the duration: root of int w^4 t^2 dt / (int w^2 t^2 dt)^2, w = cos^2(pi t), t from -1/2 to 1/2; unweighted it
is sqrt(12)."""

_OF_FOLDED = 0.6 / math.sqrt(2.0)  # cycles over the record, of a line a bin away, of any phase
_LEAKS = 4.0  # times the power under a Hann window: what the rectangular one leaks, beyond chance
_AT_ENDS = 4  # periods
_AGREE = 3.0  # standard uncertainties of a difference
# of a bend: a mean over a period is a 24th off its middle, and half of that is left
_WITHIN = 1.0 / 48.0


@dataclass(frozen=True)
class Turned:
    """Phase from the first to the last row, rad, its budget, rad, and in words what that is from."""

    phase_rad: float
    budget: tuple[Contribution, ...]
    source: str

    @property
    def standard(self) -> float:
        """The standard uncertainty, rad."""
        return math.hypot(*(each.standard for each in self.budget))

    def with_other(self, other: Turned) -> Turned:
        """Return the mean of this and another measurement of it, weighted by their variances; this alone
        where they differ by more than chance."""
        apart_rad, both = other.phase_rad - self.phase_rad, math.hypot(self.standard, other.standard)
        if not abs(apart_rad) < _AGREE * both < math.inf:
            return self
        share = (self.standard / both) ** 2
        budget = [replace(each, standard=(1.0 - share) * each.standard) for each in self.budget]
        budget += [replace(each, standard=share * each.standard) for each in other.budget]
        return Turned(self.phase_rad + share * apart_rad, tuple(budget), f"{self.source}, and {other.source}")

    def with_either(self, other: Turned, excess_rad: float) -> Turned:
        """Return the mean of both as of `with_other`; halfway between them where they differ by more than
        chance, or one moves about the other by an excess, rms, beyond noise: each is as likely wrong.

        From one end to the other that excess is sqrt(2) times as much.
        """
        apart_rad, both = other.phase_rad - self.phase_rad, math.hypot(self.standard, other.standard)
        size_rad = 0.5 * max(abs(apart_rad), math.sqrt(2.0) * excess_rad)
        agree = abs(apart_rad) < _AGREE * both and not (excess_rad and size_rad > self.standard)
        if agree or not math.isfinite(both):
            return self.with_other(other)
        return self.halfway("departure of the signal from the angle", 0.5 * apart_rad, size_rad)

    def halfway(self, name: str, half_rad: float, size_rad: float) -> Turned:
        """Return it with half of a phase that is as likely part of it as not, `size_rad` uncertain by that,
        which is the `name`."""
        source = f"{self.source}, and {name}"
        return Turned(self.phase_rad + half_rad, (*self.budget, Contribution(name, "B", size_rad)), source)


def turned_by_tone(
    spectrum: CoherentSpectrum, track: PhaseTrack, seen: Wander, step: float, beside_rad: float
) -> Turned:
    """Return the phase of a tone in a signal with steps of `step`, tracked along its own phase or an angle;
    `beside_rad` is what a line beside it leaves open."""
    beside = Contribution("a line beside the fundamental", "B", beside_rad)
    moves = track.measured_rad is not None or seen.excess_rad > 0.0
    if track.departure is not None or (moves and len(seen.phase_rad) >= FEWEST):
        # in the phase of both ends is what is too little to be followed for the amplitudes, but no noise, and
        # what the sensor of an angle makes of a track along that
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
    turned_rad = 2.0 * math.pi * track.periods
    if seen.is_doubted and len(seen.phase_rad) >= FEWEST:  # halfway between a steady speed and what is seen
        half_rad = 0.5 * (_to_both_ends(track, seen)[0] - turned_rad)
        lines.append(Contribution("a change of the speed that noise may hide", "B", abs(half_rad)))
        turned_rad += half_rad
    return Turned(turned_rad, (*lines, beside), source)


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
    What a bend within a period does to its phase is alike at both ends, but for how the bend varies. A track
    that follows is a cubic spline, through one phase in each period.
    """
    marks = middles_of_periods(track, seen)
    per_period = float(marks[1] - marks[0])
    alike_rad = _alike_in_periods(track)
    rows = np.arange(track.samples, dtype=np.float64)
    phase_rad = track.at(marks) + seen.phase_rad - np.interp(marks, rows, alike_rad)
    middle = float(np.mean(seen.amplitude))
    going_on = continuation(phase_rad, seen.amplitude / middle if middle > 0.0 else None)
    if track.follows_signal:
        within_rad = off_swing_rad(phase_rad)
    else:
        within_rad = _WITHIN * float(np.std(np.diff(phase_rad, n=2)))
    before, after = (rows / per_period for rows in (float(marks[0]), track.samples - 1.0 - float(marks[-1])))
    left2 = seen.noise_rad**2
    if track.departure is not None:
        left2 = _shared2(seen.phase_rad - np.mean(seen.phase_rad))
    of_phases2 = 2.0 * (left2 + within_rad**2)
    noise2 = max(going_on.noise2, seen.noise_rad**2)
    settling = settling_phase(phase_rad, noise2, are_means=track.departure is None)
    of_angle_rad = float(alike_rad[-1] - alike_rad[0])
    if settling is not None:  # it bends most where a polynomial begins
        turned_rad, error2 = settling.turned(before, after)
        return turned_rad + of_angle_rad, math.sqrt(of_phases2 + error2)
    ends_rad = [
        float(going_on.weights(by) @ phases[-going_on.size :])
        for by, phases in ((before, phase_rad[::-1]), (after, phase_rad))
    ]
    error2 = going_on.error2(before) + going_on.error2(after)
    return ends_rad[1] - ends_rad[0] + of_angle_rad, math.sqrt(of_phases2 + error2)


def _alike_in_periods(track: PhaseTrack) -> NDArray[np.float64]:
    """Return what a track that follows an angle does in every period alike, shape (samples,): phases of
    periods show nothing of it, and no continuation of them has it."""
    if track.measured_rad is None or track.departure is None:
        return np.zeros(track.samples)
    rows = np.arange(track.samples, dtype=np.float64)
    smooth_rad = np.asarray(track.phase(rows))
    turns = (smooth_rad - smooth_rad[0]) / (2.0 * math.pi)
    departure_rad = track.departure(rows)
    # a bend of the whole course is no shape within a period: it is gone with the mean of one about each row
    inner = (turns >= 0.5) & (turns <= turns[-1] - 0.5)
    if not np.any(inner):
        return np.zeros(track.samples)
    begin, end = (np.interp(turns[inner] + side, turns, rows) for side in (-0.5, 0.5))
    sums = np.concatenate([[0.0], np.cumsum(departure_rad)])
    edges = np.arange(len(sums)) - 0.5
    of_period_rad = (np.interp(end, edges, sums) - np.interp(begin, edges, sums)) / (end - begin)
    within_rad = repeated_in_turns(departure_rad[inner] - of_period_rad, turns[inner] - turns[inner][0])
    return np.asarray(np.interp(turns, turns[inner], within_rad.values, period=1.0))


def middles_of_periods(track: PhaseTrack, seen: Wander) -> NDArray[np.float64]:
    """Return the middles of all whole periods, in rows, as of a constant speed."""
    count = len(seen.phase_rad)
    return FIRST_ROW + rows_of(track, count) / count * (np.arange(count, dtype=np.float64) + 0.5)
