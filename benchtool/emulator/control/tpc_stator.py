"""Torque predictive control oriented on the stator flux, the "TPC" that Zhu, Xiao and Li (2011) improve on.

A reconstruction from (10), (11) and Fig. 1; their reference [22] is not followed beyond what they say of
it. What they say: u_s has a fixed magnitude, in (10) "the voltage vector can be approximately substituted
by a stator flux error", and psi_s is the positioning reference of a phase plane in four parts. What they
leave open, and how it is read here:

- which u_s is substituted: that of u_s x i_s. The other one holds the angle that is sought.
- the direction of the flux error: along psi_s, with psi_s* - |psi_s| as its length, since a magnitude is
  all that a flux controller knows.
- the four parts: torque up or down by the sign of the angle from the rest of (10), flux up or down by
  taking lambda or pi - lambda, as II-D does about psi_r.
- "torque and flux hysteresis controllers": both errors as they are, bands of zero.

In amplitude-invariant vectors p_n reads 3/2 p.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import Situation, out_of_frame
from benchtool.emulator.control.tpc import lambda_axis
from benchtool.emulator.jit import njit


@njit
def voltage(
    at: Situation, torque: float, psi_s: float, raise_below: float, drive: Any
) -> tuple[float, float, float, bool]:
    """Mean voltage (u_alpha, u_beta) of a control period that begins in the situation `at`.

    A flux below `raise_below` is raised; the flux error is that against `psi_s`. Returns also the angle
    against the stator flux, and whether its sine had to be clipped.
    """
    T_s = drive.control_period
    T_k = drive.T_k_ratio * T_s
    L = drive.L_q
    gain = 1.5 * drive.pole_pairs / L
    magnitude = math.sqrt(at.psi_d * at.psi_d + at.psi_q * at.psi_q)

    # (11) in (10): p_n u_s x i_s T_k becomes p_n delta psi_s x i_s; (3) gives it, delta psi_s along psi_s
    substituted = (psi_s - magnitude) / magnitude * at.torque
    emf = gain * at.omega_e * at.psi_d * drive.psi_r
    needed = torque - at.torque - substituted + (drive.R_s / L * at.torque + emf) * T_s
    sine = needed / (gain * magnitude * T_k * drive.u_s)  # psi_s x u_s of (10)
    clipped = abs(sine) > 1.0
    sine = min(max(sine, -1.0), 1.0)

    angle, cosine = math.asin(sine), math.sqrt(1.0 - sine * sine)
    if magnitude > raise_below:
        angle, cosine = math.pi - angle, -cosine

    # Laid against the stator flux, which turns along with the rotor.
    cos_theta, sin_theta = lambda_axis(at, drive)
    mean = drive.u_s * drive.T_k_ratio
    u_d, u_q = out_of_frame(mean * cosine, mean * sine, at.psi_d / magnitude, at.psi_q / magnitude)
    u_alpha, u_beta = out_of_frame(u_d, u_q, cos_theta, sin_theta)
    return u_alpha, u_beta, angle, clipped
