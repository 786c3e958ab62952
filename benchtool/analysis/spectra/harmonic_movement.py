"""What moves a harmonic over a record, once what moves others is taken off: its amplitude and its phase.

A speed moves the phases of all harmonics alike, of which k turns k times as far; a line beside one of them
moves amplitude and phase of that alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Complex = NDArray[np.complex128]

SIZES = math.log(1e4)  # of any amplitude from the noise to ten thousand times as much, in the logarithm
_STANDS_OUT = 5.0  # of the noise, of harmonics that tell what the speed does
_COURSES = np.append(0.0, np.exp(np.linspace(0.0, SIZES, 47)))  # rms of a phase, over its noise
_WEIGHTS = np.append(0.5, np.full(47, 0.5 / 47))  # of none, and of any


def parts_of(around: Complex) -> tuple[Complex, Complex]:
    """Return what moves the relative amplitude of harmonics, and what moves their phase, in the bins above
    them, both of shape (..., reach), of all bins around them, shape (..., 2 reach + 1)."""
    reach = around.shape[-1] // 2
    relative = around / around[..., reach, np.newaxis]
    upper, lower = relative[..., reach + 1 :], np.conj(relative[..., :reach][..., ::-1])
    return 0.5 * (upper + lower), 0.5 * (upper - lower)


def evenly(of_phase: Complex) -> Floats:
    """Return by how much phases move evenly over the record, over 2 pi, of what moves them in the bins above
    a harmonic, shape (..., reach)."""
    weight = 1.0 / np.arange(1.0, of_phase.shape[-1] + 1.0)
    return np.asarray(of_phase.real @ weight / float(weight @ weight))


def evenly_by_noise(of_phase2: Floats | float, reach: int) -> Floats:
    """Return the standard deviation of that by noise of these mean squares in a bin."""
    weight = 1.0 / np.arange(1.0, reach + 1.0)
    return np.asarray(np.sqrt(0.5 * of_phase2 / float(weight @ weight)))


@dataclass(frozen=True)
class Movement:
    """What moves a harmonic of the phasor `harmonic`, at the bin `number`, by itself: its relative
    `amplitude` and its `phase`, in the bins above it, both of shape (reach,), and the mean squares of the
    noise in these, `of_amplitude2` and `of_phase2`."""

    harmonic: complex
    number: int
    amplitude: Complex
    phase: Complex
    of_amplitude2: float
    of_phase2: float

    @property
    def reach(self) -> int:
        """Bins to either side."""
        return len(self.phase)

    @property
    def moved(self) -> float:
        """By how much the phase moves evenly, over the standard deviation of that by noise."""
        return float(np.abs(evenly(self.phase)) / self.evenly_by_noise)

    @property
    def evenly_by_noise(self) -> float:
        """That standard deviation, over 2 pi."""
        return float(evenly_by_noise(self.of_phase2, self.reach))

    @property
    def chi2_of_amplitude(self) -> float:
        """What moves the amplitude, over its noise."""
        return float(np.sum(np.abs(self.amplitude) ** 2)) / self.of_amplitude2

    @property
    def chi2_of_phase(self) -> Floats:
        """What moves the phase, over its noise, shape (reach,)."""
        return np.asarray(np.abs(self.phase) ** 2 / self.of_phase2)

    def by_itself(self, scale: float) -> float:
        """Return the logarithm of the likelihood of a phase that moves by itself, with the noise `scale`
        times as large."""
        return _of_course(self.phase, scale * self.of_phase2) - self.chi2_of_amplitude / scale

    def both_by_themselves(self, scale: float) -> float:
        """Return that of an amplitude and a phase that each move by themselves."""
        of_amplitude = _of_course(1j * self.amplitude, scale * self.of_amplitude2)
        return of_amplitude + _of_course(self.phase, scale * self.of_phase2)


def _of_course(moved: Complex, noise2: float) -> float:
    """Return the logarithm of the likelihood of what moves a phase, shape (reach,), or an amplitude, times j,
    in noise of this mean square: evenly, or along a parabola, whose bins are real and imaginary, or both, and
    besides slowly more than fast; each by any amount, in the logarithm, or not at all."""
    order = np.arange(1.0, len(moved) + 1.0)
    rise = 1.0 + (_COURSES[:, np.newaxis] / order) ** 2
    risen2 = noise2 * rise
    likely = -np.sum(np.abs(moved) ** 2 / risen2 + np.log(rise), axis=1)
    for part, course in ((moved.real, 1.0 / order), (moved.imag, 1.0 / order**2)):
        explained = (part * course / risen2).sum(axis=1) ** 2 / (course**2 / risen2).sum(axis=1)
        any_size = 0.5 * np.log(math.pi / np.maximum(explained, 1.0)) - math.log(2.0 * SIZES)
        likely += np.logaddexp(0.0, np.minimum(0.0, any_size) + explained) - math.log(2.0)
    most = float(np.max(likely))
    return most + math.log(float(_WEIGHTS @ np.exp(likely - most)))


def movements_of(around: Complex, floor2: Floats, index: int, number: int) -> list[Movement]:
    """Return how a harmonic at the bin `number` may move by itself, once what moves others is taken off,
    first whatever their amplitudes do; none of a fundamental that no others tell of.

    A speed moves all phases, whatever the amplitudes do. The fundamental tells it best, but for a line beside
    that. So do the harmonics together: their scatter is that of noise, or more where they do not agree.
    """
    reach = around.shape[1] // 2
    order, middle = np.arange(1, len(around) + 1), around[:, reach]
    size2, own = np.abs(middle) ** 2, index + 1
    known = np.flatnonzero((size2 > _STANDS_OUT**2 * floor2) & (order != own))
    amplitude, phase = parts_of(around[known])
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
    of_amplitude, of_phase = parts_of(around[index])
    own2 = 0.5 * float(floor2[index] / size2[index])
    return [
        Movement(
            complex(middle[index]),
            number,
            of_amplitude - with_amplitude,
            of_phase - with_phase,
            own2 + amplitude2,
            own2 + phase2,
        )
        for with_amplitude, amplitude2 in amplitudes
        for with_phase, phase2 in phases
    ]


def _together(values: Complex, noise2: Floats) -> tuple[Complex, float]:
    """Return the mean of values, shape (harmonics, bins), each weighted by its noise, and its mean square
    error, by their scatter if that is more than the noise."""
    weight = 1.0 / noise2
    mean = weight @ values / np.sum(weight)
    scatter = float(np.sum(weight[:, np.newaxis] * np.abs(values - mean) ** 2))
    excess = max(1.0, scatter / ((len(values) - 1) * values.shape[1]))
    return mean, excess / float(np.sum(weight))
