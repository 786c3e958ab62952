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
from benchtool.analysis.noise.converter_lines import aliased_quantisation
from benchtool.analysis.noise.noise import harmonic_noise
from benchtool.analysis.spectra.harmonic_movement import (
    SIZES,
    Movement,
    evenly,
    evenly_by_noise,
    movements_of,
    parts_of,
)
from benchtool.analysis.spectra.interharmonics import Interharmonics, sinusoid
from benchtool.analysis.spectra.line_beside import (
    DOF_OF_FLOOR,
    Kernel,
    LineFit,
    kernel_along_phase,
    kernel_in_time,
)
from benchtool.analysis.spectra.moving_tones import Course, MovingTone

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]
Integers = NDArray[np.int64]

_REACH = 8  # bins to either side
_BEFORE = 0.02  # one line beside fifty harmonics
_LEAST_SHARE = 0.01
_BY_ITSELF = 5.0  # times as likely as a line: the angle between the fundamental and all others moves
_SURELY, _CLEARLY = 0.999, 60.0  # share; chi squared: by chance once in 1e13
_ROUNDS = 3  # as lines leak into the noise beside other harmonics
_MOVES = 0.01  # periods of a line steady in time, along the phase
_THE_SAME = 0.1  # bins


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
            seen = around
            if own is not None:  # what it makes of itself by its negative frequency stays out
                above, below = own.of_bins(number, count)
                below[index] = 0.0
                # and of other harmonics, by which it is told what moves them
                seen = around.copy()
                around += above + below
                seen[index] = around[index]
            line = _beside(seen, floor2, index, number[index], count, course)
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


def _stands_out(around: Complex, floor2: Floats) -> NDArray[np.bool_]:
    """Return which harmonics may have a line beside, shape (harmonics,), of the bins `around` them, shape
    (harmonics, 2 reach + 1), with mean squares `floor2` of noise.

    Those whose phase moves if nothing else moves it, and the fundamental, which is not told without others.
    """
    reach = around.shape[1] // 2
    size2 = np.abs(around[:, reach]) ** 2
    known = (floor2 > 0.0) & (size2 > 0.0)  # nan is not
    _, of_phase = parts_of(around[known])
    moved = np.abs(evenly(of_phase)) / evenly_by_noise(0.5 * floor2[known] / size2[known], reach)
    found = known.copy()
    found[known] = _share(moved) >= _LEAST_SHARE
    found[0] = known[0]
    return found


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
    movements = movements_of(around, floor2, index, int(number[reach]))
    if not movements:
        return None
    moved = min(each.moved for each in movements)
    moves = float(_share(moved))
    fundamental = float(np.abs(around[0, reach]))
    along_phase = partial(kernel_along_phase, reach=reach, count=count)
    # one that begins at some phases, or is about 1.45 bins away, moves the phase to and fro alone
    if moves < _SURELY and index == 0:
        moves = max(moves, _share_by_all(movements, fundamental, along_phase))
    if moves < _LEAST_SHARE:
        return None
    best = _best_fit(movements, fundamental, along_phase)
    in_time = False
    if course is not None and moves_along(course, float(number[-1])):
        in_time_alone = lru_cache(
            partial(kernel_in_time, number=int(number[reach]), reach=reach, course=course)
        )
        other = _best_fit(movements, fundamental, in_time_alone)
        in_time = other.explains > best.explains
        best = other if in_time else best
    found = best.line(moves, 0.0 if index else _BY_ITSELF)
    if in_time and abs(found.place - float(number[reach])) < _THE_SAME:
        return None  # it is the harmonic itself, of a phase that is not followed quite
    of_move = movements[-1].evenly_by_noise * math.sqrt(found.share * (1.0 + (1.0 - found.share) * moved**2))
    line = _Line(found.place, found.phasor, found.standard, 2.0 * math.pi * of_move)
    if not in_time or not line.phasor or course is None:
        return line
    return replace(line, transformed=fft.fft(line.tone.at(course)) / count)


def _share_by_all(
    movements: Sequence[Movement], fundamental: float, kernel: Callable[[float, float], Kernel]
) -> float:
    """Return the probability that one line explains all that moves the fundamental, where that is far more
    than noise; 0 where it is not.

    Whether the others have its amplitude in common, they tell where they are large enough. Else it is a line
    or an amplitude and a phase that each move by themselves, as is the rule.
    """
    fits = [LineFit.of(each, fundamental, kernel) for each in movements]
    if all(each.explained > _CLEARLY and not each.is_ill for each in fits):
        return 1.0
    alone = fits[0]  # whatever the amplitudes of others do
    if alone.is_ill or not alone.explained > _CLEARLY:
        return 0.0
    return alone.share_of_lines(alone.movement.both_by_themselves(alone.scale), 1.0 / _BEFORE)


def _best_fit(
    movements: Sequence[Movement], fundamental: float, kernel: Callable[[float, float], Kernel]
) -> LineFit:
    """Return the fit that explains most of what moves a harmonic, of those that noise may leave, or else of
    all."""
    fits = [LineFit.of(each, fundamental, kernel) for each in movements]
    return max(fits, key=lambda each: (not each.is_ill, each.explains))


def moves_along(course: Course, place: float) -> bool:
    """Return whether what is steady in time moves along the phase, at a place or below, in bins."""
    return place * float(np.max(np.abs(course.passed - course.turned))) > _MOVES


def _share(moved: Floats | float) -> Floats:
    """Return the probability of a line that moves a phase by so many standard deviations of noise.

    Of a move x of any size, in the logarithm, as likely as any other over a range of exp(L) the Bayes factor
    is exp(x^2 / 2) sqrt(2 pi) / (2 L x), here of Student's distribution, as the noise is not quite known.
    """
    above = np.maximum(moved, 1.0)
    likely = 0.5 * (DOF_OF_FLOOR + 1.0) * np.log1p(above**2 / DOF_OF_FLOOR)
    odds = math.log(_BEFORE * math.sqrt(2.0 * math.pi) / (2.0 * SIZES)) + likely - np.log(above)
    return np.where(above > 1.0, 1.0 / (1.0 + np.exp(-odds)), 0.0)
