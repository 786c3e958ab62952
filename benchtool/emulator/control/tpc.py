"""Torque predictive control oriented on the rotor flux (Zhu, Xiao, Li 2011, "proposed TPC").

The equations are those of the paper in amplitude-invariant vectors, where p_n reads 3/2 p.

The paper's machine has one inductance. (12) then says that a voltage changes the torque by p_n / L psi_r x
u_s in every state: psi_r lies across the gradient of the torque over the stator flux. In general this
gradient is, in the rotor's frame,

    g = 3/2 p ((L_d - L_q) / L_d i_q, (psi_r + (L_d - L_q) i_d) / L_q)

and lambda counts from the axis across it, which for L_d = L_q is psi_r again, as all of (14) is. In (13) the
torque drifts while there is no voltage; g and the torque are taken where that leads to.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, out_of_frame
from benchtool.emulator.control.fixed_voltage import direction, lambda_axis, mean_voltage, without_voltage
from benchtool.emulator.jit import njit


@njit
def voltage(
    at: StateEstimate, torque: float, raise_below: float, drive: Any
) -> tuple[float, float, float, bool]:
    """Return the mean voltage (u_alpha, u_beta) of a control period that begins in the state estimate `at`.

    A flux below `raise_below` is raised. Returns also the angle lambda' against the rotor flux, and whether
    the argument of (14) was beyond +-1: the voltage then is aimed at the flux vector of that torque and flux.
    """
    drift = without_voltage(at, drive)
    u = direction(torque, torque - drift.torque, drift.g_d, drift.g_q, at, drift, raise_below, drive)
    cos_theta, sin_theta = lambda_axis(at, drive)
    mean = mean_voltage(drive)
    u_alpha, u_beta = out_of_frame(mean * u.cosine, mean * u.sine, cos_theta, sin_theta)
    return u_alpha, u_beta, math.atan2(u.sine, u.cosine), u.clipped
