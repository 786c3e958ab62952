"""What the variances behind an analysis of variance may be, given its mean squares: generalized inference.

A sum of squares SS with n degrees of freedom is the expected mean square times chi-squared of n. Given SS,
the expected mean square is distributed as SS / chi-squared, and what is computed from several of them as that
of independent draws. Its quantiles are a generalized confidence interval (Weerahandi, J. Am. Stat. Assoc. 88
(1993) 899; of gauge studies Hamada and Weerahandi, J. Qual. Technol. 32 (2000) 241).
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

Draws = NDArray[np.float64]

_COUNT: Final = 2**16
_TAIL: Final = 0.025  # on each side of an interval for 95 %


@dataclass(frozen=True, eq=False)
class Inferred:
    """A number of a study: its `estimate`, and what it may be, `draws` that are equally likely."""

    estimate: float
    draws: Draws

    @property
    def interval(self) -> tuple[float, float]:
        """Where it lies with 95 %."""
        low, high = np.quantile(self.draws, (_TAIL, 1.0 - _TAIL))
        return float(low), float(high)

    def probability_below(self, limit: float) -> float:
        """Return the probability that it is at most a limit."""
        return float(np.mean(self.draws <= limit))


def expected_mean_square(sum_of_squares: float, dof: int, axis: int) -> Draws:
    """Return draws of the expectation of a mean square; those of different axes are independent."""
    return sum_of_squares / _chi_squared(dof, axis)


@functools.cache
def _chi_squared(dof: int, axis: int) -> Draws:
    return np.asarray(chdtri(dof, _points()[axis]), dtype=np.float64)


@functools.cache
def _points() -> Draws:
    """Return points that fill the unit cube of five dimensions evenly, shape (5, n): a Kronecker sequence of
    powers of the root of x^6 = x + 1, by which results are the same each time."""
    root = 2.0
    for _ in range(64):
        root = (1.0 + root) ** (1.0 / 6.0)
    steps = root ** -np.arange(1.0, 6.0)
    return (0.5 + np.outer(steps, np.arange(1.0, _COUNT + 1.0))) % 1.0
