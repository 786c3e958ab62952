"""A current vector of stated length and angle, whatever the rotor does: no angle of the encoder enters.

A PI controller in a frame along the angle asked for, with internal-model tuning (Harnefors and Nee, IEEE
Trans. Ind. Appl. 34 (1998) no. 1) to the mean of L_d and L_q and to the bandwidth `omega_current`, as law
`foc` has it. It does not predict over the computation delay, which takes the rotor's angle. With the delay of
1.5 periods its phase margin is 90 degrees less 1.5 `omega_current` T_s times the inductance believed over the
true one: at the tenth of 1 / T_s it is stable for belief of up to ten times the truth.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, into_frame, out_of_frame
from benchtool.emulator.jit import njit


@njit
def current_vector(
    i: float, cosine: float, sine: float, now: StateEstimate, drive: Any, control: Any
) -> tuple[float, float]:
    """Return the mean voltage (u_alpha, u_beta) that leads the current to `i` along (cosine, sine).

    Anti-windup as in law `foc`: what the inverter fell short of counts as if the reference had been nearer.
    """
    T_s, L = drive.control_period, 0.5 * (drive.L_d + drive.L_q)
    i_alpha, i_beta = out_of_frame(now.i_d, now.i_q, now.cos_theta, now.sin_theta)
    i_x, i_y = into_frame(i_alpha, i_beta, cosine, sine)
    lack_x, lack_y = into_frame(
        control.u_alpha - control.u_alpha_asked, control.u_beta - control.u_beta_asked, cosine, sine
    )
    share = -math.expm1(-drive.omega_current * T_s)  # of an error, that a period removes
    K = share * L / T_s
    u_x, u_y = K * (i - i_x) + control.u_d_integral, -K * i_y + control.u_q_integral
    control.u_d_integral += drive.R_s * (share * (i - i_x) + T_s / L * lack_x)
    control.u_q_integral += drive.R_s * (-share * i_y + T_s / L * lack_y)
    u_alpha, u_beta = out_of_frame(u_x, u_y, cosine, sine)
    control.u_alpha_asked, control.u_beta_asked = u_alpha, u_beta
    return u_alpha, u_beta
