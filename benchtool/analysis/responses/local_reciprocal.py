"""A response between frequencies that no parabola follows: polynomials through its reciprocals.

Gain and phase bend about every pole, the more the nearer it is. The reciprocal of a response does not: of two
poles it is a parabola of frequency, whatever their damping, and with a dead time it has no poles at all. A
cubic through the reciprocals at two frequencies on either side tells the response between them, and quartics
through one more on either side what that leaves out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]

_CUBIC = -2, 2
_QUARTICS = (-3, 2), (-2, 3)
_PARABOLAS = (-2, 1), (-1, 2)
_NEAR = -3, 3  # all that these rest on
_FEWEST = 4  # values of a parabola over a line
_CLEARLY = 3.0  # standard deviations


@dataclass(frozen=True)
class LocalReciprocal:
    """Reciprocals of a response and their relative standard uncertainties of one component, shape (n,), at
    rising frequencies.

    The uncertainties are those to use as if they were uncorrelated, where so many frequencies, `shared`,
    shape (n,), tell as much as one: those of one are smaller by its root, and correlated over so many.
    """

    frequency_Hz: Floats
    reciprocal: Complex
    error: Floats
    shared: Floats | None = None

    def between(self, at: int, fine_Hz: Floats) -> tuple[Complex, Floats]:
        """Return the reciprocals at frequencies, shape (m,), between the one before `at` and that, and their
        relative standard uncertainties of one component.

        What two polynomials differ by is along the response or across it, which of both does not show: each
        has half of its square. What the errors make them differ by is no part of it.
        """
        cubic = self._window(*_CUBIC, at)
        wider = [each for ends in _QUARTICS if (each := self._window(*ends, at)) != cubic]
        others = wider or [self._window(*ends, at) for ends in _PARABOLAS]
        weights = self._weights(cubic, fine_Hz)
        found = weights @ self.reciprocal
        of_errors = self._of_errors(at, weights)
        apart = np.stack([self._weights(other, fine_Hz) - weights for other in others])
        square, by_chance = np.abs(apart @ self.reciprocal) ** 2, 2.0 * self._of_errors(at, apart)
        left = np.mean(np.maximum(square - by_chance, 0.0), axis=0)
        if (slope := self._line_below(cubic)) is not None:
            over_a_line = (
                weights @ (self.reciprocal * (1.0 + slope * self.frequency_Hz)) / (1.0 + slope * fine_Hz)
            )
            left = np.maximum(left, np.abs(over_a_line - found) ** 2)
        size = np.maximum(np.abs(found), np.finfo(np.float64).tiny)
        return found, np.sqrt(of_errors + 0.5 * left) / size

    def _of_errors(self, at: int, weights: Floats) -> Floats:
        """Return the variance of one component of sums of the reciprocals about `at` with weights, shape
        (..., n): of running means over `shared` places each, which are less alike the further apart."""
        first, end = self._window(*_NEAR, at)
        spread = self.error[first:end] * np.abs(self.reciprocal[first:end])
        near = weights[..., first:end]
        if self.shared is None:
            return np.asarray(near**2 @ spread**2)
        shared, place = self.shared[first:end], np.arange(first, end)
        spread = spread / np.sqrt(shared)
        least = np.minimum(shared, shared[:, np.newaxis])
        alike = np.maximum(0.0, 1.0 - np.abs(place - place[:, np.newaxis]) / least)
        return np.asarray(np.einsum("...j,jk,...k->...", near, spread * alike * spread[:, np.newaxis], near))

    def _line_below(self, window: tuple[int, int]) -> complex | None:
        """Return the slope of a line, 1 at zero: a parabola over it passes through four reciprocals. Its pole
        is a zero of the response. None where errors alone may make them bend as they do, or where the cubic
        through them comes nearer to the reciprocals beside them."""
        near, beside = slice(*window), [at for at in (window[0] - 1, window[1]) if self._has(at)]
        places, values = self.frequency_Hz[near], self.reciprocal[near]
        apart = places[:, np.newaxis] - places + np.eye(len(places))
        thirds = 1.0 / np.prod(apart, axis=1)  # divided difference
        bend, by_chance = thirds @ values, np.linalg.norm(thirds * self.error[near] * values)
        of_line = thirds @ (places * values)
        if len(places) < _FEWEST or abs(bend) < _CLEARLY * math.sqrt(2.0) * by_chance or of_line == 0.0:
            return None
        slope = complex(-bend / of_line)
        weights, line = self._weights(window, self.frequency_Hz[beside]), 1.0 + slope * self.frequency_Hz
        cubic, other = weights @ self.reciprocal, weights @ (self.reciprocal * line) / line[beside]
        missed, other_missed = (np.sum(np.abs(each - self.reciprocal[beside])) for each in (cubic, other))
        return None if len(beside) and missed < other_missed else slope

    def _has(self, at: int) -> bool:
        return 0 <= at < len(self.frequency_Hz)

    def _window(self, before: int, after: int, at: int) -> tuple[int, int]:
        return max(0, at + before), min(len(self.frequency_Hz), at + after)

    def _weights(self, window: tuple[int, int], fine_Hz: Floats) -> Floats:
        """Return by how much each reciprocal counts in Lagrange's polynomial through a window of them, at
        frequencies of shape (m,), shape (m, n)."""
        places = self.frequency_Hz[slice(*window)]
        weights = np.zeros((len(fine_Hz), len(self.frequency_Hz)))
        for k, place in enumerate(places):
            others = np.delete(places, k)
            weights[:, window[0] + k] = np.prod((fine_Hz[:, np.newaxis] - others) / (place - others), axis=1)
        return weights
