"""Windows of a balance of torque, by a function phi that is zero at both ends of each.

phi is the polygon through (1 - s^2)^3 at the ticks, s from -1 to 1 over a window. Its second derivative is
impulses at the ticks, so that the integral of phi'' theta_m takes the angle where it is measured and nowhere
else: sampled derivatives of the curve itself would make an inertia 2e-4 too small at 200 ticks a window. A
torque that is straight between the ticks is integrated exactly.

The errors of windows that overlap are correlated. Their covariance is that of white noise of the torque and
of the angle, whose one ratio is the likeliest (restricted likelihood: H. D. Patterson and R. Thompson,
Biometrika 58 (1971) 545). Taken for independent they would be off by a factor of 0.6 to 4: what they leave
is mostly fast noise of the angle, which hardly reaches an inertia or a friction.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.balances.space_vectors import Floats

WINDOW: Final = 200
"""Ticks of a window, between the zeros of phi."""

HOP: Final = 50
"""Ticks from one window to the next: phi passes little that would be faster than two of these."""

_SPAN: Final = WINDOW + 2  # samples that a window takes
_BESIDE: Final = (_SPAN - 1) // HOP  # windows that overlap one, on either side
_SHARES: Final = 10.0 ** np.arange(-4.0, 6.25, 0.25)  # of the angle's noise in a window over the torque's
_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Modulation:
    """Windows of samples at ticks `T_s` apart, which begin at `starts`, shape (m,).

    Samples that are summed with `weight`, `first` or `second`, of shape (ticks,), come to the integral of phi
    times them, or of its first or second derivative.
    """

    T_s: float
    starts: NDArray[np.int64]
    weight: Floats
    first: Floats
    second: Floats

    @classmethod
    def of(cls, direction: NDArray[np.int64], T_s: float) -> Self:
        """Return the windows throughout which `direction`, shape (n,), is the same and not zero."""
        s = (2.0 * np.arange(WINDOW) + 1.0) / WINDOW - 1.0
        phi = np.pad((1.0 - s * s) ** 3, 2)
        before, here, after = phi[:-2], phi[1:-1], phi[2:]
        starts = np.empty(0, dtype=np.int64)
        if len(direction) >= _SPAN:
            same = np.abs(np.sum(_views(direction), axis=1)) == _SPAN
            starts = HOP * np.flatnonzero(same)
        return cls(
            T_s,
            starts,
            T_s * (before + 4.0 * here + after) / 6.0,
            0.5 * (after - before),
            (before - 2.0 * here + after) / T_s,
        )

    def samples(self, of_ticks: Floats) -> Floats:
        """Return samples, shape (n,), in each window, shape (m, ticks)."""
        return np.asarray(_views(of_ticks)[self.starts // HOP])

    def whitened(self, columns: Floats, sides: Floats, least_Nm: float = 0.0) -> tuple[Floats, Floats]:
        """Return equations of the windows, shapes (m, unknowns) and (m, sides), turned so that their errors
        are uncorrelated and of one variance, under the ratio of the noise of angle and torque that is the
        likeliest by the first side.

        The torque has no less noise than `least_Nm` in each sample: few windows do not tell it beside the
        angle's, and may be as likely without any.
        """
        of_torque, of_angle = (self._covariance(each) for each in (self.weight, self.second))
        least = least_Nm**2 * float(np.sum(self.weight**2))
        turned = [_turned(of_torque + share * of_angle, columns, sides) for share in _SHARES]
        possible = [each for each in turned if each.variance >= least] or turned[:1]
        best = min(possible, key=lambda each: each.minus_log_likelihood)
        return best.columns, best.sides

    def _covariance(self, weight: Floats) -> Floats:
        """Return the covariance of sums of white noise with a weight, over the variance of one, as lower
        bands, shape (bands, m)."""
        lags = np.correlate(weight, weight, "full")[len(weight) - 1 :]
        lags = np.append(lags / lags[0], 0.0)
        count = len(self.starts)
        found = np.zeros((min(_BESIDE + 1, count), count))
        for band in range(len(found)):
            apart = self.starts[band:] - self.starts[: count - band]
            found[band, : count - band] = lags[np.minimum(apart, len(lags) - 1)]
        return found


@dataclass(frozen=True)
class _Turned:
    """Equations with uncorrelated errors, the variance of these in the first side, and twice the negative
    logarithm of its restricted likelihood."""

    columns: Floats
    sides: Floats
    variance: float
    minus_log_likelihood: float


def _turned(covariance: Floats, columns: Floats, sides: Floats) -> _Turned:
    """Return equations in which a covariance, as lower bands, is turned into that of white noise."""
    from scipy.linalg import cholesky_banded, solve_banded

    factor = cholesky_banded(covariance, lower=True)
    turned = solve_banded((len(factor) - 1, 0), factor, np.column_stack([columns, sides]))
    of_columns, of_sides = np.split(turned, [columns.shape[1]], axis=1)
    left, sizes, _ = np.linalg.svd(of_columns / np.linalg.norm(columns, axis=0), full_matrices=False)
    kept = sizes > _ROUNDING * sizes[0]  # unknowns that windows of one direction do not tell apart count once
    rest = of_sides[:, 0] - left[:, kept] @ (left[:, kept].T @ of_sides[:, 0])
    freedom = max(1, len(rest) - int(np.count_nonzero(kept)))
    variance = max(float(np.sum(rest**2)) / freedom, sys.float_info.min)
    minus_log = freedom * math.log(variance) + 2.0 * float(np.sum(np.log(factor[0])))
    minus_log += 2.0 * float(np.sum(np.log(sizes[kept])))
    return _Turned(of_columns, of_sides, variance, minus_log)


def _views(of_ticks: NDArray[np.float64] | NDArray[np.int64]) -> Floats:
    """Return the samples of every window, shape (windows, ticks)."""
    return np.asarray(np.lib.stride_tricks.sliding_window_view(of_ticks, _SPAN)[::HOP], dtype=np.float64)
