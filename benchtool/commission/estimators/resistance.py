"""Resistance, and the voltage that dead time and devices take, from standing currents.

At a standing current the mean voltage that is asked of the inverter is

    u_s = R_s i_s + V_drop s(i) + u_0,   s(i) the vector of sgn(i_a), sgn(i_b), sgn(i_c),

with V_drop = t_d / T_s u_dc and the forward voltage of a device (Holtz and Quan, IEEE Trans. Ind. Appl. 38
(2002) no. 4; s(i) holds where no phase is near zero), and a constant u_0 for what is left of the sensors'
offsets. It is linear in R_s, V_drop and u_0. One level of current cannot tell R_s from V_drop. Phases that
differ, by a poor contact or by shorted turns, each take R_x i_x along their own direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.phase_gains import PhaseGains, phase_gains
from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.estimators.vectors import drop_vector, vector_of
from benchtool.errors import AnalysisError

_CLEAR = 0.1  # of the largest current: below it the sign of a phase may change within a period


@dataclass(frozen=True)
class Resistance:
    """R_s in ohm per phase and V_drop in V per phase, with standard uncertainties and degrees of freedom.

    `scatter_V` is that of a component of the voltage about the fit, `gains` are those of the current sensors
    by which the currents were corrected, `levels` the standing currents that were used. `of_phases_ohm`,
    shape (3,), are the resistances of phases that may differ, each with the standard uncertainty
    `of_phases_standard_ohm`.
    """

    R_s_ohm: float
    R_s_standard_ohm: float
    drop_V: float
    drop_standard_V: float
    dof: float
    scatter_V: float
    gains: PhaseGains
    levels: int
    of_phases_ohm: NDArray[np.float64]
    of_phases_standard_ohm: NDArray[np.float64]


def resistance(u_V: NDArray[np.complex128], readings_A: NDArray[np.float64]) -> Resistance:
    """Return the estimates from standing currents.

    Args:
        u_V: voltage asked of the inverter, a vector for each level, shape (n,), mean over it.
        readings_A: phase currents, shape (n, 3), likewise.

    Raises:
        AnalysisError: too few levels, of one direction or of one size only.
    """
    gains = phase_gains(readings_A)
    phases = readings_A * gains.corrections
    clear = np.min(np.abs(phases), axis=1) > _CLEAR * np.max(np.abs(phases))
    if np.count_nonzero(clear) < 4:
        raise AnalysisError(
            f"{np.count_nonzero(clear)} standing currents with every phase clear of zero, 4 at least are "
            f"needed: use several levels, along the phases"
        )
    phases, u_V = phases[clear], u_V[clear]
    i, s, one = vector_of(phases), drop_vector(phases), np.ones(len(u_V))
    rest, u = (s, one, 1j * one), np.concatenate((u_V.real, u_V.imag))
    fit = least_squares(_rows(i, *rest), u)
    of_each = [vector_of(phases * np.eye(3)[k]) for k in range(3)]
    apart = least_squares(_rows(*of_each, *rest), u)
    R_s, drop = float(fit.x[0]), float(fit.x[1])
    return Resistance(
        R_s,
        fit.standard(0),
        drop,
        fit.standard(1),
        fit.dof,
        fit.scatter,
        gains,
        int(np.count_nonzero(clear)),
        apart.x[:3],
        np.array([apart.standard(k) for k in range(3)]),
    )


def _rows(*columns: NDArray[Any]) -> NDArray[np.float64]:
    """Return the regressors of both components of a vector, one below the other."""
    return np.column_stack([np.concatenate((each.real, each.imag)) for each in columns])
