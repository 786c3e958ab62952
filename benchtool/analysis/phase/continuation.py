"""Phases of periods beyond the first and the last one, by polynomials through those next to them, or by what
foresees a swing within the record."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from benchtool.analysis.distributions import fisher_above
from benchtool.analysis.phase.predicted_phase import Prediction, prediction

FEWEST = 5
"""Phases of which a continuation is told."""

_DEGREES_AND_SIZES = ((2, 7), (2, 5), (3, 4))  # for noise, for both, and for what bends fast
_CLOSER = ((5, 6), (7, 8))  # for what swings within few periods, within half of one
_FEWEST_MISSED = 3
_REACH = 3  # periods: to where an end of the record may be, and one to spare
_LOWEST, _HIGHEST = 4, 10  # orders of the differences that noise is told by
_CLEARLY_LESS = 0.5  # of a power, by a higher order
_BY_FAR = 0.1  # of a power, by a prediction: a line between harmonics moves phases, too, and by little
_FEW, _AS_ONE = 16, 2.0  # periods; fourth differences
_BY_CHANCE = 0.025  # to either side


@dataclass(frozen=True)
class Continuation:
    """The polynomial of a `degree` through the last `size` of equally spaced phases.

    `missed2`, rad^2, is the mean square by which it misses the next phase within the record, and `noise2`
    that of noise from phase to phase.
    """

    degree: int
    size: int
    missed2: float
    noise2: float

    @property
    def reach(self) -> int:
        """How many periods it goes on before it departs."""
        return _REACH

    def weights(self, by: float) -> NDArray[np.float64]:
        """Return the weights of the last phases, shape (size,), in the phase `by` periods after the last."""
        powers = np.vander(np.arange(self.size) - (self.size - 1.0), self.degree + 1)
        return np.asarray(np.vander([by], self.degree + 1)[0] @ np.linalg.pinv(powers))

    def error2(self, by: float) -> float:
        """Return the mean square error of the phase `by` periods after the last, rad^2.

        What it misses within the record beyond the noise grows as what the next power of time adds.
        """
        foreseen, here = self.weights(1.0), self.weights(by)
        bend2 = max(0.0, self.missed2 - (1.0 + float(foreseen @ foreseen)) * self.noise2)
        terms = np.arange(self.degree + 1.0)
        return bend2 * float(np.prod((by + terms) / (1.0 + terms))) ** 2 + float(here @ here) * self.noise2


def continuation(
    phase_rad: NDArray[np.float64], amplitude: NDArray[np.float64] | None = None, *, closer: bool = False
) -> Continuation | Prediction:
    """Return the one that misses the least of phases, shape (n,) with n of at least `FEWEST`, from either
    side: a polynomial, unless a prediction by what swings within the record misses far less.

    Noise moves the `amplitude` of the periods, relative to its mean, shape (n,), as it moves the phase: of
    few periods both tell it together, where they do not differ by more than chance. Polynomials of higher
    degree are `closer` near the last phase, and err more beyond.
    """
    count, noise2 = len(phase_rad), _noise2(phase_rad)
    if amplitude is not None and count < _FEW:
        noise2 = _with_amplitude(noise2, amplitude)
    tried = (*_DEGREES_AND_SIZES, *_CLOSER) if closer else _DEGREES_AND_SIZES
    kinds = [each for each in tried if each[1] + _FEWEST_MISSED <= count]
    found = [_tried(phase_rad, *each, noise2) for each in kinds or [(2, min(5, count - 1))]]
    best = min(found, key=lambda each: each.missed2)
    swinging = prediction(phase_rad, noise2)
    if swinging is not None and swinging.missed2 < _BY_FAR * best.missed2:
        return swinging
    return best


def _noise2(phase_rad: NDArray[np.float64]) -> float:
    """Return the mean square of noise, by differences of the fourth order, or of a higher one where that has
    clearly less: what swings within few periods is in those of a low order too."""
    first, noise2 = min(_LOWEST, len(phase_rad) - 1), math.inf
    for order in range(first, max(first, min(_HIGHEST, len(phase_rad) // 3)) + 1, 2):
        other2 = float(np.mean(np.diff(phase_rad, order) ** 2)) / math.comb(2 * order, order)
        if not other2 < _CLEARLY_LESS * noise2:
            break
        noise2 = other2
    return noise2


def _with_amplitude(noise2: float, amplitude: NDArray[np.float64]) -> float:
    """Return the mean square of noise by that of phases and by amplitudes about a line, shape (n,)."""
    count = len(amplitude)
    line = np.polynomial.Polynomial.fit(np.arange(count), amplitude, 1)
    left2 = float(np.sum((amplitude - line(np.arange(count))) ** 2))
    # neighbouring differences share most of their terms: two to three of them count as one
    own, other = max(1.0, (count - _LOWEST) / _AS_ONE), count - 2.0
    ratio = left2 / other / noise2 if noise2 > 0.0 else math.inf
    if not _BY_CHANCE < fisher_above(other, own, ratio) < 1.0 - _BY_CHANCE:
        return noise2
    return (own * noise2 + left2) / (own + other)


def _tried(phase_rad: NDArray[np.float64], degree: int, size: int, noise2: float) -> Continuation:
    untried = Continuation(degree, size, 0.0, noise2)
    foreseen = untried.weights(1.0)
    missed = [
        phases[size:] - sliding_window_view(phases, size)[:-1] @ foreseen
        for phases in (phase_rad, phase_rad[::-1])
    ]
    return replace(untried, missed2=float(np.mean(np.square(missed))))
