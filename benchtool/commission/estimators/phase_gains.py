"""How the gains of three current sensors differ: the currents of a star without neutral add up to zero."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import least_squares


@dataclass(frozen=True)
class PhaseGains:
    """Factors, shape (3,), that make the readings of three sensors agree, with a mean of 1; their standard
    uncertainties and degrees of freedom.

    What all three have in common cannot be seen by the currents alone.
    """

    corrections: NDArray[np.float64]
    standard: NDArray[np.float64]
    dof: float


def phase_gains(readings_A: NDArray[np.float64]) -> PhaseGains:
    """Return the corrections from readings of shape (n, 3) with currents of several directions.

    With c = 1 + e and e_a + e_b + e_c = 0, the sum of c i over the phases is zero: two unknowns, by least
    squares, with a common constant for what is left of the offsets.

    Raises:
        AnalysisError: too few readings, or currents of one direction only.
    """
    a, b, c = readings_A.T
    regressors = np.column_stack((a - c, b - c, np.ones(len(a))))
    fit = least_squares(regressors, -(a + b + c))
    e_a, e_b = float(fit.x[0]), float(fit.x[1])
    both = fit.covariance[:2, :2]
    u_c = math.sqrt(float(both.sum()))
    standard = np.array([fit.standard(0), fit.standard(1), u_c])
    return PhaseGains(1.0 + np.array([e_a, e_b, -e_a - e_b]), standard, fit.dof)
