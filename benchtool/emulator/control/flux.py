"""Operating points of the machine: of the least current for a torque, and of a given stator flux."""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.jit import njit

_ROUNDS = 30  # of Newton's method at most; 4 to 6 are usual, more only next to the pull-out torque
_EXACT = 1e-13  # relative step that ends it


@njit
def flux_reference(torque: float, drive: Any) -> float:
    """Return the magnitude of the stator flux to be held, in Wb peak: the setpoint, or that of least current.

    Limits of voltage and current are not in it; `field_weakening` has them.
    """
    if drive.psi_s_command > 0.0:
        return float(drive.psi_s_command)
    i_d, i_q = least_current(torque, drive)
    return magnitude(i_d, i_q, drive)


@njit
def magnitude(i_d: float, i_q: float, drive: Any) -> float:
    """Return the stator flux of the currents, in Wb peak."""
    psi_d = float(drive.psi_r) + float(drive.L_d) * i_d
    psi_q = float(drive.L_q) * i_q
    return math.sqrt(psi_d * psi_d + psi_q * psi_q)


@njit
def least_current(torque: float, drive: Any) -> tuple[float, float]:
    """Return currents (i_d, i_q) that make the torque with the least magnitude (maximum torque per ampere).

    Without saliency pure i_q. With it, dL = L_q - L_d,

        i_d = psi_r / (2 dL) -+ sqrt((psi_r / (2 dL))^2 + i_q^2), nearest to zero

    in the torque equation leaves dL^2 i_q^4 + a psi_r i_q - a^2 = 0 for a = |T| / (3/2 p), which rises and is
    convex: Newton's method from above does not miss its one root.
    """
    psi_r, saliency = float(drive.psi_r), float(drive.L_q) - float(drive.L_d)
    per_ampere = 1.5 * drive.pole_pairs
    if saliency == 0.0 or torque == 0.0:
        return 0.0, torque / (per_ampere * psi_r)
    a = abs(torque) / per_ampere
    square = saliency * saliency
    # Either term alone gives too large a current; the smaller of the two is within a fifth of the root.
    i_q = a / psi_r if a * abs(saliency) < psi_r * psi_r else math.sqrt(a / abs(saliency))
    for _ in range(_ROUNDS):
        cube = square * i_q * i_q * i_q
        step = (cube * i_q + a * psi_r * i_q - a * a) / (4.0 * cube + a * psi_r)
        i_q -= step
        if abs(step) <= _EXACT * i_q:
            break
    half = 0.5 * psi_r
    i_d = -saliency * i_q * i_q / (half + math.sqrt(half * half + square * i_q * i_q))
    return i_d, math.copysign(i_q, torque)


@njit
def most_torque(current: float, drive: Any) -> tuple[float, float]:
    """Return the currents (i_d, i_q > 0) of that magnitude which make the most torque."""
    psi_r, saliency = float(drive.psi_r), float(drive.L_q) - float(drive.L_d)
    root = math.sqrt(psi_r * psi_r + 8.0 * saliency * saliency * current * current)
    i_d = -2.0 * saliency * current * current / (psi_r + root)
    return i_d, math.sqrt(max(current * current - i_d * i_d, 0.0))


@njit
def operating_point(torque: float, psi_s: float, drive: Any) -> tuple[float, float, bool]:
    """Return the flux vector (psi_d, psi_q) of length `psi_s` that makes the torque, and whether none does.

    T = 3/2 p psi_s (psi_r / L_d - (1/L_d - 1/L_q) psi_s cos delta) sin delta: without saliency solved as it
    is, with it by Newton's method. Of two points the one of less current is taken: below the pull-out angle,
    and, where the flux is so large that the torque first falls with delta, beyond where it comes back to
    zero. Beyond the pull-out torque, delta stays at its angle.
    """
    L_d, L_q, psi_r = float(drive.L_d), float(drive.L_q), float(drive.psi_r)
    if psi_s <= 0.0:
        return 0.0, 0.0, torque != 0.0
    per_flux = 1.5 * drive.pole_pairs * psi_s
    if L_d == L_q:
        sine = torque / (per_flux * (drive.psi_r / drive.L_d))
        clipped = abs(sine) > 1.0
        sine = min(max(sine, -1.0), 1.0)
        return psi_s * math.sqrt(1.0 - sine * sine), psi_s * sine, clipped
    of_magnets = per_flux * psi_r / L_d
    of_saliency = per_flux * psi_s * (1.0 / L_d - 1.0 / L_q)
    delta, clipped = _load_angle(abs(torque), of_magnets, of_saliency)
    return psi_s * math.cos(delta), math.copysign(psi_s * math.sin(delta), torque), clipped


@njit
def _load_angle(torque: float, of_magnets: float, of_saliency: float) -> tuple[float, bool]:
    """Return the angle at which A sin delta - B sin delta cos delta is the torque, and whether it lies beyond
    pull-out.

    Between where the torque begins to rise and where it pulls out the curve has one inflexion at most: from
    there Newton's method moves to the root from one side.
    """
    root = math.sqrt(of_magnets * of_magnets + 8.0 * of_saliency * of_saliency)
    pull_out = math.acos(-2.0 * of_saliency / (of_magnets + root))
    sine, cosine = math.sin(pull_out), math.cos(pull_out)
    if torque >= sine * (of_magnets - of_saliency * cosine):
        return pull_out, torque > sine * (of_magnets - of_saliency * cosine)
    delta = 0.0
    if 4.0 * of_saliency > of_magnets:
        delta = math.acos(of_magnets / (4.0 * of_saliency))
    for _ in range(_ROUNDS):
        sine, cosine = math.sin(delta), math.cos(delta)
        slope = of_magnets * cosine - of_saliency * (cosine * cosine - sine * sine)
        step = (sine * (of_magnets - of_saliency * cosine) - torque) / slope
        delta -= step
        if abs(step) <= _EXACT:
            break
    return delta, False
