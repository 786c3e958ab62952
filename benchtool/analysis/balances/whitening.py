"""The noise of a balance of fluxes, and its innovations.

Over a tick the error of the balance is e_k = w_k + n_(k+1) - n_k: w is an error of the voltage, n that of the
measured flux at a tick. Summed up, that is a random walk seen in white noise, whose Kalman filter gives the
innovations, nu_k = e_k + (1 - K_(k-1)) nu_(k-1), which are white (J. Durbin and S. J. Koopman, Time Series
Analysis by State Space Methods, 2nd ed., 2.2). A tick that is left out ends a stretch: what follows begins
again, with the noise of two samples.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.balances.space_vectors import Complex, Floats

_SHARES: Final = 10.0 ** np.arange(-7.0, 2.5, 1.0)
_SETTLED: Final = 1e-6  # relative change of a variance


@dataclass(frozen=True)
class Whitening:
    """Filter of n balances: `carried` is 1 - K of the tick before, 0 where a stretch begins; `scale` is the
    standard deviation of an innovation over that of n, infinite where a tick is left out. Shape (n,)."""

    share: float
    carried: Floats
    scale: Floats

    @classmethod
    def of(cls, left_out: NDArray[np.bool_], share: float) -> Whitening:
        """Return the filter for a variance of w that is `share` of that of n."""
        ticks = np.arange(len(left_out))
        since = ticks - np.maximum.accumulate(np.where(left_out, ticks, -1)) - 1  # in its stretch
        variances = _innovation_variances(share, int(np.max(since, initial=0)) + 1)
        variance = variances[np.clip(since, 0, len(variances) - 1)]
        before = variances[np.clip(since - 1, 0, len(variances) - 1)]
        carried = np.where(left_out | (since == 0), 0.0, 1.0 / before)
        return cls(share, carried, np.where(left_out, math.inf, np.sqrt(variance)))

    def filtered(self, columns: Complex) -> Complex:
        """Return the innovations of columns, shape (n,) or (n, m), not yet over `scale`."""
        from scipy.linalg import solve_banded

        bands = np.ones((2, len(self.carried)))
        bands[1, :-1] = -self.carried[1:]
        found: Complex = solve_banded((1, 0), bands, columns, overwrite_ab=True, check_finite=False)
        return found


def _innovation_variances(share: float, longest: int) -> Floats:
    """Return the variance of the innovations of a stretch over that of n, until it changes no more."""
    found, variance = [], 1.0
    for _ in range(longest):
        predicted = variance + share
        innovation = predicted + 1.0
        found.append(innovation)
        settled = abs(predicted / innovation - variance) < _SETTLED * variance
        variance = predicted / innovation
        if settled:
            break
    return np.array(found)


def likeliest(errors: Complex, left_out: NDArray[np.bool_]) -> Whitening:
    """Return the filter under which errors of a balance, shape (n,), are most likely to be normal noise."""
    candidates = (Whitening.of(left_out, share) for share in _SHARES)
    return min(candidates, key=lambda each: _minus_log_likelihood(each, errors))


def _minus_log_likelihood(filter_: Whitening, errors: Complex) -> float:
    """Return twice the negative logarithm, with the variance of n that makes it largest."""
    kept = np.isfinite(filter_.scale)
    scale = filter_.scale[kept]
    innovations = filter_.filtered(errors)[kept] / scale
    variance = float(np.mean(np.abs(innovations) ** 2))
    return 2.0 * len(scale) * math.log(max(variance, np.finfo(np.float64).tiny)) + 4.0 * float(
        np.sum(np.log(scale))
    )
