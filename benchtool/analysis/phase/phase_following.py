"""The phase of a tone compared with a track, and a track that follows the tone where they differ.

A spectrum over whole periods is only as accurate as its phase: a harmonic k of a phase that is off by x rad
rms reads low by k^2 x^2 / 2. The fundamental itself shows how far it is off, period by period.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
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
from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.angle_following import OFF_RAD, along_angle, within_periods
from benchtool.analysis.phase.continuation import FEWEST, continuation
from benchtool.analysis.phase.repetition import Repetition, repetition

_LEFT_RAD = 3e-6  # rms: once followed, closer, because a period that is off by x reads its phase off by x / 2
_FAR_OFF_RAD = 0.05
_BY_CHANCE, _DOUBTED = 1e-4, 0.05
_FEWEST_AT_SIDE = 3
_FEWEST_PERIODS = 4  # and so many phases, from which a wander is told from noise
_FEWEST_ABOUT_A_LINE = 6  # amplitudes: of fewer a line takes along most of their noise
_BEYOND = 3  # periods: to where an end of the record may be, and one to spare
_ROUNDS = 3
_ASIDE = 10  # share of the periods at either end that alone does not justify following
_MEDIAN_DEVIATION = 0.6745  # median of the magnitude of a normal deviate
_FAR = 8.0  # standard deviations; the largest step of a swing or of a drift is within two
_LEAST_JUMP_RAD = 0.03  # a reversal may by chance leave any phase, half of it in one step
_BELOW_ORDER = 3
_OF_DC, _NEAR_DC = 2, 8  # bins that a dc which decays is in; part of the distance to the fundamental
_HIGHEST_BLURRED, _BLURRED, _FAR_BLUR = 25, 4, 4.0
_OF_RATIO = math.pi / math.sqrt(3.0)  # deviation of the logarithm of a ratio of two exponentials
_FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 16.0
_STEADY, _SLOWEST = 2, 4  # terms of a steady rise, and of the courses beside it that are looked at
_OF_NOISE = 0.35  # relative deviation of amplitudes, which of noise alone have Rayleigh's, 0.52
_UNRELATED, _MOST_OF_NOISE = 2.5, 0.5  # standard deviations of a correlation; the most of few periods
_MOST_TURNED_RAD, _MOST_BENT_RAD = 0.3, 0.2  # in a period beside the track: more is noise, or a jump
_LONGEST_TURN = 0.45  # of a turn between periods: largest unambiguous change of phase


@dataclass(frozen=True)
class Wander:
    """How the fundamental moves about a track: `phase_rad`, without jumps, and `amplitude`, shape (periods,).

    `excess_rad` is the rms deviation of the phase from its mean beyond what noise does, which moves amplitude
    and phase alike, or that the harmonics repeat; 0 where it may be noise, or there is nothing but noise.
    `undecided_rad` is as much as they may repeat besides. `noise_rad` is what noise does to one period's
    phase. `jump_rad` is the largest change of phase from period to period where it stands out of all others,
    else 0: no smooth track explains it. `jumps_alone` says that amplitude and frequency are the same on both
    sides of it, `by_angle` that the track is that of an angle. `of_angle`, shape (harmonics,), is the
    standard uncertainty of each amplitude by what a measured angle does in every period alike, which may be
    the rotor's or an error of its sensor; empty where there is no such doubt. The phase `is_doubted`
    where there is no excess, but noise alone does as much once in twenty records at most.
    """

    phase_rad: NDArray[np.float64]
    amplitude: NDArray[np.float64]
    excess_rad: float
    noise_rad: float
    jump_rad: float = 0.0
    jumps_alone: bool = False
    by_angle: bool = False
    of_angle: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    undecided_rad: float = 0.0
    is_doubted: bool = False

    def first(self, periods: int) -> Wander:
        """Return that of so many periods."""
        return replace(self, phase_rad=self.phase_rad[:periods], amplitude=self.amplitude[:periods])


def wander(coherent: CoherentSamples) -> Wander:
    """Return the phase and amplitude of the fundamental in each period."""
    table = coherent.values.reshape(coherent.periods, coherent.per_period)
    turn = np.exp(-2j * np.pi / coherent.per_period * np.arange(coherent.per_period))
    phasor = (table @ turn.real + 1j * (table @ turn.imag)) * (2.0 / coherent.per_period)
    if coherent.periods > 2:
        # a ramp of d per period under the signal, as of a decaying dc, reads j d / pi
        phasor -= 1j / np.pi * np.gradient(np.mean(table, axis=1))
        phasor = _in_the_middle(phasor, coherent.per_period)
    amplitude = np.abs(phasor)
    steps = np.angle(phasor[1:] * np.conj(phasor[:-1]))
    phase_rad = np.angle(phasor[0]) + np.concatenate(([0.0], np.cumsum(steps)))
    middle = float(np.mean(amplitude))
    if not middle > 0.0:
        return Wander(phase_rad, amplitude, math.inf, math.inf)
    of_phase, of_amplitude = float(np.var(phase_rad)), float(np.var(amplitude)) / middle**2
    if of_amplitude > _OF_NOISE**2 and _are_unrelated(phasor):
        return Wander(phase_rad, amplitude, 0.0, math.sqrt(of_amplitude))
    excess, by_chance = 0.0, 1.0
    if len(phasor) >= _FEWEST_PERIODS:
        if len(phasor) >= _FEWEST_ABOUT_A_LINE:
            of_amplitude = _about_a_line(amplitude) / middle**2
        by_chance = _by_chance(phase_rad, of_amplitude) if of_phase > of_amplitude else 1.0
        excess = math.sqrt(of_phase - of_amplitude) if by_chance < _BY_CHANCE else 0.0
    jump_rad = _jump_rad(steps)
    return Wander(
        phase_rad,
        amplitude,
        excess,
        math.sqrt(of_amplitude),
        jump_rad,
        jump_rad > 0.0 and _jumps_alone(steps, amplitude),
        is_doubted=_BY_CHANCE <= by_chance < _DOUBTED,
    )


def _in_the_middle(phasor: NDArray[np.complex128], size: int) -> NDArray[np.complex128]:
    """Return phasors of periods of so many samples, shape (periods,), in their middles and without the image
    at the negative frequency: where a tone turns by x more in a period its sum over n of exp(-2j (2 pi n /
    size)) n / size is not zero, but x (cot(2 pi / size) + j) / (2 size), about x / (4 pi), of its conjugate.
    """
    turned_rad = np.gradient(np.unwrap(np.angle(phasor)), edge_order=2)
    most_rad, bent_rad = (float(np.max(np.abs(each))) for each in (turned_rad, np.diff(turned_rad)))
    if not (most_rad < _MOST_TURNED_RAD and bent_rad < _MOST_BENT_RAD):
        return phasor
    image = 0.5 / size * (1.0 / math.tan(2.0 * math.pi / size) + 1j)
    return np.asarray(phasor * np.exp(0.5j / size * turned_rad) - image * turned_rad * np.conj(phasor))


def _by_chance(phase_rad: NDArray[np.float64], of_amplitude: float) -> float:
    """Return the probability with which noise that does `of_amplitude` to amplitudes, the relative variance
    of as many about a line, does as much to phases, shape (n,): to all of them, or to the slowest of their
    courses, in which a speed that settles or drifts is."""
    if not of_amplitude > 0.0:
        return 0.0
    freedom, slow = len(phase_rad) - 1, _slowest(phase_rad)
    of_all = fisher_above(freedom, freedom - 1.0, float(np.var(phase_rad)) / of_amplitude)
    return min(of_all, fisher_above(len(slow), freedom - 1.0, float(np.mean(slow**2)) / of_amplitude))


def _about_a_line(values: NDArray[np.float64]) -> float:
    """Return the variance that noise has of which values, shape (n,), deviate as much from a line: a load
    that rises moves the amplitude, and is no noise of the phase."""
    count, line = len(values), Polynomial.fit(np.arange(len(values)), values, 1)
    rest = values - line(np.arange(count))
    return float(rest @ rest) / (count - 2.0) * (count - 1.0) / count


def _slowest(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the sizes of the slowest courses in values, shape (n,), but for a steady rise, each with the
    variance of these where they are white: those of a polynomial, from its square on."""
    degrees = min(_STEADY + _SLOWEST, len(values) - 1)
    place = np.linspace(-1.0, 1.0, len(values))
    basis = np.linalg.qr(np.polynomial.legendre.legvander(place, degrees - 1))[0]
    return np.asarray(values @ basis[:, _STEADY:])


