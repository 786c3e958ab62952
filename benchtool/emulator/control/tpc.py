"""Torque predictive control oriented on the rotor flux (Zhu, Xiao, Li 2011, "proposed TPC").

The equations are those of the paper in amplitude-invariant vectors, where p_n reads 3/2 p.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import Situation, out_of_frame
from benchtool.emulator.jit import njit
from benchtool.emulator.rotation import turned

_END = 1  # of `lambda_reference`


@njit
def voltage(at: Situation, torque: float, psi_s: float, drive: Any) -> tuple[float, float, float, bool]:
    """Mean voltage (u_alpha, u_beta) of a control period that begins in the situation `at`.

    Returns also the angle lambda' against the rotor flux, and whether the argument of (14) had to be clipped.
    """
    T_s = drive.control_period
    T_k = drive.T_k_ratio * T_s
    # The axis across the rotor flux is the one on which u_s makes torque; the paper's machine has one L.
    per_L = 1.0 / drive.L_q
    gain = 1.5 * drive.pole_pairs * per_L

    # psi_s x d psi_r/dt = omega_e psi_s . psi_r
    emf = gain * at.omega_e * at.psi_d * drive.psi_r
    needed = torque - at.torque + (drive.R_s * per_L * at.torque + emf) * T_s  # numerator of (14)
    sine = needed / (gain * drive.psi_r * T_k * drive.u_s)  # (14)
    clipped = abs(sine) > 1.0
    sine = min(max(sine, -1.0), 1.0)

    # II-D: lambda raises the flux, pi - lambda lowers it, both make the same torque; hysteresis band zero.
    angle, cosine = math.asin(sine), math.sqrt(1.0 - sine * sine)
    if at.psi_d * at.psi_d + at.psi_q * at.psi_q > psi_s * psi_s:
        angle, cosine = math.pi - angle, -cosine

    cos_theta, sin_theta = lambda_axis(at, drive)
    mean = drive.u_s * drive.T_k_ratio
    u_alpha, u_beta = out_of_frame(mean * cosine, mean * sine, cos_theta, sin_theta)
    return u_alpha, u_beta, angle, clipped


@njit
def lambda_axis(at: Situation, drive: Any) -> tuple[float, float]:
    """Direction (cosine, sine) of the rotor flux that lambda' is laid against.

    (14) reads as if psi_r stood still over the period: `lambda_reference` start takes it as it is when the
    period begins. The torque is met when the period ends: end takes it as it is there.
    """
    if drive.lambda_reference == _END:
        return turned(at.cos_theta, at.sin_theta, at.omega_e * drive.control_period)
    return at.cos_theta, at.sin_theta
