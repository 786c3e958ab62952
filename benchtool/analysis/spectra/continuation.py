"""Phases of periods beyond the first and the last one, by polynomials through those next to them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

FEWEST = 5
"""Phases of which a continuation is told."""

_DEGREES_AND_SIZES = ((2, 7), (2, 5), (3, 4))  # for noise, for both, and for what bends fast
_FEWEST_MISSED = 3


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


def continuation(phase_rad: NDArray[np.float64]) -> Continuation:
    """Return the one that misses the least of phases, shape (n,) with n of at least `FEWEST`, from either
    side."""
    count = len(phase_rad)
    kinds = [each for each in _DEGREES_AND_SIZES if each[1] + _FEWEST_MISSED <= count]
    found = [_tried(phase_rad, *each) for each in kinds or [(2, min(5, count - 1))]]
    return min(found, key=lambda each: each.missed2)


def _tried(phase_rad: NDArray[np.float64], degree: int, size: int) -> Continuation:
    order = min(4, len(phase_rad) - 1)
    noise2 = float(np.mean(np.diff(phase_rad, order) ** 2)) / math.comb(2 * order, order)
    untried = Continuation(degree, size, 0.0, noise2)
    foreseen = untried.weights(1.0)
    missed = [
        phases[size:] - sliding_window_view(phases, size)[:-1] @ foreseen
        for phases in (phase_rad, phase_rad[::-1])
    ]
    return replace(untried, missed2=float(np.mean(np.square(missed))))
