"""The slowest tail of an answer: how long it is seen in the noise, and how it goes on in samples at rest."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from benchtool.analysis.steps.smoothing import Noise, is_noisier

Floats = NDArray[np.float64]

LITTLE = 0.1
"""Of the noise: a tail of which less is left is not seen in it."""

_FEWEST = 20  # samples that a tail shows in
_PIECES = 4  # the last and those before it
_CERTAIN = 5.0  # standard uncertainties of a tail in samples at rest, of which more are slow
_ALIKE = 2.5  # times as far as it was on its way there, at most, or as little
_DEGREES = 4  # of a course in a tenth of a record, which is little of a turn
_DIES_AWAY = 1.0 / 3.0  # of the mean square bend of earlier samples
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


def without_course(samples: Floats, count: int, before: Floats) -> Floats:
    """Return the last `count` samples, of shape (n,), about their level without the course of an answer that
    is still on its way in them: it is no noise.

    An answer has a course where its polynomial of fourth degree bends by more than the noise of the samples
    `before` the step makes it, in either of its three coefficients beyond a line, and dies away: earlier
    pieces as long bend more, as they do not of a ripple that stays. What is about that polynomial is the
    noise, for the degrees of freedom that are left, unless that is more than before the step.
    """
    last, noise = samples[-count:], Noise.of(before)
    if count < _FEWEST or len(before) < count or len(samples) < _PIECES * count or not noise.rms > 0.0:
        return last
    basis, _ = np.linalg.qr(legendre.legvander(np.linspace(-1.0, 1.0, count), _DEGREES))
    sizes = samples[-_PIECES * count :].reshape(_PIECES, count)[::-1] @ basis
    bends = sizes[:, 2:]
    by_noise = np.array([noise.of_sum(each) for each in basis.T[2:]])
    now, *earlier = np.sum(bends**2, axis=1)
    if not (np.any(np.abs(bends[0]) > _CERTAIN * by_noise) and now < _DIES_AWAY * np.mean(earlier)):
        return last
    left = (last - basis @ sizes[0]) * math.sqrt((count - 2) / (count - _DEGREES - 1))
    is_more = is_noisier(Noise.of(left).autocovariance, count, noise.autocovariance, len(before))
    return last if is_more else left


def _fitted(samples: Floats, shape: Floats) -> tuple[float, Floats, Floats]:
    """Return the size of an exponential of this shape above a level, by least squares, the course, and by
    which weights of the samples that is its size."""
    across = shape - np.mean(shape)
    weights = np.asarray(across / float(across @ across), dtype=np.float64)
    size = float(weights @ samples)
    return size, np.asarray(np.mean(samples) + size * across), weights
