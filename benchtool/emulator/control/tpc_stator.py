"""Torque predictive control oriented on the stator flux, the "TPC" that Zhu, Xiao and Li (2011) improve on.

A reconstruction from (10), (11) and Fig. 1; their reference [22] is not followed beyond what they say of
it. What they say: u_s has a fixed magnitude, in (10) "the voltage vector can be approximately substituted
by a stator flux error", and psi_s is the positioning reference of a phase plane in four parts. What they
leave open, and how it is read here:

- which u_s is substituted: that of u_s x i_s. The other one holds the angle that is sought.
- the direction of the flux error: along psi_s, with psi_s* - |psi_s| as its length, since a magnitude is
  all that a flux controller knows. What psi_s turns along with the rotor is left out, which puts the torque
  off by 3/2 p omega_e T_s psi_s . i_s: 0.0002 N·m at the point of Fig. 6, but up to 0.3 at rated speed with
  full torque or a weakened field.
- the four parts: torque up or down by the sign of the angle from the rest of (10), flux up or down by
  taking lambda or pi - lambda, as II-D does about psi_r.
- "torque and flux hysteresis controllers": both errors as they are, bands of zero.

In amplitude-invariant vectors p_n reads 3/2 p.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, out_of_frame
from benchtool.emulator.control.fixed_voltage import direction, lambda_axis, mean_voltage, without_voltage
from benchtool.emulator.jit import njit


@njit
def voltage(
    at: StateEstimate, torque: float, psi_s: float, raise_below: float, drive: Any
) -> tuple[float, float, float, bool]:
    """Return the mean voltage (u_alpha, u_beta) of a control period that begins in the state estimate `at`.

    A flux below `raise_below` is raised; the flux error is that against `psi_s`. Returns also the angle
    against the stator flux, and whether its sine had to be clipped.
    """
    drift = without_voltage(at, drive)
    magnitude = math.sqrt(at.psi_d * at.psi_d + at.psi_q * at.psi_q)
    per_ampere = 1.5 * drive.pole_pairs

    # (11) in (10): p_n u_s x i_s T_k becomes p_n delta psi_s x i_s; along psi_s that is a share of (3)
    substituted = (psi_s - magnitude) / magnitude * at.torque
    # psi_s x L^-1 u_s of (10): across psi_s where L_d = L_q
    h_d, h_q = -per_ampere * at.psi_q / drive.L_d, per_ampere * at.psi_d / drive.L_q
    needed = torque - drift.torque - substituted
    u = direction(torque, needed, h_d, h_q, at, drift, raise_below, drive)

    cos_theta, sin_theta = lambda_axis(at, drive)
    mean = mean_voltage(drive)
    u_alpha, u_beta = out_of_frame(mean * u.cosine, mean * u.sine, cos_theta, sin_theta)
    angle = math.atan2(u.sine, u.cosine) - math.atan2(at.psi_q, at.psi_d)
    return u_alpha, u_beta, angle, u.clipped
