"""Torque predictive control oriented on the rotor flux (Zhu, Xiao, Li 2011, "proposed TPC").

The equations are those of the paper in amplitude-invariant vectors, where p_n reads 3/2 p.

The paper's machine has one inductance. (12) then says that the voltage changes the torque by p_n / L psi_r x
u_s, whatever the state: psi_r is across the gradient of the torque over the stator flux. In general this
gradient is, in the rotor's frame,

    g = 3/2 p ((L_d - L_q) / L_d i_q, (psi_r + (L_d - L_q) i_d) / L_q)

and lambda counts from the axis across it, which for L_d = L_q is psi_r again. What (13) has beside the
voltage is the drift of the torque without it, to first order in the period; here it is predicted.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import Situation, out_of_frame, predict
from benchtool.emulator.control.fixed_voltage import direction, lambda_axis, mean_voltage
from benchtool.emulator.jit import njit


@njit
def voltage(at: Situation, torque: float, raise_below: float, drive: Any) -> tuple[float, float, float, bool]:
    """Mean voltage (u_alpha, u_beta) of a control period that begins in the situation `at`.

    A flux below `raise_below` is raised. Returns also the angle lambda' against the rotor flux, and whether
    the argument of (14) was beyond +-1: then the flux is kept, and the torque is the nearest in reach.
    """
    drifted = predict(at, 0.0, 0.0, drive)
    saliency = drive.L_d - drive.L_q
    per_ampere = 1.5 * drive.pole_pairs
    g_d = per_ampere * saliency / drive.L_d * drifted.i_q
    g_q = per_ampere / drive.L_q * (drive.psi_r + saliency * drifted.i_d)
    along = direction(torque - drifted.torque, g_d, g_q, at, drifted, raise_below, drive)
    cos_theta, sin_theta = lambda_axis(at, drifted, drive)
    mean = mean_voltage(drive)
    u_alpha, u_beta = out_of_frame(mean * along.cosine, mean * along.sine, cos_theta, sin_theta)
    return u_alpha, u_beta, math.atan2(along.sine, along.cosine), along.clipped
