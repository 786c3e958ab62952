"""The phase of a tone compared with a track, and a track that follows the tone where they differ.

A spectrum over whole periods is only as accurate as its phase: a harmonic k of a phase that is off by x rad
rms reads low by k^2 x^2 / 2. The fundamental itself shows how far it is off, period by period.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy import fft
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    coherent_samples,
    rows_of,
    transformable_periods,
)
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.angle_following import OFF_RAD, along_angle, apart, within_periods
from benchtool.analysis.phase.continuation import FEWEST, continuation
from benchtool.analysis.phase.repetition import Repetition, repetition
from benchtool.analysis.phase.wander import Wander, wander

_LEFT_RAD = 3e-6  # rms: once followed, closer, because a period that is off by x reads its phase off by x / 2
_FAR_OFF_RAD = 0.05
_ROUNDS = 3
_ASIDE = 10  # share of the periods at either end that alone does not justify following
_BELOW_ORDER = 3
_OF_DC, _NEAR_DC = 2, 8  # bins that a dc which decays is in; part of the distance to the fundamental
_HIGHEST_BLURRED, _BLURRED, _FAR_BLUR = 25, 4, 4.0
_FAR_OFF_LINE = 10.0  # a ratio of powers
_OF_OTHER = 0.5  # of what amplitudes along another track differ by
_OF_LINES = 2.0  # times what is there by the median of bins
_ON_BOTH_SIDES = 0.02  # of the power about a line
_OF_RATIO = math.pi / math.sqrt(3.0)  # deviation of the logarithm of a ratio of two exponentials
_FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 16.0
_LONGEST_TURN = 0.45  # of a turn between periods: largest unambiguous change of phase


def follow(
    samples: NDArray[np.float64], sample_rate_Hz: float, track: PhaseTrack, name: str = "signal"
) -> tuple[CoherentSamples, PhaseTrack, Wander]:
    """Return signal at equal steps of phase, and the track: the one given, while the fundamental stays on it.

    Where it does not, by more than 2 mrad rms and more than noise explains, the track follows the measured
    angle, if the fundamental then stays closer, and after that the phase of the fundamental itself, without
    what its harmonics do not repeat, by a natural cubic spline through one phase in each period. So a speed
    that swings or drifts, and an angle that slips against the signal, leave the harmonics whole.
    Where the measured angle departs, and the fundamental does not follow that, the angle errs.

    Raises:
        AnalysisError: as `coherent_samples`.
    """

    def along(track: PhaseTrack) -> _Followed:
        coherent = coherent_samples(samples, sample_rate_Hz, track, name, every=True)
        return _Followed(coherent, track, wander(coherent))

    smooth = along(track)
    angle = along_angle(track, smooth.coherent.samples / smooth.coherent.periods)
    found = smooth
    if angle.of_periods is not None:
        by_angle = along(angle.of_periods)
        found = by_angle if by_angle.is_closer_than(smooth) else smooth
    jump_rad, jumps_alone = found.seen.jump_rad, found.seen.jumps_alone
    by_tone = _followed(samples, sample_rate_Hz, found, name)
    if found is not smooth and max(found.seen.excess_rad, angle.within_rad) > OFF_RAD:
        # the angle has errors of its own, which may be faster than the phase of a period shows
        by_tone = min(
            by_tone, _followed(samples, sample_rate_Hz, smooth, name), key=lambda each: each.off_line
        )
    doubt = np.empty(0)
    if angle.within is not None:  # by what both have in common, such as a slip
        by_angle = _followed(samples, sample_rate_Hz, along(angle.within), name)
        if by_tone.track is track and by_angle.track.follows_signal:
            by_angle = by_tone  # the fundamental stays on the track: what does not is an error of the angle
        better = by_angle
        if by_angle.is_clearly(other_than=by_tone):
            better = by_angle.if_clearly_better_than(by_tone)
        elif by_angle is not by_tone:
            within, sharper = within_periods(by_tone.phasors, by_angle.phasors), by_angle.is_sharper(by_tone)
            are_of_rotor = within.are_of_rotor if sharper is None else sharper
            better, doubt = by_angle if are_of_rotor else by_tone, within.standard
        if by_angle is not by_tone and better.has_sidebands and not by_angle.is_far_from(by_tone):
            # the current of a load that swings has a phase of its own, which is nearer to either by chance
            doubt = _OF_OTHER * apart(by_tone.phasors, by_angle.phasors)
        by_tone = better
    seen = replace(
        by_tone.seen,
        excess_rad=by_tone.excess_rad,
        jump_rad=jump_rad,
        jumps_alone=jumps_alone,
        by_angle=track.residual_rad is not None,
        of_angle=doubt,
        undecided_rad=by_tone.undecided_rad,
    )
    return by_tone.transformable, by_tone.track, seen


@dataclass(frozen=True)
class _Followed:
    """A signal along a track, and how it moves about it."""

    coherent: CoherentSamples
    track: PhaseTrack
    seen: Wander

    @cached_property
    def by_harmonics(self) -> Repetition | None:
        return repetition(self.coherent)

    @property
    def excess_rad(self) -> float:
        return max(self.seen.excess_rad, 0.0 if self.by_harmonics is None else self.by_harmonics.motion_rad)

    @property
    def undecided_rad(self) -> float:
        return 0.0 if self.by_harmonics is None else self.by_harmonics.undecided_rad

    @property
    def turns(self) -> NDArray[np.float64]:
        """Where the `phase_rad` are, in periods, both of shape (phases,)."""
        periods = np.arange(self.coherent.periods, dtype=np.float64)
        return periods + 0.5 if self.by_harmonics is None else periods[1:]

    @property
    def phase_rad(self) -> NDArray[np.float64]:
        """How the phase moves, without a line beside the fundamental, where that can be told."""
        return self.seen.phase_rad if self.by_harmonics is None else self.by_harmonics.phase_rad

    @property
    def off_rad(self) -> float:
        return float(np.std(self.phase_rad))

    @cached_property
    def transformable(self) -> CoherentSamples:
        """The signal over as many periods as are transformed quickly."""
        periods = transformable_periods(self.coherent.periods)
        values = self.coherent.values[: periods * self.coherent.per_period]
        return replace(self.coherent, values=values, periods=periods, samples=rows_of(self.track, periods))

    @cached_property
    def _bins(self) -> NDArray[np.complex128]:
        return fft.rfft(self.transformable.values)

    @property
    def phasors(self) -> NDArray[np.complex128]:
        """Peak phasors of harmonics 1, 2, 3 ..., as of phase zero of the track, shape (harmonics,)."""
        lines = self._bins[:: self.transformable.periods][1:] * (2.0 / len(self.transformable.values))
        begin_rad = float(self.track.at(np.array([float(FIRST_ROW)]))[0])
        return np.asarray(lines * np.exp(-1j * begin_rad * np.arange(1, len(lines) + 1)))

    @cached_property
    def _squares(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Squares of the harmonics, from dc on, and of all bins without those."""
        square = np.abs(self._bins) ** 2
        lines = square[:: self.transformable.periods].copy()
        square[:: self.transformable.periods] = 0.0
        return lines, square

    @cached_property
    def off_line(self) -> float:
        """Power between the harmonics below the third, where a phase that is off moves that of the
        fundamental, however fast: without that near dc, and the leakage of a line from the first period's
        mean to the last one's, which a dc that decays has."""
        coherent, periods = self.transformable, self.transformable.periods
        means = np.mean(coherent.values.reshape(periods, -1)[[0, -1]], axis=1)
        rise = float(means[1] - means[0]) * periods / max(1, periods - 1)
        number = self._below
        # of a line that rises by one over n samples the bins are (-1 + j cot(pi k / n)) / 2
        leaked = 0.5 * rise * (-1.0 + 1j / np.tan(np.pi * number / len(coherent.values)))
        return float(np.sum(np.abs(self._bins[number] - leaked) ** 2))

    @cached_property
    def _below(self) -> NDArray[np.int64]:
        """The numbers of the bins between the harmonics below the third."""
        periods = self.transformable.periods
        above = min(_BELOW_ORDER * periods, len(self._bins))
        number = np.arange(max(_OF_DC, periods // _NEAR_DC), above)
        return number[number % periods > 0]

    @property
    def has_lines(self) -> bool:
        """Whether what is left there is in fewer bins than noise is."""
        square = self._squares[1][self._below]
        return bool(len(square)) and self.off_line > _OF_LINES * _as_noise(square)

    @property
    def has_sidebands(self) -> bool:
        """Whether lines stand out to both sides of the fundamental, as far from it: its load swings."""
        periods, square = self.transformable.periods, self._squares[1]
        distance = np.arange(_OF_DC, periods - _OF_DC)
        if not len(distance) or 2 * periods > len(square):
            return False
        lower, upper = square[periods - distance], square[periods + distance]
        noise = 0.5 * _as_noise(np.append(lower, upper))
        both = float(np.sum(np.minimum(lower, upper)))
        return both > max(_FAR_OFF_LINE * noise, _ON_BOTH_SIDES * float(np.sum(lower + upper)))

    def is_clearly(self, *, other_than: _Followed) -> bool:
        """Return whether it has more or less between the harmonics than the other, beyond chance, and that is
        in lines: noise of an angle, which one of them follows more closely, is in all bins."""
        ratio = self.off_line / other_than.off_line if other_than.off_line > 0.0 else 1.0
        least = _FAR_BLUR / math.sqrt(_BELOW_ORDER * self.transformable.periods)
        worse = max(self, other_than, key=lambda each: each.off_line)
        is_told = worse.has_lines or self.is_far_from(other_than)
        return is_told and abs(math.log(max(ratio, 1e-300))) > least

    def if_clearly_better_than(self, other: _Followed) -> _Followed:
        return self if self.off_line < other.off_line and self.is_clearly(other_than=other) else other

    def is_closer_than(self, other: _Followed) -> bool:
        """Return whether less is between the harmonics than of the other: of the whole band, or where that
        may be chance, or the lowest part differs by far, of that."""
        sharper = None if self.is_far_from(other) else self.is_sharper(other)
        return self.off_line < other.off_line if sharper is None else sharper

    def is_far_from(self, other: _Followed) -> bool:
        """Return whether one of both has so much less between the lowest harmonics that no noise makes it: a
        swing that one does not follow."""
        least, most = sorted((self.off_line, other.off_line))
        return most > _FAR_OFF_LINE * least

    def is_sharper(self, other: _Followed) -> bool | None:
        """Return whether it has less between the harmonics than the other, from the third on, bin by bin of
        the whole band; None where that may be chance.

        What an angle does that is another from period to period blurs harmonics that do not follow it, the
        high ones most, if it is the rotor's, and those that do if it is an error.
        """
        periods = self.transformable.periods
        last = math.floor(periods * min(each.transformable.usable_order for each in (self, other)))
        number = np.arange(_BELOW_ORDER * periods, last + 1)
        number = number[number % periods > 0]
        if periods != other.transformable.periods or not len(number):
            return None
        own, others = (each._squares[1][number] / len(each._bins) ** 2 for each in (self, other))
        if not (np.all(own > 0.0) and np.all(others > 0.0)):
            return None
        ratio = float(np.mean(np.log(own / others)))
        return ratio < 0.0 if abs(ratio) > _FAR_BLUR * _OF_RATIO / math.sqrt(len(number)) else None

    def blurs(self, before: _Followed) -> bool:
        """Return whether the harmonics have more sidebands than before, beyond chance.

        A line beside the fundamental alone moves its phase, and no speed.
        """
        periods, (lines, square) = self.transformable.periods, self._squares
        highest = min(_HIGHEST_BLURRED, len(lines) - 2)
        if highest <= _BELOW_ORDER or periods != before.transformable.periods:
            return False
        strongest = _BELOW_ORDER + 1 + np.argsort(-lines[_BELOW_ORDER + 1 : highest + 1])[:_BLURRED]
        around = np.arange(-(periods // 2), periods // 2 + 1)
        bins = (periods * strongest[:, np.newaxis] + around).ravel()
        now, then = float(np.sum(square[bins])), float(np.sum(before._squares[1][bins]))
        return now > (1.0 + _FAR_BLUR / math.sqrt(len(bins))) * then


def _as_noise(square: NDArray[np.float64]) -> float:
    """Return the sum of the squares of bins, shape (bins,), by their median: of noise alone it is theirs."""
    return float(np.median(square)) / math.log(2.0) * len(square)


def _followed(samples: NDArray[np.float64], sample_rate_Hz: float, begin: _Followed, name: str) -> _Followed:
    """Return signal along the phase of its own fundamental, as long as that brings it closer."""
    found, before_rad = begin, 0.0
    for least_rad in (OFF_RAD, *(_ROUNDS - 1) * (_LEFT_RAD,)):
        # so far off, what harmonics repeat was told only about: the next time is due
        excess_rad = max(found.excess_rad, found.off_rad if before_rad > _FAR_OFF_RAD else 0.0)
        by_tone = _by_tone(found, name, least_rad) if least_rad < excess_rad < math.inf else None
        if by_tone is None:
            break
        coherent = coherent_samples(samples, sample_rate_Hz, by_tone, name, every=True)
        other = _Followed(coherent, by_tone, wander(coherent))
        if not other.off_rad < found.off_rad or other.blurs(found):
            break
        if not other.is_far_from(found) and found.is_sharper(other):
            break
        found, before_rad = other, found.off_rad
    return found


def _by_tone(found: _Followed, name: str, least_rad: float) -> PhaseTrack | None:
    """Return track along the fundamental's own phase; None if it does not deviate, or by too much."""
    track = found.track
    largest_step = float(np.max(np.abs(np.diff(found.seen.phase_rad)), initial=0.0))
    if largest_step > 2 * np.pi * _LONGEST_TURN:
        return None
    # a transient that decays soon after the beginning moves the phase only there
    phase_rad = _without_alternation(found.phase_rad - np.mean(found.phase_rad))
    aside = len(phase_rad) // _ASIDE
    inner = phase_rad[aside : len(phase_rad) - aside]
    if len(phase_rad) < FEWEST or not float(np.std(inner)) > least_rad:
        return None
    begin = float(track.at(np.array([float(FIRST_ROW)]))[0])
    numbers = track.sample_numbers(begin + 2 * np.pi * found.turns)
    from scipy.interpolate import CubicSpline  # draws in scipy.optimize, as above

    # the polynomial takes a drift, whose bend a natural spline does not have at its ends
    drift = Polynomial.fit(numbers, phase_rad, 2)
    spline = CubicSpline(*_extended(numbers, phase_rad - drift(numbers)), bc_type="natural")
    before = track.departure
    added = "" if track.follows_signal else f", followed by the phase of {name} itself"

    def departure(at: NDArray[np.float64]) -> NDArray[np.float64]:
        own = np.asarray(spline(at) + drift(at), dtype=np.float64)
        return own if before is None else own + before(at)

    told_to = FIRST_ROW + rows_of(track, found.coherent.periods)
    source = f"{track.source}{added}"
    return replace(track, departure=departure, source=source, follows_signal=True, told_to=told_to)


def _extended(
    numbers: NDArray[np.float64], phase_rad: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return sample numbers and phases, both of shape (periods,), continued at either end: a natural spline
    is straight at its ends, which are then beyond the record."""
    going_on = continuation(phase_rad, closer=True)
    steps = np.arange(1.0, going_on.reach + 1.0)
    weights = np.array([going_on.weights(by) for by in steps])
    before, after = weights @ phase_rad[: going_on.size][::-1], weights @ phase_rad[-going_on.size :]
    return (
        np.concatenate(
            [
                numbers[0] - (numbers[1] - numbers[0]) * steps[::-1],
                numbers,
                numbers[-1] + (numbers[-1] - numbers[-2]) * steps,
            ]
        ),
        np.concatenate([before[::-1], phase_rad, after]),
    )


def _without_alternation(phase_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return phases, shape (periods,), without what is up in one period and down in the next: a line halfway
    between harmonics, and no wander of the phase, makes that.

    Fourth differences over sixteen leave that as it is, and take away nearly all that is smooth.
    """
    if len(phase_rad) < len(_FOURTH_DIFFERENCE):
        return phase_rad
    fourth = np.convolve(phase_rad, _FOURTH_DIFFERENCE, mode="valid")
    signs = np.where(np.arange(len(phase_rad)) % 2, -1.0, 1.0)
    return np.asarray(phase_rad - signs * float(np.mean(signs[2:-2] * fourth)), dtype=np.float64)
