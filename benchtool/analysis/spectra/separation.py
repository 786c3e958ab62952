"""A current taken apart along the phase of its fundamental: harmonics, what is between and beside them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    CoherentSpectrum,
    coherent_samples,
    harmonics,
    spectrum_of,
)
from benchtool.analysis.periods import PhaseTrack, track_tone
from benchtool.analysis.phase.phase_following import follow
from benchtool.analysis.phase.quick_swing import FEWEST_FORESEEN, quick_swing
from benchtool.analysis.phase.turned_phase import Turned, left_at_ends_rad
from benchtool.analysis.phase.wander import Wander, wander
from benchtool.analysis.spectra.close_lines import CloseLines, close_lines, moves_along
from benchtool.analysis.spectra.distortions import Beside
from benchtool.analysis.spectra.groups import HarmonicGroups, harmonic_groups
from benchtool.analysis.spectra.harmonics import HIGHEST_HARMONIC
from benchtool.analysis.spectra.interharmonics import (
    Interharmonics,
    between_harmonics,
    interharmonics,
    left_between,
    scatter_of_phases,
    together,
    without,
    without_modulation,
)
from benchtool.analysis.spectra.modulation import SteadyAmplitude, with_steady_amplitude
from benchtool.analysis.spectra.moving_tones import Course, course_of
from benchtool.analysis.spectra.swing_lines import may_be_swing, off_by_lines
from benchtool.errors import AnalysisError

Floats = NDArray[np.float64]

_LEFT_OF_JUMP = 0.25  # of a jump: what is left where lines or a decay made it
_NEAR = 4.0  # bins: within the main lobe of a Hann window, and as far again
_MORE = 2.0  # times the squares that are left along a phase that was followed
_OF_LINE_ALONE = 2.0  # times a line, by which it may put a phase off
_MAY_SWING = "lines about the fundamental that may be its swing within periods"
_ROUNDS = 3  # of a line beside the fundamental and its frequency without that


@dataclass(frozen=True)
class Separation:
    """A current along a track that follows its fundamental.

    `coherent` are the whole periods of the `samples`, shape (rows,), and `spectrum` is theirs; `seen` is how
    the fundamental moves about the `track`. `lines` is what is between the harmonics, and `others` that
    without the sidebands of what swings, None if there is nothing; `close` are the lines beside them.
    `turns`, shape (rows,), are the periods from the first of the spectrum to each row.
    """

    samples: Floats
    track: PhaseTrack
    seen: Wander
    coherent: CoherentSamples
    spectrum: CoherentSpectrum
    turns: Floats
    course: Course
    lines: Interharmonics | None
    others: Interharmonics | None
    close: CloseLines

    @property
    def by_signal(self) -> bool:
        """Whether the track is a fit to the signal itself, and no phase that was followed."""
        return self.track.residual_rad is None and self.track.departure is None

    @cached_property
    def taken(self) -> Interharmonics | None:
        """All that is no harmonic; None if there is nothing."""
        return together(self.others, self.close.lines)

    @property
    def places(self) -> Floats:
        """Where in the spectrum that is, in bins, shape (lines,); a dc that decays is at 0."""
        if self.taken is None:
            return np.empty(0)
        decay = [0.0] if self.taken.start else []
        return np.array([*decay, *self.taken.places, *(each.by_turns for each in self.taken.moving)])

    @property
    def pulls(self) -> bool:
        """Whether something of that is so near the fundamental that it pulls at the fit of its frequency."""
        near = (self.places > 0.0) & (np.abs(self.places - self.coherent.periods) < _NEAR)
        return bool(np.any(near))

    @cached_property
    def rest(self) -> Floats:
        """Samples without it, shape (rows,)."""
        if self.taken is None:
            return self.samples
        return self.samples - self.taken.at(self._of_rows)

    @cached_property
    def _of_rows(self) -> Course:
        """Where all rows are in the record."""
        passed = (np.arange(len(self.turns)) - FIRST_ROW) / self.coherent.samples
        return Course(self.turns / self.coherent.periods, passed)

    @cached_property
    def between(self) -> CoherentSamples:
        """The whole periods without what is between the harmonics."""
        return self.coherent if self.others is None else without(self.coherent, self.others, self.course)

    @cached_property
    def cleaned(self) -> CoherentSamples:
        """The whole periods without the lines beside harmonics either."""
        return (
            self.between if self.close.lines is None else without(self.between, self.close.lines, self.course)
        )

    @cached_property
    def alone(self) -> Wander:
        """How the fundamental moves about the track, without what is no harmonic."""
        if self.cleaned is self.coherent:
            return self.seen.first(self.coherent.periods)
        return wander(self.cleaned)

    @cached_property
    def moved(self) -> Wander:
        """How the fundamental moves about the track, without a jump of its phase that is gone with what is no
        harmonic: a dc that decays within a period, or a line in few of them, makes one."""
        alone, jump_rad = self.alone, self.seen.jump_rad
        if not jump_rad or self.taken is None or self.track.departure is not None or alone.jump_rad:
            return self.seen
        steps = np.diff(alone.phase_rad)
        if not len(steps) or np.max(np.abs(steps - np.median(steps))) > _LEFT_OF_JUMP * jump_rad:
            return self.seen
        return replace(self.seen, jump_rad=0.0, jumps_alone=False)

    @cached_property
    def steady(self) -> SteadyAmplitude:
        """The harmonics without the course of their amplitude."""
        return with_steady_amplitude(self.cleaned, self.alone.amplitude, self.turns, FIRST_ROW)

    @cached_property
    def whole(self) -> CoherentSamples:
        """The whole periods with all that is in them, without the course of their amplitude."""
        if self.steady.trend is None:
            return self.coherent
        return with_steady_amplitude(self.coherent, self.alone.amplitude, self.turns, FIRST_ROW).samples

    @cached_property
    def clean(self) -> CoherentSpectrum:
        """Their spectrum."""
        return spectrum_of(self.steady.samples)

    @cached_property
    def with_course(self) -> CoherentSpectrum:
        """Their spectrum with the course of their amplitude."""
        return self.clean if self.steady.trend is None else spectrum_of(self.cleaned)

    @cached_property
    def quiet(self) -> tuple[CoherentSamples, CoherentSpectrum]:
        """They and their spectrum without what stands out between them: sidebands of an amplitude that swings
        fast, say, are of the signal, and no noise."""
        found = interharmonics(self.clean, len(self.coherent.values))
        if found is None:
            return self.steady.samples, self.clean
        quiet = without(self.steady.samples, found, self.course)
        return quiet, spectrum_of(quiet)

    def over_record(self, rate_Hz: float, channel: str) -> tuple[Wander, float]:
        """Return how the fundamental moves about the track to both ends of the record, and the standard
        uncertainty of that by lines beside it, rad."""
        follows = self.by_signal or self.track.departure is not None
        if self.taken is None or not (follows or self.others is not None):
            return self.seen, self.close.turned_rad
        rest = wander(coherent_samples(self.rest, rate_Hz, self.track, channel, every=True))
        if self.by_signal:
            return rest, self.close.turned_rad
        return rest, math.hypot(self.close.turned_rad, left_at_ends_rad(rest))

    def within_periods(self, rate_Hz: float, channel: str, turned: Turned) -> Turned | None:
        """Return the phase over the record of a fundamental that swings within few of its periods, which is
        `turned` as means over periods tell it; None where it is not told, or these tell it as well.

        Of few periods, of which none foresees the next, and where no harmonic repeats them, lines are as
        likely lines of their own."""
        own = harmonics(self.clean)
        if not own[0] > 0.0:
            return None
        orders, sizes = self._lines_by_order(own)
        swings, alone = off_by_lines(orders, sizes, own / own[0], self.coherent.periods)
        may_swing = swings or may_be_swing(orders, sizes, self.coherent.periods)
        if not (self.track.follows_signal or may_swing):
            return None
        if may_swing and not (swings and self.coherent.periods >= FEWEST_FORESEEN):
            apart_rad = self._turned_with_lines() - turned.phase_rad
            return turned.halfway(_MAY_SWING, 0.5 * apart_rad, 0.5 * abs(apart_rad))
        track = replace(self.track, departure=None)
        # means over periods keep some of a dc that decays within few of them
        samples = self.samples if self.lines is None else self.samples - self.lines.decay(self._of_rows)
        coherent = coherent_samples(samples, rate_Hz, track, channel, every=True)
        swing = quick_swing(coherent, track, own)
        return None if swing is None else swing.turned(track, turned.standard, _OF_LINE_ALONE * alone)

    def _turned_with_lines(self) -> float:
        """Return the phase from the first to the last row of the fundamental and the lines about it."""
        periods, ends = self.coherent.periods, np.array([0, -1])
        turns, rows = self.turns[ends], np.arange(len(self.turns))[ends]
        phasor = np.full(2, self.clean.phasor[periods])
        if self.lines is not None:
            course = Course(self._of_rows.turned[ends], self._of_rows.passed[ends])
            places = np.array([*self.lines.places, *(each.by_turns for each in self.lines.moving)])
            about = np.abs(places - periods) < periods
            for line, is_about in zip(self.lines.components(course), about, strict=True):
                phasor += is_about * line * np.exp(-2j * np.pi * turns)
        along_rad = self.track.at(rows.astype(np.float64))
        return float(np.diff(along_rad)[0] + np.angle(phasor[1] * np.conj(phasor[0])))

    def _lines_by_order(self, own: Floats) -> tuple[Floats, Floats]:
        """Return where lines between the harmonics are, cycles in a period, and their amplitudes relative to
        the fundamental, both of shape (lines,)."""
        if self.lines is None:
            return np.empty(0), np.empty(0)
        moving = self.lines.moving
        cycles = np.array([*self.lines.places, *(each.by_turns + each.by_time for each in moving)])
        sizes = np.abs(np.array([*self.lines.phasors, *(each.phasor for each in moving)])) / own[0]
        return cycles / self.coherent.periods, sizes

    def beside(self, groups: HarmonicGroups | None) -> Beside | None:
        """Return what is in `groups` besides the harmonics; None where that is nothing, or moves otherwise
        than they do."""
        if groups is None:
            return None
        # steady sinusoids are as steady as the track, a decaying dc or a moving tone on any
        highest = 0.0 if self.taken is None else float(np.max(self.taken.places, initial=0.0))
        is_steady = self.track.departure is None or not moves_along(self.course, highest)
        is_like_them = self.taken is not None and is_steady
        steady = self.steady
        if self.close.lines is not None:  # which are in the groups of their harmonics
            steady = with_steady_amplitude(self.between, self.alone.amplitude, self.turns, FIRST_ROW)
        has_course = steady.trend is not None and not steady.trend.is_step
        if not (is_like_them or (self.others is None and has_course)):
            return None
        of_lines = harmonic_groups(steady.samples, HIGHEST_HARMONIC)
        if of_lines is None:
            return None
        scatter = (0.0, 0.0)
        if self.taken is not None:
            scatter = scatter_of_phases(self.clean, self.taken, groups, self.course)
        return Beside(self.between, of_lines, *scatter)


def separate(samples: Floats, rate_Hz: float, track: PhaseTrack, channel: str, step: float) -> Separation:
    """Return a current taken apart, of samples, shape (rows,), in steps of `step`, along a track.

    Lines near the fundamental pull at the fit of its frequency, which is made again without them, and so are
    they: a line is as wrong as the phase along which it was fitted, and what is left of it pulls again. Such
    rounds tend to the least squares of all together (RELAX: Li and Stoica, IEEE Trans. Signal Processing 44
    (1996) 281). What was followed meanwhile is then no course of the phase if it stays on the track without
    that, and far more is not left between the harmonics.

    Raises:
        AnalysisError: fewer than two electrical periods, or a fundamental beyond the band.
    """
    found = again = _along(samples, rate_Hz, track, channel, step)
    if track.residual_rad is not None:
        return found
    for number in range(_ROUNDS):
        # what is far off pulls at a fit under a window once, by what it leaks
        if again.taken is None or not (again.pulls or (again.by_signal and not number)):
            break
        try:
            without_lines = track_tone(again.rest, channel)
        except AnalysisError:  # what was taken out were no lines
            break
        again = _along(samples, rate_Hz, without_lines, channel, step)
    is_kept = again.by_signal and left_between(again.clean) < _MORE * left_between(found.clean)
    return again if is_kept else found


def _along(samples: Floats, rate_Hz: float, track: PhaseTrack, channel: str, step: float) -> Separation:
    coherent, track, seen = follow(samples, rate_Hz, track, channel)
    spectrum = spectrum_of(coherent)
    turns = track.turns_from(FIRST_ROW)
    course = course_of(turns, FIRST_ROW, coherent)
    lines = between_harmonics(coherent, spectrum, course)
    others = None if lines is None else without_modulation(lines, spectrum)
    clean = spectrum if others is None else spectrum_of(without(coherent, others, course))
    close = close_lines(clean, len(coherent.values), HIGHEST_HARMONIC, step, course)
    return Separation(samples, track, seen, coherent, spectrum, turns, course, lines, others, close)
