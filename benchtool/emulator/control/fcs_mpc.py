"""Finite-set predictive torque control: the inverter vector of least cost, one per period.

After Miranda, Cortes, Yuz and Rodriguez, IEEE Trans. Ind. Electron. 56 (2009) no. 6, reference [11] of Zhu,
Xiao and Li, with the machine model of their (1) to (6).
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, predict
from benchtool.emulator.control.vectors import held, nearest_zero
from benchtool.emulator.jit import njit


@njit
def vector(at: StateEstimate, torque: float, psi_s: float, drive: Any, control: Any) -> int:
    """Return vector of least cost at the end of the control period that begins in the state estimate `at`.

    Both zero vectors cost the same; the one with fewer switchings is taken.
    """
    best, least = 0, math.inf
    for candidate in range(7):
        switched = held(candidate, drive.u_dc)
        after = predict(at, switched.u_alpha, switched.u_beta, drive)
        here = cost(after, torque, psi_s, drive)
        if here < least:
            best, least = candidate, here
    return best if best != 0 else nearest_zero(control)


@njit
def cost(after: StateEstimate, torque: float, psi_s: float, drive: Any) -> float:
    """(T - T*)^2 / T_N^2 + w (|psi_s| - psi_s*)^2 / psi_r^2."""
    torque_error = (after.torque - torque) / drive.T_N
    magnitude = math.sqrt(after.psi_d * after.psi_d + after.psi_q * after.psi_q)
    flux_error = (magnitude - psi_s) / drive.psi_r
    value: float = torque_error * torque_error + drive.flux_weight * flux_error * flux_error
    return value