def _are_unrelated(phasor: NDArray[np.complex128]) -> bool:
    """Return whether the phasors of periods, shape (periods,), are correlated no more than noise alone is."""
    correlation = abs(complex(np.sum(phasor[1:] * np.conj(phasor[:-1])))) / float(np.sum(np.abs(phasor) ** 2))
    return correlation < min(_UNRELATED / math.sqrt(len(phasor)), _MOST_OF_NOISE)


def _jump_rad(steps: NDArray[np.float64]) -> float:
    """Return the largest step of the phase less the median step, if far beyond the scatter of the others."""
    if len(steps) + 1 < _FEWEST_PERIODS:
        return 0.0
    away = np.abs(steps - np.median(steps))
    largest, usual = float(np.max(away)), float(np.median(away)) / _MEDIAN_DEVIATION
    return largest if largest > max(_LEAST_JUMP_RAD, _FAR * usual) else 0.0


def _jumps_alone(steps: NDArray[np.float64], amplitude: NDArray[np.float64]) -> bool:
    """Return whether the fundamental is the same on both sides of its largest step, but for the step.

    Mean amplitudes and frequencies may differ by what they scatter, as of differences of two means, and by a
    hundredth of the amplitude, a tenth of the step over the periods on one side. A period with a jump in its
    middle shows half of it in either step, and its cosine in the amplitude; one in which the machine stood
    still has less.
    """
    at = int(np.argmax(np.abs(steps - np.median(steps))))
    sides = [slice(0, max(0, at - 1)), slice(at + 2, None)]
    parts = [(steps[side], amplitude[side]) for side in sides]
    if min(len(each) for each, _ in parts) < _FEWEST_AT_SIDE:
        return False
    jump_rad = float(steps[at] - np.median(steps))
    (before, low), (after, high) = parts
    middle = float(np.median(amplitude))
    turned_rad = abs(float(np.median(after) - np.median(before))) * min(len(before), len(after))
    is_through = float(np.min(amplitude[max(0, at - 1) : at + 3])) > 0.98 * middle * math.cos(
        min(abs(jump_rad), 0.5 * math.pi)
    )
    change = abs(float(np.mean(high) - np.mean(low)))
    scatter = math.hypot(*(float(np.std(each)) / math.sqrt(len(each)) for each in (low, high)))
    return (
        is_through
        and change < max(3.0 * scatter, 0.01 * middle)
        and (turned_rad < max(3.0 * _scatter_of_phase(before, after), 0.1 * abs(jump_rad)))
    )


