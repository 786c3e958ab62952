"""Steady lines less than a bin and a half beside a harmonic, told by what that harmonic alone does.

Over a record a line turns about the harmonic by less than a turn or two: amplitude and phase move along an
arc, whose centre is not on it. A line of phasor p, d bins away, makes in the bin m beside the harmonic

    X_m = B / (d - m),   B = p sin(pi d) exp(j pi d) / pi

and in the harmonic itself B / d. What changes the amplitude by Re(B) / d moves the phase evenly, by
2 pi Re(B) over the record, and bends the amplitude in proportion to Re(B) d only: the phase tells that there
is a line, and the bend how far away it is, and so how large. What a speed moves is no line: all harmonics
tell it, of which k turns k times as far. Nor is an amplitude that all of them have in common.

A line of constant frequency, as that of another drive or of the mains, is steady along the phase of the
fundamental where the speed is, and else in time alone: both are tried.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum
from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.lines.close_distances import likely_fits
from benchtool.analysis.noise.converter_lines import aliased_quantisation
from benchtool.analysis.noise.noise import harmonic_noise
from benchtool.analysis.spectra.interharmonics import Interharmonics, dirichlet_kernel, sinusoid
from benchtool.analysis.spectra.moving_tones import Course, MovingTone

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

_REACH = 8  # bins to either side
_FARTHEST = 1.5  # bins: what is farther away is between the harmonics
_STANDS_OUT = 5.0  # of the noise, of harmonics that tell what the speed does
_BEFORE = 0.02  # one line beside fifty harmonics
_SIZES = math.log(1e4)  # of any amplitude from the noise to ten thousand times as much, in the logarithm
_LEAST_SHARE, _ILL_FITTED = 0.01, 1e-3
_DOF_OF_FLOOR = 40.0  # of a median of some forty squares, at least
_DISTANCES = 241
_ON_HARMONIC = 1e-9  # bins
_KEPT = 64  # ranges of distances: the first is that of all harmonics, others begin and end where one line may
_ROUNDS = 3  # as lines leak into the noise beside other harmonics
_MOST = 2.0  # of the harmonic as read: what a line beside it makes of it
_EXACTLY = 1e-3  # of a line: resampling, and what is left of the phase
_MOVES, _POINTS = 0.01, 512  # periods of a line steady in time, along the phase; places of its course


@dataclass(frozen=True)
class CloseLines:
    """Lines beside harmonics, None where there are none, and the standard uncertainty that they leave the
    amplitude of each harmonic, shape (harmonics,), when they are taken out; `turned_rad` is that of the phase
    of the fundamental from begin to end."""

    lines: Interharmonics | None
    standard: Floats
    turned_rad: float


@dataclass(frozen=True)
class _Line:
    """A line at a `place` with a `phasor`, 0 where it is not told, and what it leaves open of the amplitude
    beside it and of the phase over the record. Of one that is steady in time alone `transformed` are all bins
    that its analytic signal makes, shape (count,)."""

    place: float
    phasor: complex
    standard: float
    turned_rad: float = 0.0
    transformed: Complex | None = None

    @property
    def tone(self) -> MovingTone:
        """The line where it is steady in time."""
        return MovingTone(self.phasor, self.place, self.place, 0.0)

    def of_bins(self, number: Integers, count: int) -> tuple[Complex, Complex]:
        """Return what it makes of bins, by its positive and by its negative frequency."""
        if self.transformed is not None:
            return self.transformed[number], np.conj(self.transformed[-number])
        above, below = sinusoid(self.place, number, count)
        return self.phasor * above, np.conj(self.phasor) * below


def close_lines(
    spectrum: CoherentSpectrum, count: int, orders: int, step: float = 0.0, course: Course | None = None
) -> CloseLines:
    """Return the lines beside harmonics 1 to `orders` of a spectrum of `count` samples in steps of `step`;
    these are at `course`, by which lines that are steady in time alone are told.

    A line counts by the probability that it is one, by how many standard deviations the phase moves (Bayes
    factor of a line of any size over none), and distances by how well they explain the bins beside. What a
    converter's steps fold to beside a harmonic is on either side of it, and no such line.
    """
    periods, bins = spectrum.periods, spectrum.phasor
    reach = min(_REACH, (periods - 1) // 2)
    standard = np.zeros(orders)
    orders = min(orders, (len(bins) - 1 - reach) // periods)
    if reach < 2 or orders < 1:
        return CloseLines(None, standard, 0.0)
    number = periods * np.arange(1, orders + 1)[:, np.newaxis] + np.arange(-reach, reach + 1)
    found: dict[int, _Line] = {}
    folded2 = aliased_quantisation(spectrum, step, orders) ** 2
    clean, floor2 = spectrum, np.full(orders, math.inf)
    for _ in range(_ROUNDS):
        # what was explained once is no noise, though it may turn out to be no single line
        floor2 = np.minimum(floor2, 2.0 * harmonic_noise(clean, orders) ** 2 + folded2)
        around = bins[number] - _made(found, number, count)
        stands_out = _stands_out(around, floor2)
        for index in range(orders):
            own = found.pop(index, None)
            if own is None and not stands_out[index]:
                continue
            if own is not None:  # what it makes of itself by its negative frequency stays out
                above, below = own.of_bins(number, count)
                below[index] = 0.0
                around += above + below
            line = _beside(around, floor2, index, number[index], count, course)
            if line is not None:
                found[index] = line
                around -= _made({index: line}, number, count)
            if own is not None or line is not None:
                stands_out = _stands_out(around, floor2)
        if not found:
            return CloseLines(None, standard, 0.0)
        left = bins - _made(found, np.arange(len(bins), dtype=np.int64), count)
        clean = replace(spectrum, phasor=left, amplitude=np.abs(left))
    standard[list(found)] = [each.standard for each in found.values()]
    turned_rad = found[0].turned_rad if 0 in found else 0.0
    told = [each for each in found.values() if each.phasor]
    return CloseLines(_taken(told) if told else None, standard, turned_rad)


def _taken(lines: Sequence[_Line]) -> Interharmonics:
    steady = [each for each in lines if each.transformed is None]
    return Interharmonics(
        np.array([each.place for each in steady], dtype=np.float64),
        np.array([each.phasor for each in steady], dtype=np.complex128),
        moving=tuple(each.tone for each in lines if each.transformed is not None),
    )


def _made(found: Mapping[int, _Line], number: Integers, count: int) -> Complex:
    """Return what lines make of bins."""
    made = np.zeros(number.shape, dtype=np.complex128)
    for each in found.values():
        if each.phasor:
            above, below = each.of_bins(number, count)
            made += above + below
    return made


@dataclass(frozen=True)
class _Motions:
    """What may move the relative amplitude and the phase of a harmonic as it moves others, in the bins above
    it, both of shape (motions, reach), and the mean squares of the noise in these, both of shape
    (motions,)."""

    amplitude: Complex
    phase: Complex
    of_amplitude2: Floats
    of_phase2: Floats


def _stands_out(around: Complex, floor2: Floats) -> NDArray[np.bool_]:
    """Return which harmonics may have a line beside, shape (harmonics,), of the bins `around` them, shape
    (harmonics, 2 reach + 1), with mean squares `floor2` of noise.

    Those whose phase moves if nothing else moves it, and the fundamental, which is not told without others.
    """
    reach = around.shape[1] // 2
    size2 = np.abs(around[:, reach]) ** 2
    known = (floor2 > 0.0) & (size2 > 0.0)  # nan is not
    _, of_phase = _parts(around[known])
    moved = _moves(of_phase.real) / _of_moves(floor2[known] / size2[known], reach)
    found = known.copy()
    found[known] = _share(moved) >= _LEAST_SHARE
    found[0] = known[0]
    return found


def _parts(around: Complex) -> tuple[Complex, Complex]:
    """Return what moves the relative amplitude of harmonics, and what moves their phase, in the bins above
    them, both of shape (..., reach), of all bins around them, shape (..., 2 reach + 1)."""
    reach = around.shape[-1] // 2
    relative = around / around[..., reach, np.newaxis]
    upper, lower = relative[..., reach + 1 :], np.conj(relative[..., :reach][..., ::-1])
    return 0.5 * (upper + lower), 0.5 * (upper - lower)


def _moves(of_phase: Floats) -> Floats:
    """Return by how much phases move evenly, over 2 pi, of what moves them, shape (..., reach)."""
    weight = 1.0 / np.arange(1.0, of_phase.shape[-1] + 1.0)
    return np.asarray(np.abs(of_phase @ weight) / float(weight @ weight))


def _of_moves(relative2: Floats, reach: int) -> Floats:
    """Return the standard deviation of that by noise of these mean squares in a bin, relative to the
    harmonic."""
    weight = 1.0 / np.arange(1.0, reach + 1.0)
    return np.sqrt(0.25 * relative2 / float(weight @ weight))


def _beside(
    around: Complex, floor2: Floats, index: int, number: Integers, count: int, course: Course | None
) -> _Line | None:
    """Return the line beside one harmonic, of the bins `around` all, shape (harmonics, 2 reach + 1), with the
    mean square `floor2` of noise in a bin; None where something else explains what it does.

    Where no line does, steady along the phase or in time, it is not taken out, and all that it might make of
    the harmonic is uncertain.
    """
    reach = around.shape[1] // 2
    size2 = float(np.abs(around[index, reach]) ** 2)
    if not (floor2[index] > 0.0 and size2 > 0.0):
        return None
    motions = _motions(around, floor2, index)
    if motions is None:
        return None
    noise2 = floor2[index] + size2 * motions.of_phase2
    of_moves = _of_moves(noise2 / size2, reach)
    moved = float(np.min(_moves((_parts(around[index])[1] - motions.phase).real) / of_moves))
    share = float(_share(moved))
    if share < _LEAST_SHARE:
        return None
    above, below = motions.amplitude + motions.phase, np.conj(motions.amplitude - motions.phase)
    moves = np.concatenate([below[:, ::-1], np.zeros((len(noise2), 1)), above], axis=1)
    left, left2 = around[index] - around[index, reach] * moves, noise2 + size2 * motions.of_amplitude2
    best = _best_fit(left, number, left2, partial(_kernel, reach=reach, count=count))
    in_time = False
    if course is not None and _moves_in_time(course, number):
        in_time_alone = lru_cache(partial(_kernel_in_time, number=number, course=course))
        other = _best_fit(left, number, left2, in_time_alone)
        in_time = other.explains > best.explains
        best = other if in_time else best
    of_move = float(of_moves[-1]) * math.sqrt(share * (1.0 + (1.0 - share) * moved**2))
    line = replace(best.line(share), turned_rad=2.0 * math.pi * of_move)
    if not in_time or not line.phasor or course is None:
        return line
    return replace(line, transformed=fft.fft(line.tone.at(course)) / count)


def _best_fit(
    left: Complex, number: Integers, noise2: Floats, kernel: Callable[[float, float], _Kernel]
) -> _Fit:
    """Return the fit that explains most of bins, shape (motions, 2 reach + 1), of those that noise of these
    mean squares, shape (motions,), may leave, or else of all."""
    fits = [_Fit.of(each, number, float(each2), kernel) for each, each2 in zip(left, noise2, strict=True)]
    return max(fits, key=lambda each: (not each.is_ill, each.explains))


def _moves_in_time(course: Course, number: Integers) -> bool:
    """Return whether what is steady in time moves along the phase, near the bins `number`."""
    return float(number[-1] * np.max(np.abs(course.passed - course.turned))) > _MOVES


def _share(moved: Floats | float) -> Floats:
    """Return the probability of a line that moves a phase by so many standard deviations of noise.

    Of a move x of any size, in the logarithm, as likely as any other over a range of exp(L) the Bayes factor
    is exp(x^2 / 2) sqrt(2 pi) / (2 L x), here of Student's distribution, as the noise is not quite known.
    """
    above = np.maximum(moved, 1.0)
    likely = 0.5 * (_DOF_OF_FLOOR + 1.0) * np.log1p(above**2 / _DOF_OF_FLOOR)
    odds = math.log(_BEFORE * math.sqrt(2.0 * math.pi) / (2.0 * _SIZES)) + likely - np.log(above)
    return np.where(above > 1.0, 1.0 / (1.0 + np.exp(-odds)), 0.0)


def _motions(around: Complex, floor2: Floats, index: int) -> _Motions | None:
    """Return what may move a harmonic as it moves others; None for a fundamental that no others tell of.

    A speed moves all phases, whatever the amplitudes do. The fundamental tells it best, but for a line beside
    that. So do the harmonics together: their scatter is that of noise, or more where they do not agree.
    """
    reach = around.shape[1] // 2
    order, middle = np.arange(1, len(around) + 1), around[:, reach]
    size2, own = np.abs(middle) ** 2, index + 1
    known = np.flatnonzero((size2 > _STANDS_OUT**2 * floor2) & (order != own))
    amplitude, phase = _parts(around[known])
    phase *= (own / order[known])[:, np.newaxis]
    noise2 = 0.5 * floor2[known] / size2[known]
    none = np.zeros(reach, dtype=np.complex128)
    amplitudes, phases = [(none, 0.0)], []
    if index > 0:
        phases.append((none, 0.0))
        if len(known) and known[0] == 0:
            amplitudes.append((amplitude[0], float(noise2[0])))
            phases.append((phase[0], float(noise2[0]) * own**2))
    harmonic = known > 0
    if np.count_nonzero(harmonic) > 1:
        of_phase2 = noise2[harmonic] * (own / order[known][harmonic]) ** 2
        phases.append(_together(phase[harmonic], of_phase2))
        if index == 0:
            amplitudes.append(_together(amplitude[harmonic], noise2[harmonic]))
    if not phases:
        return None
    by_both = [(*by_amplitude, *by_phase) for by_amplitude in amplitudes for by_phase in phases]
    amplitude, of_amplitude2, phase, of_phase2 = (np.array(each) for each in zip(*by_both, strict=True))
    return _Motions(amplitude, phase, of_amplitude2, of_phase2)


def _together(values: Complex, noise2: Floats) -> tuple[Complex, float]:
    """Return the mean of values, shape (harmonics, bins), each weighted by its noise, and its mean square
    error, by their scatter if that is more than the noise."""
    weight = 1.0 / noise2
    mean = weight @ values / np.sum(weight)
    scatter = float(np.sum(weight[:, np.newaxis] * np.abs(values - mean) ** 2))
    excess = max(1.0, scatter / ((len(values) - 1) * values.shape[1]))
    return mean, excess / float(np.sum(weight))


@dataclass(frozen=True)
class _Kernel:
    """Distances `apart` of lines from a harmonic, none of them on it, shape (distances,), and what lines of
    amplitude one there make of the harmonic, `own`, and, conjugated, of the bins beside it, shape (distances,
    2 reach), with the sum of squares of these, `size2`: beside all harmonics alike."""

    apart: Floats
    own: Complex
    beside: Complex
    size2: Floats

    @staticmethod
    def of(apart: Floats, around: Complex) -> _Kernel:
        """Return that of lines that make these of the bins, shape (distances, 2 reach + 1)."""
        reach = around.shape[1] // 2
        beside = np.conj(np.delete(around, reach, axis=1))
        return _Kernel(apart, around[:, reach], beside, np.sum(np.abs(beside) ** 2, axis=1))


def _kernel_in_time(first: float, last: float, number: Integers, course: Course) -> _Kernel:
    """Likewise of lines that are steady in time, beside the harmonic in the middle of the bins `number`."""
    reach, apart = len(number) // 2, _apart(first, last)
    turned = (np.arange(_POINTS) + 0.5) / _POINTS - 0.5 / len(course.turned)
    passed = np.interp(turned, course.turned, course.passed)
    middle = int(number[reach]) * (passed - turned)[:, np.newaxis]
    bins = np.exp(2j * np.pi * (middle - np.outer(turned, np.arange(-reach, reach + 1)))) / _POINTS
    return _Kernel.of(apart, np.exp(2j * np.pi * np.outer(apart, passed)) @ bins)


def _apart(first: float, last: float) -> Floats:
    apart = np.linspace(first, last, _DISTANCES)
    return apart[np.abs(apart) > _ON_HARMONIC]


@lru_cache(maxsize=_KEPT)
def _kernel(first: float, last: float, reach: int, count: int) -> _Kernel:
    apart = _apart(first, last)
    return _Kernel.of(apart, dirichlet_kernel(apart[:, np.newaxis], np.arange(-reach, reach + 1), count))


@dataclass(frozen=True)
class _Fit:
    """Lines at distances `apart` from a harmonic at the bin `number`, shape (distances,), fitted to the bins
    beside it: their `phasors`, what they make of the `harmonic`, the standard deviation of one component of
    that by noise, and the logarithm of their likelihood; `explains` is that of the best, by which fits of
    other noise are compared, `excess`, of `dof` degrees of freedom, what it leaves over what noise does."""

    harmonic: complex
    number: int
    apart: Floats
    phasors: Complex
    makes: Complex
    spread: Floats
    likely: Floats
    explains: float
    excess: float
    dof: float

    @staticmethod
    def of(left: Complex, number: Integers, noise2: float, kernel: Callable[[float, float], _Kernel]) -> _Fit:
        """Return the fit to bins of these numbers, the harmonic in the middle, both of shape (2 reach + 1,),
        at the distances that are likely; `kernel` has lines at distances from a first to a last one."""
        reach = len(number) // 2
        measured = np.concatenate([left[:reach], left[reach + 1 :]])
        power, dof = float(np.sum(np.abs(measured) ** 2)), 2.0 * len(measured) - 3.0

        def fitted(first: float, last: float) -> _Fit:
            lines = kernel(first, last)
            phasors = lines.beside @ measured / lines.size2
            rest = np.maximum(0.0, power - np.abs(phasors) ** 2 * lines.size2)
            least = float(np.min(rest))
            expected = noise2 + _EXACTLY**2 * (power - least) / len(measured)
            scale = max(expected, 2.0 * least / dof)
            return _Fit(
                harmonic=complex(left[reach]),
                number=int(number[reach]),
                apart=lines.apart,
                phasors=phasors,
                makes=phasors * lines.own,
                spread=np.sqrt(0.5 * scale / lines.size2) * np.abs(lines.own),
                likely=-rest / scale,
                explains=-least / expected - len(measured) * math.log(expected),
                excess=2.0 * least / dof / expected,
                dof=dof,
            )

        return likely_fits(fitted, -_FARTHEST, _FARTHEST)

    @property
    def is_ill(self) -> bool:
        """Whether noise hardly leaves as much."""
        return self.excess > _most_excess(self.dof)

    def line(self, share: float) -> _Line:
        """Return what there is, on average, of a line whose probability is that `share`; nothing where none
        explains the bins, and what it may be is uncertain."""
        weight = np.exp(self.likely - np.max(self.likely))
        possible = np.abs(self.makes) < _MOST * abs(self.harmonic)
        if not np.any(possible):
            possible = np.abs(self.makes) == np.min(np.abs(self.makes))
        weight = np.where(possible, weight, 0.0)
        weight /= max(float(np.sum(weight)), 1e-300)
        mean = complex(weight @ self.makes)
        toward = np.exp(-1j * np.angle(self.harmonic - mean))
        square = float(weight @ (((self.makes - mean) * toward).real ** 2 + self.spread**2))
        at = int(np.argmin(np.abs(self.makes - mean)))
        if self.is_ill:
            square += (mean * toward).real ** 2
            return _Line(self.number + float(self.apart[at]), 0j, math.sqrt(share * square))
        phasor = share * complex(self.phasors[at])
        untold2 = share * (1.0 - share) * (mean * toward).real ** 2
        return _Line(self.number + float(self.apart[at]), phasor, math.sqrt(share * square + untold2))


@lru_cache(maxsize=_REACH)
def _most_excess(dof: float) -> float:
    """Return what the squares that noise leaves are over their mean at most, but once in a thousand times."""
    low, high = 1.0, 1e3
    while high - low > 1e-12 * high:
        middle = 0.5 * (low + high)
        low, high = (
            (low, middle) if fisher_above(dof, _DOF_OF_FLOOR, middle) < _ILL_FITTED else (middle, high)
        )
    return high
