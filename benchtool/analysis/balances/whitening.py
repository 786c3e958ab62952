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
        carried, scale = np.empty(len(left_out)), np.empty(len(left_out))
        variance, before = 1.0, 0.0
        for k, out in enumerate(left_out.tolist()):
            if out:
                carried[k], scale[k], variance, before = 0.0, math.inf, 1.0, 0.0
                continue
            predicted = variance + share
            innovation = predicted + 1.0
            carried[k], scale[k] = before, math.sqrt(innovation)
            before = 1.0 / innovation
            variance = predicted * before
        return cls(share, carried, scale)

    def filtered(self, columns: Complex) -> Complex:
        """Return the innovations of columns, shape (n, m), not yet over `scale`."""
        found, last = np.empty_like(columns), np.zeros(columns.shape[1], dtype=np.complex128)
        for k, carried in enumerate(self.carried.tolist()):
            last = columns[k] + carried * last
            found[k] = last
        return found

    def innovations(self, errors: Complex) -> Complex:
        """Return those of the errors of a balance, shape (n,), not yet over `scale`."""
        found, last = [], 0j
        for error, carried in zip(errors.tolist(), self.carried.tolist(), strict=True):
            last = error + carried * last
            found.append(last)
        return np.array(found)


def likeliest(errors: Complex, left_out: NDArray[np.bool_]) -> Whitening:
    """Return the filter under which errors of a balance, shape (n,), are most likely to be normal noise."""
    candidates = (Whitening.of(left_out, share) for share in _SHARES)
    return min(candidates, key=lambda each: _minus_log_likelihood(each, errors))


def _minus_log_likelihood(filter_: Whitening, errors: Complex) -> float:
    """Return twice the negative logarithm, with the variance of n that makes it largest."""
    kept = np.isfinite(filter_.scale)
    scale = filter_.scale[kept]
    innovations = filter_.innovations(errors)[kept] / scale
    variance = float(np.mean(np.abs(innovations) ** 2))
    return 2.0 * len(scale) * math.log(max(variance, np.finfo(np.float64).tiny)) + 4.0 * float(
        np.sum(np.log(scale))
    )
