"""Periods of a record: electrical periods of its angle or phase current, and revolutions."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from benchtool.analysis import PhaseTrack, standing, track_angle, track_tone
from benchtool.analysis.orders import angle_coverage, revolution_rows, unwrapped_angle
from benchtool.analysis.phase import PeriodMarks, marks_of_rotor, marks_of_tone
from benchtool.errors import AnalysisError
from benchtool.tables.record import Record
from benchtool.tables.regimes import regimes

_LARGEST_MEAN = 0.5  # of the largest sinusoid: beyond it the current is not that of a phase
_LEAST_SHARE = 0.1  # of the power of the ripple in the largest sinusoid
_ROTATING_FRAME = re.compile(r"(?<![a-z])i[\s_]*[dq]\b|\b[dq][\s_-]*(axis|current)", re.IGNORECASE)


@dataclass(frozen=True)
class Repetition:
    """What the rows of a record repeat: where periods begin, None where none are known, their kind,
    electrical periods, else revolutions, and how many make a revolution; 1 where that is not known."""

    marks: PeriodMarks | None = None
    kind: str = ""
    per_revolution: int = 1


@dataclass(frozen=True)
class Periods:
    """Electrical periods of a record with even time steps; `repetition` is of any record."""

    record: Record

    def of_phase_current(self) -> PhaseTrack:
        """Return the periods of the current, by the angle if possible, else by the current's own sinusoid.

        Raises:
            AnalysisError: the current is not a phase current, or neither angle nor current defines periods.
        """
        name = self.record.channels["current"].name
        if not self.record.question.is_of_phase and _ROTATING_FRAME.search(name):
            raise AnalysisError(
                f"'{name}' is by its name a current in rotating coordinates, which has no fundamental: if it "
                f"is that of a phase all the same, state --ac"
            )
        track = self._of_angle()
        if track is not None and (reason := self._contradiction(track)):
            raise AnalysisError(reason)
        if track is None:
            track = self._of_tone(name)
        if reason := self._not_ac(track):
            raise AnalysisError(reason)
        return track

    def repetition(self) -> Repetition:
        """Return what the rows repeat: electrical periods, else revolutions."""
        track = self._for_scatter() if self.record.uniform is not None else None
        if track is not None:
            if track.residual_rad is None:  # without an angle the machine may slip
                marks = marks_of_tone(self.record.column("current"), self.record.base.rate_Hz, track)
                return Repetition(marks, "electrical periods", 1)
            per_revolution = self.record.question.pole_pairs or 1
            return Repetition(marks_of_rotor(track), "electrical periods", per_revolution)
        if "angle" not in self.record.channels:
            return self._at_stated_speed()
        if self.record.angle_refusal:
            return Repetition()
        angle = self.record.channels["angle"].name
        try:
            coverage = angle_coverage(self.record.column("angle"), angle)
        except AnalysisError:
            return Repetition()
        in_rows = PeriodMarks(revolution_rows(coverage.angle_rad).astype(np.float64))
        marks = PeriodMarks.of_angle(coverage.angle_rad, 2.0 * math.pi) or in_rows
        return Repetition(marks, f"revolutions of {angle}")

    @property
    def hidden(self) -> str:
        """Why a current, an angle or a stated speed, which would tell periods, does not; empty for another
        reason."""
        if refusal := self.record.angle_refusal:
            return f"{refusal}, and tells no periods, whose scatter would tell it: choose a span without them"
        stated = self.record.question.omega_m_rad_s is not None
        if self.record.uniform is not None or not (stated or "current" in self.record.channels):
            return ""
        by = "the stated speed" if stated else "the current"
        return (
            f"{self.record.uneven}: {by} tells no periods of such rows, whose scatter would tell it; an "
            f"angle tells revolutions of any rows"
        )

    def _at_stated_speed(self) -> Repetition:
        """Return the periods at the constant speed that was stated, if there is one."""
        uniform, question = self.record.uniform, self.record.question
        if uniform is None or question.omega_m_rad_s is None:
            return Repetition()
        step_rad = question.omega_m_rad_s / uniform.sample_rate_Hz
        turn_rad = 2.0 * math.pi / (question.pole_pairs or 1)
        if abs(step_rad) > 0.5 * turn_rad:
            return Repetition()
        angle_rad = step_rad * np.arange(len(uniform.data), dtype=np.float64)
        kind = "electrical periods" if question.pole_pairs else "revolutions"
        marks = PeriodMarks(revolution_rows(angle_rad, turn_rad).astype(np.float64))
        return Repetition(marks, f"{kind} at the stated speed", question.pole_pairs or 1)

    def _of_angle(self) -> PhaseTrack | None:
        """Return the electrical periods from angle and pole pairs, where both are there.

        Raises:
            AnalysisError: the angle is in another unit or was lost, the speed is not steady, or the record
                too short or too slow.
        """
        pole_pairs = self.record.question.pole_pairs
        if "angle" not in self.record.channels or pole_pairs is None:
            return None
        if refusal := self.record.angle_refusal:
            raise AnalysisError(f"{refusal}: choose a span without them")
        name = self.record.channels["angle"].name
        track = track_angle(unwrapped_angle(self.record.column("angle"), name), pole_pairs, name)
        if track.periods > 0.5 * track.samples:
            raise AnalysisError(
                f"'{name}' has {track.periods:.4g} electrical periods in "
                f"{track.samples} rows, at least two rows for each are needed: check the angle's unit, and "
                f"the pole pairs"
            )
        return track

    def _for_scatter(self) -> PhaseTrack | None:
        """Return the electrical periods for uncertainties: of the angle, else of an ac current, else none."""
        try:
            track = self._of_angle()
        except AnalysisError:
            track = None
        if track is not None and not self._contradiction(track):
            return track
        return self._tone

    def _of_tone(self, name: str) -> PhaseTrack:
        """Return the current's own sinusoid.

        Raises:
            AnalysisError: it has none; of a direct current that is why.
        """
        samples = self.record.column("current")
        try:
            return track_tone(samples, name)
        except AnalysisError as refused:
            mean, deviation = float(np.mean(samples)), float(np.std(samples))
            if not abs(mean) > _LARGEST_MEAN * math.sqrt(2.0) * deviation:
                raise
            found = regimes(samples, "A")
            levels = f" in {found.levels} regimes" if found else ""
            raise AnalysisError(
                f"'{name}' has a mean of {mean:.3g} A and a ripple of {deviation:.3g} A rms: a direct current"
                f"{levels}, or one in rotating coordinates, has no fundamental"
            ) from refused

    @cached_property
    def _tone(self) -> PhaseTrack | None:
        """The current's own sinusoid, if it is that of a phase."""
        if "current" not in self.record.channels:
            return None
        try:
            track = track_tone(self.record.column("current"), self.record.channels["current"].name)
        except AnalysisError:
            return None
        return None if self._not_ac(track) else track

    def _contradiction(self, track: PhaseTrack) -> str:
        """Return contradiction of a track by the angle, a current with another frequency; empty if none."""
        channels = self.record.channels
        if "current" not in channels or self._share(track) >= _LEAST_SHARE or self._tone is None:
            return ""
        per_period_Hz = self.record.base.rate_Hz / (track.samples - 1)
        return (
            f"the largest sinusoid of '{channels['current'].name}' is at "
            f"{self._tone.periods * per_period_Hz:.4g} Hz, the angle with {self.record.question.pole_pairs} "
            f"pole pairs says {track.periods * per_period_Hz:.4g} Hz: check the angle's unit and the pole "
            f"pairs"
        )

    def _not_ac(self, track: PhaseTrack) -> str:
        """Return why this is not a phase current; empty if it is."""
        samples, amplitude, share = self.record.column("current"), self._amplitude(track), self._share(track)
        mean = float(np.mean(samples))
        # noise alone has a mean too, beside which the sinusoid found in it is small
        if share < _LEAST_SHARE and abs(mean) < float(np.std(samples)):
            return f"no sinusoid stands out, the largest has {100 * share:.2g} % of the ripple's power"
        if abs(mean) > _LARGEST_MEAN * amplitude:
            return standing(samples, "A") or (
                f"its mean is {abs(mean):.3g} A and its largest sinusoid {amplitude:.3g} A peak, that of a "
                f"phase current has a mean near zero: an offset can be taken off in the option, as ':A-0.2'; "
                f"dc and a current in rotating coordinates have no fundamental"
            )
        if share < _LEAST_SHARE:
            return f"no sinusoid stands out, the largest has {100 * share:.2g} % of the ripple's power"
        return ""

    def _share(self, track: PhaseTrack) -> float:
        """Return how much of the power of the current's ripple is in its sinusoid at the track's
        frequency."""
        deviation = float(np.std(self.record.column("current")))
        return 0.5 * (self._amplitude(track) / deviation) ** 2 if deviation > 0.0 else 0.0

    def _amplitude(self, track: PhaseTrack) -> float:
        """Return the amplitude of the current's sinusoid at the track's frequency, by correlation under a
        Hann window."""
        samples = self.record.column("current")
        window = np.hanning(len(samples))
        carrier = np.exp(-1j * track.at(np.arange(len(samples), dtype=np.float64)))
        about = samples - np.mean(samples)
        return float(2.0 * abs(np.sum(window * carrier * about)) / np.sum(window))
