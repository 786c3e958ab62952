"""The stator flux reference: the setpoint, or the flux at which the torque needs the least current."""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.jit import njit

_ROUNDS = 8


@njit
def flux_reference(torque: float, drive: Any) -> float:
    """Magnitude of the stator flux to be held, in Wb peak.

    Without saliency the least current is pure i_q. With it, i_d = psi_r / (2 (L_q - L_d)) -+ sqrt(psi_r^2 /
    (4 (L_q - L_d)^2) + i_q^2) (maximum torque per ampere), iterated with the torque equation.
    """
    if drive.psi_s_command > 0.0:
        psi_s: float = drive.psi_s_command
        return psi_s
    per_ampere = 1.5 * drive.pole_pairs
    saliency = drive.L_q - drive.L_d
    i_d, i_q = 0.0, torque / (per_ampere * drive.psi_r)
    if saliency != 0.0:
        centre = drive.psi_r / (2.0 * saliency)
        for _ in range(_ROUNDS):
            i_d = centre - math.copysign(math.sqrt(centre * centre + i_q * i_q), centre)
            i_q = torque / (per_ampere * (drive.psi_r - saliency * i_d))
    psi_d = drive.psi_r + drive.L_d * i_d
    psi_q = drive.L_q * i_q
    return math.sqrt(psi_d * psi_d + psi_q * psi_q)
