"""Field-oriented control: PI controllers of i_d and i_q with decoupling, and space-vector modulation.

Internal-model tuning (Harnefors and Nee, IEEE Trans. Ind. Appl. 34 (1998) no. 1): the PI's zero lies on the
pole of R_s and L, so that a current follows its reference like a first-order lag of bandwidth
`omega_current`.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, into_frame, out_of_frame
from benchtool.emulator.control.flux import operating_point
from benchtool.emulator.jit import njit
from benchtool.emulator.rotate import rotate


@njit
def voltage(
    at: StateEstimate, torque: float, psi_s: float, drive: Any, control: Any
) -> tuple[float, float, bool]:
    """Return the mean voltage (u_alpha, u_beta) of a control period that begins in the state estimate `at`.

    The references are the currents of that torque and flux. Returns also whether these had to be clipped.
    """
    T_s = drive.control_period
    psi_d, psi_q, clipped = operating_point(torque, psi_s, drive)
    error_d = (psi_d - drive.psi_r) / drive.L_d - at.i_d
    error_q = psi_q / drive.L_q - at.i_q

    # The voltage turns with the rotor; its mean over the period lies in the frame of the period's middle.
    cos_theta, sin_theta = rotate(at.cos_theta, at.sin_theta, 0.5 * at.omega_e * T_s)

    # Anti-windup: what the inverter fell short of counts as if the reference had been that much nearer
    # (Peng, Vrancic and Hanus, IEEE Control Syst. 16 (1996) no. 4).
    lack_d, lack_q = into_frame(
        control.u_alpha - control.u_alpha_asked, control.u_beta - control.u_beta_asked, cos_theta, sin_theta
    )
    share = -math.expm1(-drive.omega_current * T_s)  # of an error, that a period removes
    K_d, K_q = share * drive.L_d / T_s, share * drive.L_q / T_s
    u_d = K_d * error_d + control.u_d_integral - at.omega_e * at.psi_q
    u_q = K_q * error_q + control.u_q_integral + at.omega_e * at.psi_d
    control.u_d_integral += drive.R_s * (share * error_d + T_s / drive.L_d * lack_d)
    control.u_q_integral += drive.R_s * (share * error_q + T_s / drive.L_q * lack_q)

    u_alpha, u_beta = out_of_frame(u_d, u_q, cos_theta, sin_theta)
    control.u_alpha_asked, control.u_beta_asked = u_alpha, u_beta
    return u_alpha, u_beta, clipped
