"""Ordinary least squares with the covariance of its solution."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.errors import AnalysisError


@dataclass(frozen=True)
class Fit:
    """Solution x of y = A x, shape (m,), with its covariance, shape (m, m), from the scatter about the fit.

    `scatter` is the standard deviation of a row of y about the fit, with `dof` degrees of freedom.
    """

    x: NDArray[np.float64]
    covariance: NDArray[np.float64]
    scatter: float
    dof: float
    residuals: NDArray[np.float64]

    def standard(self, k: int) -> float:
        """Return the standard uncertainty of x[k]."""
        return math.sqrt(float(self.covariance[k, k]))


def least_squares(A: NDArray[np.float64], y: NDArray[np.float64], *, lost_dof: int = 0) -> Fit:
    """Return the solution of least squares.

    Args:
        A: regressors, shape (n, m).
        y: observations, shape (n,), all with the same scatter.
        lost_dof: degrees of freedom that were used before, such as one for each mean that was taken off.

    Raises:
        AnalysisError: fewer observations than unknowns, or unknowns that the data cannot tell apart.
    """
    n, m = A.shape
    dof = n - m - lost_dof
    if dof < 1:
        raise AnalysisError(
            f"{n - lost_dof} observations of {m} unknowns leave no scatter to judge by: record more"
        )
    scale = np.sqrt(np.mean(A * A, axis=0))
    scale[scale == 0.0] = 1.0
    inverse = np.linalg.pinv((A / scale).T @ (A / scale), rcond=1e-12)
    if np.linalg.matrix_rank(A / scale, tol=1e-9 * math.sqrt(n)) < m:
        raise AnalysisError("the unknowns cannot be told apart by these data: vary what is excited")
    inverse = inverse / np.outer(scale, scale)
    x = inverse @ (A.T @ y)
    residuals = y - A @ x
    scatter = math.sqrt(float(residuals @ residuals) / dof)
    return Fit(x, scatter**2 * inverse, scatter, float(dof), residuals)
