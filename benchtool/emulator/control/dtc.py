"""Direct torque control with a switching table: one inverter vector per period.

Takahashi and Noguchi, IEEE Trans. Ind. Appl. 22 (1986) no. 5, with a three-level comparator of the torque
and a two-level one of the flux; for permanent-magnet machines Rahman et al. (2004), reference [1] of Zhu,
Xiao and Li.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, out_of_frame
from benchtool.emulator.control.vectors import nearest_zero
from benchtool.emulator.jit import njit

_SECTOR = math.pi / 3.0


@njit
def vector(at: StateEstimate, torque: float, psi_s: float, drive: Any, control: Any) -> int:
    """Return the inverter vector for the control period that begins in the state estimate `at`."""
    magnitude = math.sqrt(at.psi_d * at.psi_d + at.psi_q * at.psi_q)
    control.torque_state = torque_state(torque - at.torque, drive.torque_band, control.torque_state)
    control.flux_state = flux_state(psi_s - magnitude, drive.flux_band, control.flux_state)
    if control.torque_state == 0:
        return nearest_zero(control)
    psi_alpha, psi_beta = out_of_frame(at.psi_d, at.psi_q, at.cos_theta, at.sin_theta)
    return table(math.atan2(psi_beta, psi_alpha), control.torque_state, control.flux_state)


@njit
def torque_state(error: float, band: float, before: int) -> int:
    """1 raise, -1 lower, 0 leave: switches on at the band's edge, and off where the error changes sign."""
    if error > band:
        return 1
    if error < -band:
        return -1
    return before if error * before > 0.0 else 0


@njit
def flux_state(error: float, band: float, before: int) -> int:
    """1 raise, -1 lower: changes at the opposite edge of the band."""
    if error > band or (before == 0 and error >= 0.0):
        return 1
    if error < -band or before == 0:
        return -1
    return before


@njit
def table(flux_angle: float, torque: int, flux: int) -> int:
    """Return vector of the switching table: one sector ahead of the flux's raises it, two ahead lowers it.

    Sector 0 is +-30 degrees about vector 1; `torque` and `flux` are 1 or -1, and the angle is within +-pi.
    """
    sector = math.floor(flux_angle / _SECTOR + 0.5)
    ahead = torque if flux > 0 else 2 * torque
    return (sector + ahead + 12) % 6 + 1
