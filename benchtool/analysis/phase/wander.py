"""How the fundamental of a signal moves about a track: its phase and amplitude in each period."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples
from benchtool.analysis.distributions import fisher_above

_BY_CHANCE, _DOUBTED = 1e-4, 0.05
_FEWEST_AT_SIDE = 3
_FEWEST_PERIODS = 4  # and so many phases, from which a wander is told from noise
_FEWEST_ABOUT_A_LINE = 6  # amplitudes: of fewer a line takes along most of their noise
_MEDIAN_DEVIATION = 0.6745  # median of the magnitude of a normal deviate
_FAR = 8.0  # standard deviations; the largest step of a swing or of a drift is within two
_OFTEN, _FEWEST_STEPS = 0.8, 20  # share of steps, and of how many: what a fifth of them do is no jump
_OFTEN_DEVIATION = 1.2816  # what so many magnitudes of normal deviates are within
_LEAST_JUMP_RAD = 0.03  # a reversal may by chance leave any phase, half of it in one step
_STEADY, _SLOWEST = 2, 4  # terms of a steady rise, and of the courses beside it that are looked at
_OF_NOISE = 0.35  # relative deviation of amplitudes, which of noise alone have Rayleigh's, 0.52
_UNRELATED, _MOST_OF_NOISE = 2.5, 0.5  # standard deviations of a correlation; the most of few periods
_MOST_TURNED_RAD, _MOST_BENT_RAD = 0.3, 0.2  # in a period beside the track: more is noise, or a jump


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


@dataclass(frozen=True)
class BeyondNoise:
    """How far phases of periods deviate, rms, beyond what noise does; 0 where noise does as much `by_chance`,
    the probability of that. `noise_rad` is what it does to one of them."""

    excess_rad: float
    noise_rad: float
    by_chance: float


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
    of_amplitude = float(np.var(amplitude)) / middle**2
    if of_amplitude > _OF_NOISE**2 and _are_unrelated(phasor):
        return Wander(phase_rad, amplitude, 0.0, math.sqrt(of_amplitude))
    beyond = beyond_noise(phase_rad, amplitude)
    jump_rad = _jump_rad(steps)
    return Wander(
        phase_rad,
        amplitude,
        beyond.excess_rad,
        beyond.noise_rad,
        jump_rad,
        jump_rad > 0.0 and _jumps_alone(steps, amplitude),
        is_doubted=_BY_CHANCE <= beyond.by_chance < _DOUBTED,
    )


def beyond_noise(phase_rad: NDArray[np.float64], amplitude: NDArray[np.float64]) -> BeyondNoise:
    """Return how far the phase of a fundamental moves about a track beyond what noise does, which moves the
    amplitude alike; phase and amplitude in each period, shape (periods,)."""
    middle = float(np.mean(amplitude))
    of_phase, of_amplitude = float(np.var(phase_rad)), float(np.var(amplitude)) / middle**2
    excess, by_chance = 0.0, 1.0
    if len(phase_rad) >= _FEWEST_PERIODS:
        if len(phase_rad) >= _FEWEST_ABOUT_A_LINE:
            of_amplitude = _about_a_line(amplitude) / middle**2
        by_chance = _by_chance(phase_rad, of_amplitude) if of_phase > of_amplitude else 1.0
        excess = math.sqrt(of_phase - of_amplitude) if by_chance < _BY_CHANCE else 0.0
    return BeyondNoise(excess, math.sqrt(of_amplitude), by_chance)


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
    """Return the largest step of the phase less the median step, if far beyond the scatter of the others.

    Of a load that swings once in a revolution of three periods one step of three is far from the others.
    """
    if len(steps) + 1 < _FEWEST_PERIODS:
        return 0.0
    away = np.abs(steps - np.median(steps))
    largest, usual = float(np.max(away)), float(np.median(away)) / _MEDIAN_DEVIATION
    if len(steps) >= _FEWEST_STEPS:
        usual = max(usual, float(np.quantile(away, _OFTEN)) / _OFTEN_DEVIATION)
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