def _scatter_of_phase(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    return math.hypot(float(np.std(before)), float(np.std(after))) * math.sqrt(min(len(before), len(after)))


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
        if by_angle.is_clearly(other_than=by_tone):
            by_tone = by_angle.if_clearly_better_than(by_tone)
        elif by_angle is not by_tone:
            within, sharper = within_periods(by_tone.phasors, by_angle.phasors), by_angle.is_sharper(by_tone)
            are_of_rotor = within.are_of_rotor if sharper is None else sharper
            by_tone, doubt = by_angle if are_of_rotor else by_tone, within.standard
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
        number = np.arange(max(_OF_DC, periods // _NEAR_DC), _BELOW_ORDER * periods)
        number = number[number % periods > 0]
        # of a line that rises by one over n samples the bins are (-1 + j cot(pi k / n)) / 2
        leaked = 0.5 * rise * (-1.0 + 1j / np.tan(np.pi * number / len(coherent.values)))
        return float(np.sum(np.abs(self._bins[number] - leaked) ** 2))

    def is_clearly(self, *, other_than: _Followed) -> bool:
        """Return whether it has more or less between the harmonics than the other, beyond chance."""
        ratio = self.off_line / other_than.off_line if other_than.off_line > 0.0 else 1.0
        return abs(math.log(max(ratio, 1e-300))) > _FAR_BLUR / math.sqrt(
            _BELOW_ORDER * self.transformable.periods
        )

    def if_clearly_better_than(self, other: _Followed) -> _Followed:
        return self if self.off_line < other.off_line and self.is_clearly(other_than=other) else other

    def is_closer_than(self, other: _Followed) -> bool:
        """Return whether less is between the harmonics than of the other: of the whole band, or where that
        may be chance of its lowest part."""
        sharper = self.is_sharper(other)
        return self.off_line < other.off_line if sharper is None else sharper

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
        if not other.off_rad < found.off_rad or other.blurs(found) or found.is_sharper(other):
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
    steps = np.arange(1.0, _BEYOND + 1.0)
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
