"""What moves a harmonic: its own phase, or a line beside it; lines at all distances fitted to that.

A line makes amplitude and phase of a harmonic move alike, by what is in the bins to one side of it. A phase
that moves by itself leaves the amplitude as it is, as where harmonics are those of the inverter or of the
slots, and the angle between them and the current moves with the load.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.lines.close_distances import likely_fits
from benchtool.analysis.spectra.harmonic_movement import SIZES, Movement
from benchtool.analysis.spectra.interharmonics import dirichlet_kernel
from benchtool.analysis.spectra.moving_tones import Course

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

FARTHEST = 1.5  # bins: what is farther away is between the harmonics
DOF_OF_FLOOR = 40.0  # of a median of some forty squares, at least
_ILL_FITTED = 1e-3
_DISTANCES, _OF_TWO = 241, 4  # and of two lines every fourth
_FINE = 16  # distances from one whose sines are calculated to the next
_ON_HARMONIC = 1e-9  # bins
_KEPT = 64  # ranges of distances: the first is that of all harmonics, others begin and end where one line may
_MOST = 2.0  # of the harmonic as read: what a line beside it makes of it
_LARGE = 0.05  # of the fundamental: lines larger than that are the rarer
_LIKELY = 0.1  # of the most likely distance
_EXACTLY = 1e-3  # of a line: resampling, and what is left of the phase
_POINTS = 512  # places of the course of a line that is steady in time
_NODES = np.array([-2.0, -1.0, 0.0, 1.0, 2.0])  # of a normal distribution, in standard deviations
_AT_NODES = np.exp(-0.5 * _NODES**2) / np.sum(np.exp(-0.5 * _NODES**2))
_COVERAGE, _K = 0.95, 1.96


@dataclass(frozen=True)
class Kernel:
    """Distances `apart` of lines from a harmonic, none of them on it, shape (distances,), and what lines of
    amplitude one there make of the harmonic, `own`, shape (distances,), and of the bins beside it: half the
    sum and half the difference of those above and of the conjugate of those below, both of shape (distances,
    reach): beside all harmonics alike."""

    apart: Floats
    own: Complex
    sum: Complex
    difference: Complex

    @staticmethod
    def of(apart: Floats, around: Complex) -> Kernel:
        """Return that of lines that make these of the bins, shape (distances, 2 reach + 1)."""
        reach = around.shape[1] // 2
        above, below = around[:, reach + 1 :], np.conj(around[:, :reach][:, ::-1])
        return Kernel(apart, around[:, reach], 0.5 * (above + below), 0.5 * (above - below))

    def every(self, nth: int) -> Kernel:
        """Return that of every `nth` distance."""
        return Kernel(self.apart[::nth], self.own[::nth], self.sum[::nth], self.difference[::nth])


def _is_beside(apart: Floats) -> NDArray[np.bool_]:
    """Return which distances are not on the harmonic."""
    return np.asarray(np.abs(apart) > _ON_HARMONIC)


@lru_cache(maxsize=_KEPT)
def kernel_along_phase(first: float, last: float, reach: int, count: int) -> Kernel:
    """Return that of lines, at distances from `first` to `last`, that are steady along the phase."""
    apart = np.linspace(first, last, _DISTANCES)
    apart = apart[_is_beside(apart)]
    return Kernel.of(apart, dirichlet_kernel(apart[:, np.newaxis], np.arange(-reach, reach + 1), count))


def kernel_in_time(first: float, last: float, number: int, reach: int, course: Course) -> Kernel:
    """Return that of lines that are steady in time, beside the harmonic at the bin `number`."""
    turned = (np.arange(_POINTS) + 0.5) / _POINTS - 0.5 / len(course.turned)
    passed = np.interp(turned, course.turned, course.passed)
    middle = number * (passed - turned)[:, np.newaxis]
    bins = np.exp(2j * np.pi * (middle - np.outer(turned, np.arange(-reach, reach + 1)))) / _POINTS
    # distances are even: each is a coarse one and a fine step, and two products take less than as many sines
    step = (last - first) / (_DISTANCES - 1)
    coarse = first + _FINE * step * np.arange(-(-_DISTANCES // _FINE))
    by_fine: Complex = np.exp(2j * np.pi * np.outer(step * np.arange(_FINE), passed))
    by_coarse: Complex = np.exp(2j * np.pi * np.outer(coarse, passed))
    lines = (by_coarse[:, np.newaxis] * by_fine).reshape(-1, _POINTS)[:_DISTANCES]
    apart = np.linspace(first, last, _DISTANCES)
    beside = _is_beside(apart)
    return Kernel.of(apart[beside], (lines @ bins)[beside])


@dataclass(frozen=True)
class LineBeside:
    """A line at a `place`, in bins, with a `phasor`, 0 where it is not told, and the standard uncertainty
    that it leaves the amplitude of the harmonic beside it; `share` is the probability that there is one."""

    place: float
    phasor: complex
    standard: float
    share: float


@dataclass(frozen=True)
class LineFit:
    """Lines at distances `apart` from a harmonic, shape (distances,), fitted to a `movement`.

    `phasors` are theirs, `makes` is what they make of the harmonic, and `spread` the standard deviation of
    that by noise, along the harmonic; `likely` is the logarithm of their likelihood, and `weighs` with the
    share of all amplitudes before that noise allows. `scale` is by how much the noise is larger than it was
    said to be; `explains` is the logarithm by which fits to other movements are compared, and `excess`, of
    `dof` degrees of freedom, what the best leaves over what noise does; `explained` is the chi squared that
    it does not leave. Where that is too much, `of_two` is
    what two lines leave uncertain of the harmonic.
    """

    movement: Movement
    apart: Floats
    phasors: Complex
    makes: Complex
    spread: Floats
    likely: Floats
    weighs: Floats
    scale: float
    explains: float
    excess: float
    dof: float
    explained: float
    of_two: float = 0.0

    @staticmethod
    def of(movement: Movement, fundamental: float, kernel: Callable[[float, float], Kernel]) -> LineFit:
        """Return the fit at the distances that are likely, in a spectrum with this amplitude of the
        fundamental; `kernel` has lines at distances from a first to a last one."""
        amplitude, phase = np.conj(movement.amplitude), np.conj(movement.phase)
        of_amplitude, of_phase = 1.0 / movement.of_amplitude2, 1.0 / movement.of_phase2
        power = movement.chi2_of_amplitude + float(np.sum(movement.chi2_of_phase))
        values = 2 * movement.reach
        dof = 2.0 * values - 3.0

        def fitted(first: float, last: float) -> LineFit:
            lines = kernel(first, last)
            # of a line x + j y, over the harmonic, x S + j y D moves the amplitude, x D + j y S the phase
            s2, d2 = np.sum(np.abs(lines.sum) ** 2, axis=1), np.sum(np.abs(lines.difference) ** 2, axis=1)
            sd = np.sum((np.conj(lines.sum) * lines.difference).imag, axis=1)
            xx, yy = of_amplitude * s2 + of_phase * d2, of_amplitude * d2 + of_phase * s2
            xy = (of_phase - of_amplitude) * sd
            x = of_amplitude * (lines.sum @ amplitude).real + of_phase * (lines.difference @ phase).real
            y = -of_amplitude * (lines.difference @ amplitude).imag - of_phase * (lines.sum @ phase).imag
            determinant = np.maximum(xx * yy - xy**2, 1e-300)
            best_x, best_y = (yy * x - xy * y) / determinant, (xx * y - xy * x) / determinant
            rest = np.maximum(0.0, power - x * best_x - y * best_y)
            least = float(np.min(rest))
            expected = 1.0 + _EXACTLY**2 * (power - least) / values
            scale = max(expected, 2.0 * least / dof)
            relative = best_x + 1j * best_y
            noise2 = scale / np.sqrt(determinant)
            size2 = np.abs(relative) ** 2 + noise2
            large2 = size2 * (abs(movement.harmonic) / (_LARGE * fundamental)) ** 2
            own = lines.own
            spread2 = yy * own.real**2 + 2.0 * xy * own.real * own.imag + xx * own.imag**2
            likely = -rest / scale
            return LineFit(
                movement=movement,
                apart=lines.apart,
                phasors=movement.harmonic * relative,
                makes=movement.harmonic * relative * own,
                spread=abs(movement.harmonic) * np.sqrt(0.5 * scale * spread2 / determinant),
                likely=likely,
                weighs=likely + np.log(noise2 / (2.0 * size2 * SIZES * (1.0 + large2))),
                scale=scale,
                explains=-least / expected
                - movement.reach * math.log(movement.of_amplitude2 * movement.of_phase2 * expected**2),
                excess=2.0 * least / dof / expected,
                dof=dof,
                explained=(power - least) / expected,
            )

        found = likely_fits(fitted, -FARTHEST, FARTHEST)
        if not found.is_ill:
            return found
        of_two = two_lines(movement, kernel(-FARTHEST, FARTHEST).every(_OF_TWO))
        return replace(found, of_two=abs(movement.harmonic) * of_two)

    @property
    def is_ill(self) -> bool:
        """Whether noise hardly leaves as much."""
        return self.excess > _most_excess(self.dof)

    def share_of_lines(self, of_others: float, times: float) -> float:
        """Return the probability of a line against another explanation, which is `times` as likely before
        and has the logarithm of the likelihood `of_others`."""
        most = float(np.max(self.weighs))
        step = float(self.apart[1] - self.apart[0]) / (2.0 * FARTHEST)
        line = most + math.log(step * float(np.sum(np.exp(self.weighs - most))))
        against = math.log(times) + of_others - line
        return 1.0 / (1.0 + math.exp(min(against, 700.0)))

    def line(self, moves: float, by_itself: float) -> LineBeside:
        """Return what there is, on average, of a line, where the probability that the phase moves is `moves`,
        and that it moves by itself `by_itself` times as likely as a line; nothing where none explains the
        bins, and what two may be is uncertain."""
        if by_itself:
            moves *= self.share_of_lines(self.movement.by_itself(self.scale), by_itself)
        share = moves
        weight = np.exp(self.weighs - np.max(self.weighs))
        harmonic = self.movement.harmonic
        weight = np.where(_is_possible(np.abs(self.makes), abs(harmonic)), weight, 0.0)
        weight /= max(float(np.sum(weight)), 1e-300)
        mean = complex(weight @ self.makes)
        # about 1.43 bins away one farther and one nearer make the same of the harmonic
        off = np.where(weight < _LIKELY * np.max(weight), math.inf, np.abs(self.makes - mean))
        at = int(np.argmin(off))
        place = self.movement.number + float(self.apart[at])
        if self.is_ill:
            return LineBeside(place, 0j, math.sqrt(share) * self.of_two, share)
        toward = np.exp(-1j * np.angle(harmonic - mean))
        of_line = _standard(((self.makes - share * mean) * toward).real, self.spread, weight)
        of_none = share * (mean * toward).real
        standard = math.sqrt(share * of_line**2 + (1.0 - share) * of_none**2)
        return LineBeside(place, share * complex(self.phasors[at]), standard, share)


def _is_possible(makes: Floats, harmonic: float) -> NDArray[np.bool_]:
    """Return whether lines beside it may make as much of a harmonic as read, shape (fits,): of all that make
    far more than it is, and that the harmonic itself would cancel, the one that makes least."""
    possible = makes < _MOST * harmonic
    return possible if np.any(possible) else makes == np.min(makes)


def two_lines(movement: Movement, kernel: Kernel) -> float:
    """Return the standard uncertainty of a harmonic by two lines beside it, which are not taken out, of those
    at distances of a `kernel` that explain its movement."""
    by_amplitude, by_phase = movement.of_amplitude2**-0.5, movement.of_phase2**-0.5
    of_x = np.hstack([by_amplitude * kernel.sum, by_phase * kernel.difference])
    of_y = 1j * np.hstack([by_amplitude * kernel.difference, by_phase * kernel.sum])
    basis = np.stack([of_x, of_y], axis=1)
    basis = np.concatenate([basis.real, basis.imag], axis=2)  # distances, x and y, values
    moved = np.concatenate([by_amplitude * movement.amplitude, by_phase * movement.phase])
    moved = np.concatenate([moved.real, moved.imag])
    one, two = np.triu_indices(len(kernel.apart), k=2)
    rows = 2 * np.stack([one, one, two, two], axis=1) + np.array([0, 1, 0, 1])  # pairs, unknowns
    every = basis.reshape(-1, basis.shape[2])
    normal = (every @ every.T)[rows[:, :, np.newaxis], rows[:, np.newaxis]]
    found = (every @ moved)[rows]
    inverse = np.linalg.inv(normal)
    unknowns = np.einsum("pij,pj->pi", inverse, found)
    rest = float(moved @ moved) - np.sum(unknowns * found, axis=1)
    scale = max(1.0, 2.0 * float(np.min(rest)) / (len(moved) - 6.0))
    # of any amplitude each, in the logarithm
    sizes2 = (unknowns[:, 0] ** 2 + unknowns[:, 1] ** 2) * (unknowns[:, 2] ** 2 + unknowns[:, 3] ** 2)
    likely = -rest / scale - np.log(sizes2) - 0.5 * np.linalg.slogdet(normal)[1]
    lines = unknowns[:, ::2] + 1j * unknowns[:, 1::2]
    made = np.abs(lines[:, 0] * kernel.own[one] + lines[:, 1] * kernel.own[two])
    likely = np.where(_is_possible(made, 1.0), likely, -math.inf)
    own = np.stack([kernel.own.real, -kernel.own.imag], axis=1)
    along = np.concatenate([own[one], own[two]], axis=1)
    spread = np.sqrt(0.5 * scale * np.einsum("pi,pij,pj->p", along, inverse, along))
    weight = np.exp(likely - np.max(likely))
    return _standard(np.sum(unknowns * along, axis=1), spread, weight / np.sum(weight))


def _standard(values: Floats, spread: Floats, weight: Floats) -> float:
    """Return the standard uncertainty of a mixture of normal distributions about values with these standard
    deviations, all of shape (values,), with these weights: the deviation from 0, or less where few values
    far away make that so large, of which 95 % are within 1.96 times as much."""
    deviation = math.sqrt(float(weight @ (values**2 + spread**2)))
    far = np.abs(values[:, np.newaxis] + spread[:, np.newaxis] * _NODES).ravel()
    order = np.argsort(far)
    below = np.cumsum((weight[:, np.newaxis] * _AT_NODES).ravel()[order])
    within = float(far[order][min(int(np.searchsorted(below, _COVERAGE)), len(far) - 1)])
    return min(deviation, within / _K)


@lru_cache(maxsize=8)
def _most_excess(dof: float) -> float:
    """Return what the squares that noise leaves are over their mean at most, but once in a thousand times."""
    low, high = 1.0, 1e3
    while high - low > 1e-12 * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fisher_above(dof, DOF_OF_FLOOR, middle) < _ILL_FITTED else (middle, high)
    return high
