"""Steady lines less than a bin and a half beside a harmonic, told by what that harmonic alone does.

Over a record a line turns about the harmonic by less than a turn or two: amplitude and phase move along an
arc, whose centre is not on it. A line of phasor p, d bins away, makes in the bin m beside the harmonic

    X_m = B / (d - m),   B = p sin(pi d) exp(j pi d) / pi

and in the harmonic itself B / d. What changes the amplitude by Re(B) / d moves the phase evenly, by
2 pi Re(B) over the record, and bends the amplitude in proportion to Re(B) d only: the phase tells that there
is a line, and the bend how far away it is, and so how large. What a speed moves is no line: all harmonics
tell it, of which k turns k times as far. Nor is an amplitude that all of them have in common.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.spectra.interharmonics import Interharmonics, response
from benchtool.analysis.spectra.noise import harmonic_noise
from benchtool.analysis.spectra.spectrum import CoherentSpectrum

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
_DISTANCES, _PASSES, _LIKELY = 241, 3, 12.0  # by that much less likely in the logarithm is not
_ON_HARMONIC = 1e-9  # bins
_KEPT = 64  # ranges of distances: the first is that of all harmonics, others begin and end where one line may
_ROUNDS = 3  # as lines leak into the noise beside other harmonics
_MOST = 2.0  # of the harmonic as read: what a line beside it makes of it
_EXACTLY = 1e-3  # of a line: resampling, and what is left of the phase


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
    """A line at a `place` with a `phasor`, and what it leaves open of the amplitude beside it and of the
    phase over the record."""

    place: float
    phasor: complex
    standard: float
    turned_rad: float = 0.0


def close_lines(spectrum: CoherentSpectrum, count: int, orders: int) -> CloseLines:
    """Return the lines beside harmonics 1 to `orders` of a spectrum of `count` samples.

    A line counts by the probability that it is one, by how many standard deviations the phase moves (Bayes
    factor of a line of any size over none), and distances by how well they explain the bins beside.
    """
    periods, bins = spectrum.periods, spectrum.phasor
    reach = min(_REACH, (periods - 1) // 2)
    standard = np.zeros(orders)
    orders = min(orders, (len(bins) - 1 - reach) // periods)
    if reach < 2 or orders < 1:
        return CloseLines(None, standard, 0.0)
    number = periods * np.arange(1, orders + 1)[:, np.newaxis] + np.arange(-reach, reach + 1)
    found: dict[int, _Line] = {}
    clean = spectrum
    for _ in range(_ROUNDS):
        floor2 = 2.0 * harmonic_noise(clean, orders) ** 2
        around = bins[number] - _sinusoids(found).of_bins(number, count)
        for index in range(orders):
            if index in found:  # what it makes of itself by its negative frequency stays out
                own = found.pop(index)
                makes = _sinusoids({index: own}).of_bins(number, count)
                makes[index] = own.phasor * response(own.place - number[index], count)
                around += makes
            line = _beside(around, floor2, index, number[index], count)
            if line is not None:
                found[index] = line
                around -= _sinusoids({index: line}).of_bins(number, count)
        if not found:
            return CloseLines(None, standard, 0.0)
        left = bins - _sinusoids(found).of_bins(np.arange(len(bins), dtype=np.int64), count)
        clean = replace(spectrum, phasor=left, amplitude=np.abs(left))
    standard[list(found)] = [each.standard for each in found.values()]
    return CloseLines(_sinusoids(found), standard, found[0].turned_rad if 0 in found else 0.0)


def _sinusoids(found: Mapping[int, _Line]) -> Interharmonics:
    places = np.array([each.place for each in found.values()], dtype=np.float64)
    return Interharmonics(places, np.array([each.phasor for each in found.values()], dtype=np.complex128))


@dataclass(frozen=True)
class _Motion:
    """What moves the relative amplitude and the phase of a harmonic as it moves others, in the bins above it,
    shape (reach,), and the mean squares of the noise in them."""

    amplitude: Complex
    phase: Complex
    of_amplitude2: float = 0.0
    of_phase2: float = 0.0


def _beside(around: Complex, floor2: Floats, index: int, number: Integers, count: int) -> _Line | None:
    """Return the line beside one harmonic, of the bins `around` all, shape (harmonics, 2 reach + 1), with the
    mean square `floor2` of noise in a bin; None where something else explains what it does."""
    reach = around.shape[1] // 2
    size2 = np.abs(around[:, reach]) ** 2
    if not (math.isfinite(floor2[index]) and size2[index] > 0.0):
        return None
    weight = 1.0 / np.arange(1.0, reach + 1.0)  # of a phase that moves evenly
    upper, lower = (around[index, reach + by :: by][:reach] / around[index, reach] for by in (1, -1))
    best: _Fit | None = None
    moved, of_move = math.inf, 0.0
    for motion in _motions(around, floor2, index):
        apart = 0.5 * (upper - np.conj(lower)).real - motion.phase.real
        noise2 = floor2[index] + size2[index] * motion.of_phase2
        of_move = math.sqrt(0.25 * noise2 / size2[index] / float(weight @ weight))
        moved = min(moved, abs(float(apart @ weight)) / float(weight @ weight) / of_move)
        if _share(moved) < _LEAST_SHARE:
            return None
        above, below = motion.amplitude + motion.phase, np.conj(motion.amplitude - motion.phase)
        left = around[index] - around[index, reach] * np.concatenate([below[::-1], [0.0], above])
        fit = _Fit.of(left, number, noise2 + size2[index] * motion.of_amplitude2, count)
        if not fit.is_ill and (best is None or fit.explains > best.explains):
            best = fit
    if best is None:
        return None
    share = _share(moved)
    of_move *= math.sqrt(share * (1.0 + (1.0 - share) * moved**2))
    return replace(best.line(share), turned_rad=2.0 * math.pi * of_move)


def _share(moved: float) -> float:
    """Return the probability of a line that moves a phase by so many standard deviations of noise.

    Of a move x of any size, in the logarithm, as likely as any other over a range of exp(L) the Bayes factor
    is exp(x^2 / 2) sqrt(2 pi) / (2 L x), here of Student's distribution, as the noise is not quite known.
    """
    if not moved > 1.0:
        return 0.0
    likely = (1.0 + moved**2 / _DOF_OF_FLOOR) ** (0.5 * (_DOF_OF_FLOOR + 1.0))
    odds = _BEFORE * float(likely) * math.sqrt(2.0 * math.pi) / (2.0 * _SIZES * moved)
    return odds / (1.0 + odds)


def _motions(around: Complex, floor2: Floats, index: int) -> Iterator[_Motion]:
    """Yield what may move a harmonic as it moves others; for the fundamental only if others tell that.

    A speed moves all phases, whatever the amplitudes do. The fundamental tells it best, but for a line beside
    that. So do the harmonics together: their scatter is that of noise, or more where they do not agree.
    """
    reach = around.shape[1] // 2
    order, middle = np.arange(1, len(around) + 1), around[:, reach]
    size2, own = np.abs(middle) ** 2, index + 1
    known = np.flatnonzero((size2 > _STANDS_OUT**2 * floor2) & (order != own))
    upper = around[known, reach + 1 :] / middle[known, np.newaxis]
    lower = np.conj(around[known, :reach][:, ::-1] / middle[known, np.newaxis])
    amplitude, phase = 0.5 * (upper + lower), 0.5 * (upper - lower) * (own / order[known])[:, np.newaxis]
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
    for by_amplitude, of_amplitude2 in amplitudes:
        for by_phase, each2 in phases:
            yield _Motion(by_amplitude, by_phase, of_amplitude2, each2)


def _together(values: Complex, noise2: Floats) -> tuple[Complex, float]:
    """Return the mean of values, shape (harmonics, bins), each weighted by its noise, and its mean square
    error, by their scatter if that is more than the noise."""
    weight = 1.0 / noise2
    mean = weight @ values / np.sum(weight)
    scatter = float(np.sum(weight[:, np.newaxis] * np.abs(values - mean) ** 2))
    excess = max(1.0, scatter / ((len(values) - 1) * values.shape[1]))
    return mean, excess / float(np.sum(weight))


@lru_cache(maxsize=_KEPT)
def _kernel(first: float, last: float, reach: int, count: int) -> tuple[Floats, Complex]:
    """Return distances of lines from a harmonic, none of them on it, shape (distances,), and what lines of
    amplitude one there make of the bins around it, shape (distances, 2 reach + 1): beside all harmonics
    alike."""
    apart = np.linspace(first, last, _DISTANCES)
    apart = apart[np.abs(apart) > _ON_HARMONIC]
    return apart, response(apart[:, np.newaxis] - np.arange(-reach, reach + 1), count)


@dataclass(frozen=True)
class _Fit:
    """Lines at `places`, shape (distances,), fitted to the bins beside a `harmonic`: their `phasors`, what
    they make of the harmonic, the standard deviation of one component of that by noise, and the logarithm of
    their likelihood; `explains` is that of the best, by which fits of other noise are compared."""

    harmonic: complex
    places: Floats
    phasors: Complex
    makes: Complex
    spread: Floats
    likely: Floats
    explains: float
    is_ill: bool

    @staticmethod
    def of(left: Complex, number: Integers, noise2: float, count: int) -> _Fit:
        """Return the fit to bins of these numbers, the harmonic in the middle, both of shape (2 reach + 1,),
        over ever fewer distances around the likely ones."""
        reach = len(number) // 2
        measured = np.delete(left, reach)
        power, dof = float(np.sum(np.abs(measured) ** 2)), 2.0 * len(measured) - 3.0
        first, last = -_FARTHEST, _FARTHEST
        for _ in range(_PASSES):
            apart, kernel = _kernel(first, last, reach, count)
            places = number[reach] + apart
            beside = np.delete(kernel, reach, axis=1)
            size2 = np.sum(np.abs(beside) ** 2, axis=1)
            phasors = np.conj(beside) @ measured / size2
            rest = np.maximum(0.0, power - np.abs(phasors) ** 2 * size2)
            least = float(np.min(rest))
            expected = noise2 + _EXACTLY**2 * (power - least) / len(measured)
            scale = max(expected, 2.0 * least / dof)
            likely = -rest / scale
            near, step = apart[likely > np.max(likely) - _LIKELY], apart[1] - apart[0]
            first, last = max(-_FARTHEST, near[0] - step), min(_FARTHEST, near[-1] + step)
        makes = phasors * kernel[:, reach]
        return _Fit(
            complex(left[reach]),
            places,
            phasors,
            makes,
            np.sqrt(0.5 * scale / size2) * np.abs(kernel[:, reach]),
            likely,
            -least / expected - len(measured) * math.log(expected),
            fisher_above(dof, _DOF_OF_FLOOR, 2.0 * least / dof / expected) < _ILL_FITTED,
        )

    def line(self, share: float) -> _Line:
        """Return what there is, on average, of a line whose probability is that `share`."""
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
        phasor = share * complex(self.phasors[at])
        untold2 = share * (1.0 - share) * (mean * toward).real ** 2
        return _Line(float(self.places[at]), phasor, math.sqrt(share * square + untold2))
