"""The direction of a voltage of fixed length, shared by both TPC laws.

Over a period the voltage moves the stator flux by u_s T_k, onto a circle about where the flux drifts to
without voltage. Two directions make the torque that is asked for, and the flux comparator chooses between
them (Zhu, Xiao and Li 2011, II-D). Where the argument of (14) is beyond +-1 none does: both fall into one,
and taking it would leave the flux uncontrolled. There the voltage is aimed at the flux vector that has the
length of the reference and makes the torque. On the straight way there neither the current nor the voltage
that is needed exceeds the larger of those at both ends.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.control.estimation import SQRT3, StateEstimate
from benchtool.emulator.control.flux import operating_point
from benchtool.emulator.jit import njit
from benchtool.emulator.rotate import rotate

_END = 1  # of `lambda_reference`


class Drift(NamedTuple):
    """Where flux and torque are at the end of a period without voltage, to first order; rotor's frame.

    With L_d = L_q the torque drifts by what (13) has beside the voltage,
    -(R_s / L T_e + p_n / L psi_s x d psi_r/dt) T_s.
    """

    psi_d: float
    psi_q: float
    torque: float
    g_d: float  # change of the torque by that of the flux there, Nm/Wb
    g_q: float


class Direction(NamedTuple):
    """Direction of the voltage against the rotor flux, and whether no direction makes the torque."""

    cosine: float
    sine: float
    clipped: bool


@njit
def mean_voltage(drive: Any) -> float:
    """Return the mean of the voltage over the period: u_s for T_k, or what a known dc link makes in every
    direction."""
    u, reach = drive.u_s * drive.T_k_ratio, drive.u_dc * (1.0 / SQRT3)
    limited: float = reach if 0.0 < reach < u else u
    return limited


@njit
def without_voltage(at: StateEstimate, drive: Any) -> Drift:
    """Return drift of a period that begins in the state estimate `at`; T = 3/2 p (psi_d i_q - psi_q i_d)."""
    T_s, R_s = drive.control_period, drive.R_s
    d_d = T_s * (at.omega_e * at.psi_q - R_s * at.i_d)
    d_q = -T_s * (at.omega_e * at.psi_d + R_s * at.i_q)
    per_ampere = 1.5 * drive.pole_pairs
    saliency = drive.L_d - drive.L_q
    if saliency == 0.0:
        g_q = per_ampere / drive.L_q * drive.psi_r
        return Drift(at.psi_d + d_d, at.psi_q + d_q, at.torque + g_q * d_q, 0.0, g_q)
    g_d = per_ampere * saliency / drive.L_d * at.i_q
    g_q = per_ampere / drive.L_q * (drive.psi_r + saliency * at.i_d)
    bend = per_ampere * saliency / (drive.L_d * drive.L_q)  # d2 T / d psi_d d psi_q, the only second order
    torque = at.torque + g_d * d_d + g_q * d_q + bend * d_d * d_q
    return Drift(at.psi_d + d_d, at.psi_q + d_q, torque, g_d + bend * d_q, g_q + bend * d_d)


@njit
def direction(
    torque: float,
    needed: float,
    h_d: float,
    h_q: float,
    at: StateEstimate,
    drift: Drift,
    raise_below: float,
    drive: Any,
) -> Direction:
    """Return the direction that makes the torque, by changing it by `needed` against what it drifts to.

    (h_d, h_q) is what the law takes the change of the torque by that of the flux for, in Nm/Wb: its length is
    the gain in (14), and lambda counts from the axis across it. A flux below `raise_below` is raised, any
    other lowered; beyond the pull-out angle, where more flux is less, it is led back.
    """
    per_gain = 1.0 / math.sqrt(h_d * h_d + h_q * h_q)
    h_d, h_q = h_d * per_gain, h_q * per_gain
    step = mean_voltage(drive) * drive.control_period
    sine = needed / step * per_gain  # (14)
    stable = h_q * drift.psi_d - h_d * drift.psi_q > 0.0
    lower = at.psi_d * at.psi_d + at.psi_q * at.psi_q > raise_below * raise_below
    if abs(sine) <= 1.0:
        # II-D: lambda raises the flux, pi - lambda lowers it, both make the same torque. No hysteresis band.
        cosine = math.sqrt(1.0 - sine * sine)
        cosine = -cosine if stable and lower else cosine
        return Direction(cosine * h_q + sine * h_d, sine * h_q - cosine * h_d, False)
    psi_d, psi_q, _ = operating_point(torque, raise_below, drive)
    to_d, to_q = psi_d - drift.psi_d, psi_q - drift.psi_q
    per_length = 1.0 / math.sqrt(to_d * to_d + to_q * to_q)
    return Direction(to_d * per_length, to_q * per_length, True)


@njit
def lambda_axis(at: StateEstimate, drive: Any) -> tuple[float, float]:
    """Return the direction (cosine, sine) of the rotor flux that lambda' is laid against.

    (14) reads as if psi_r stood still over the period: `lambda_reference` start takes it as it is when the
    period begins. The torque is met when the period ends: end takes it as it is there.
    """
    if drive.lambda_reference == _END:
        return rotate(at.cos_theta, at.sin_theta, at.omega_e * drive.control_period)
    return at.cos_theta, at.sin_theta
