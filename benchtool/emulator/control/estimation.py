"""Flux and torque from measured currents and position, and their prediction over the computation delay."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.rotate import rotate

SQRT3 = math.sqrt(3.0)


class StateEstimate(NamedTuple):
    """Estimated electrical state at one moment; d lies along the rotor flux, (cos_theta, sin_theta)."""

    i_d: float
    i_q: float
    psi_d: float
    psi_q: float
    torque: float
    omega_e: float
    cos_theta: float
    sin_theta: float


@njit
def state_estimate(
    i_d: float, i_q: float, omega_e: float, cos_theta: float, sin_theta: float, drive: Any
) -> StateEstimate:
    """Return the stator flux of the current model, (2), and torque, (3) in amplitude-invariant form."""
    psi_d = drive.L_d * i_d + drive.psi_r
    psi_q = drive.L_q * i_q
    torque = 1.5 * drive.pole_pairs * (psi_d * i_q - psi_q * i_d)
    return StateEstimate(i_d, i_q, psi_d, psi_q, torque, omega_e, cos_theta, sin_theta)


@njit
def clarke(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the amplitude-invariant alpha and beta of three measured phases."""
    return (2.0 * a - b - c) * (1.0 / 3.0), (b - c) * (1.0 / SQRT3)


@njit
def into_frame(alpha: float, beta: float, cos_theta: float, sin_theta: float) -> tuple[float, float]:
    """Return the d and q of a vector in alpha and beta."""
    return alpha * cos_theta + beta * sin_theta, beta * cos_theta - alpha * sin_theta


@njit
def out_of_frame(d: float, q: float, cos_theta: float, sin_theta: float) -> tuple[float, float]:
    """Return the alpha and beta of a vector in d and q."""
    return d * cos_theta - q * sin_theta, d * sin_theta + q * cos_theta


@njit
def predict(now: StateEstimate, u_alpha: float, u_beta: float, drive: Any) -> StateEstimate:
    """Return the StateEstimate one control period later, under the mean voltage that is already under way.

    The stator flux is the integral of the voltage behind the resistance, (5), in the stationary frame; the
    currents follow from it and the rotor's new direction.
    """
    T_s = drive.control_period
    i_alpha, i_beta = out_of_frame(now.i_d, now.i_q, now.cos_theta, now.sin_theta)
    psi_alpha, psi_beta = out_of_frame(now.psi_d, now.psi_q, now.cos_theta, now.sin_theta)
    psi_alpha += T_s * (u_alpha - drive.R_s * i_alpha)
    psi_beta += T_s * (u_beta - drive.R_s * i_beta)
    cos_theta, sin_theta = rotate(now.cos_theta, now.sin_theta, now.omega_e * T_s)
    psi_d, psi_q = into_frame(psi_alpha, psi_beta, cos_theta, sin_theta)
    return state_estimate(
        (psi_d - drive.psi_r) / drive.L_d, psi_q / drive.L_q, now.omega_e, cos_theta, sin_theta, drive
    )


@njit
def voltage_to(psi_d: float, psi_q: float, at: StateEstimate, drive: Any) -> tuple[float, float]:
    """Return the mean voltage that moves the stator flux of `at` to (psi_d, psi_q) in the rotor's frame a
    period later.

    (5) over a period, with the mean of the currents at both ends in the resistance, which leaves an error of
    the third order in the period.
    """
    T_s = drive.control_period
    i_d, i_q = (psi_d - drive.psi_r) / drive.L_d, psi_q / drive.L_q
    cos_theta, sin_theta = rotate(at.cos_theta, at.sin_theta, at.omega_e * T_s)
    half_drop = 0.5 * drive.R_s
    then_alpha, then_beta = out_of_frame(
        psi_d / T_s + half_drop * i_d, psi_q / T_s + half_drop * i_q, cos_theta, sin_theta
    )
    now_alpha, now_beta = out_of_frame(
        at.psi_d / T_s - half_drop * at.i_d, at.psi_q / T_s - half_drop * at.i_q, at.cos_theta, at.sin_theta
    )
    return then_alpha - now_alpha, then_beta - now_beta
