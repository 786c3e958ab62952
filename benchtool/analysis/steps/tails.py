"""The slowest tail of an answer: how long it is seen in the noise, and how it goes on in samples at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.steps.smoothing import Noise

Floats = NDArray[np.float64]

LITTLE = 0.1
"""Of the noise: a tail of which less is left is not seen in it."""

_FEWEST = 20  # samples that a tail shows in
_CERTAIN = 5.0  # standard uncertainties of a tail in samples at rest, of which more are slow
_ALIKE = 2.5  # times as far as it was on its way there, at most, or as little
_HALVES = np.geomspace(0.5, 2.0, 9)  # times as many rows as it halved in on its way


@dataclass(frozen=True)
class Tail:
    """A course that is so far `away` from its last level in a row `at`, and half as far `half` rows later."""

    at: int
    away: float
    half: int

    @classmethod
    def of(cls, away: Floats, band: float) -> Tail:
        """Return the tail of a course so far `away` from its last level, shape (n,): that by which it leaves
        the outer half of the band within which it has settled."""
        size = np.abs(away)
        last, halved = (int(np.max(np.flatnonzero(size > each), initial=0)) for each in (band, 0.5 * band))
        return cls(halved, math.copysign(0.5 * band, away[halved]), halved - last)

    def end(self, noise: float) -> int:
        """Return the row from which less than a tenth of the rms of the noise is left; 0 where there is no
        noise, or more than that."""
        little = LITTLE * noise
        if not 0.0 < little < 2.0 * abs(self.away):
            return 0
        return self.at + math.ceil(self.half * math.log2(abs(self.away) / little))

    def goes_on_in(self, samples: Floats, row: int) -> Floats | None:
        """Return the course of samples from a `row` on, shape (n,), if they have the tail as well: beyond
        their noise, and as large as it has been until then. A walk of noise is neither."""
        if self.half < 1 or row < self.at or len(samples) < _FEWEST:
            return None
        expected = self.away * 2.0 ** (-(row - self.at) / self.half)
        rows = np.arange(len(samples))
        found = [_fitted(samples, 2.0 ** (-rows / (share * self.half))) for share in _HALVES.tolist()]
        size, course, weights = min(found, key=lambda each: float(np.sum((samples - each[1]) ** 2)))
        standard = Noise.of(samples - course).of_sum(weights)
        if not _CERTAIN * standard < abs(size) or not 1.0 / _ALIKE < size / expected < _ALIKE:
            return None
        return course


def _fitted(samples: Floats, shape: Floats) -> tuple[float, Floats, Floats]:
    """Return the size of an exponential of this shape above a level, by least squares, the course, and by
    which weights of the samples that is its size."""
    across = shape - np.mean(shape)
    weights = np.asarray(across / float(across @ across), dtype=np.float64)
    size = float(weights @ samples)
    return size, np.asarray(np.mean(samples) + size * across), weights
