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


@njit
def operating_point(torque: float, psi_s: float, drive: Any) -> tuple[float, float, bool]:
    """Flux vector (psi_d, psi_q) of length `psi_s` that makes the torque, and whether none does.

    T = 3/2 p psi_s (psi_r / L_d + (1/L_q - 1/L_d) psi_s cos delta) sin delta. Without saliency the first
    round is exact; with it, cos delta is iterated. Beyond the pull-out torque, delta stays at +-90 degrees.
    """
    per_ampere = 1.5 * drive.pole_pairs * psi_s
    of_magnets = drive.psi_r / drive.L_d
    of_saliency = (1.0 / drive.L_q - 1.0 / drive.L_d) * psi_s
    sine, cosine = 0.0, 1.0
    rounds = 1 if drive.L_d == drive.L_q else _ROUNDS
    for _ in range(rounds):
        sine = torque / (per_ampere * (of_magnets + of_saliency * cosine))
        cosine = math.sqrt(max(1.0 - sine * sine, 0.0))
    clipped = abs(sine) > 1.0
    sine = min(max(sine, -1.0), 1.0)
    return psi_s * cosine, psi_s * sine, clipped


@njit
def with_current_added(psi_s: float, torque: float, i_d_added: float, drive: Any) -> float:
    """Flux reference at which, with this torque, i_d is `i_d_added` more than at the flux `psi_s`."""
    psi_d, _, _ = operating_point(torque, psi_s, drive)
    i_d = (psi_d - drive.psi_r) / drive.L_d + i_d_added
    i_q = torque / (1.5 * drive.pole_pairs * (drive.psi_r - (drive.L_q - drive.L_d) * i_d))
    psi_d, psi_q = drive.psi_r + drive.L_d * i_d, drive.L_q * i_q
    return math.sqrt(psi_d * psi_d + psi_q * psi_q)
