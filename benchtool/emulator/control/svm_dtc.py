"""Direct torque control with space-vector modulation: a torque PI turns the stator flux vector.

Tang, Zhong and Rahman, IEEE Trans. Ind. Appl. 39 (2003) no. 6, and Pacas and Weber, IEEE Trans. Ind.
Electron. 52 (2005) no. 5: references [18] and [19] of Zhu, Xiao and Li. The PI's output is the increment of
the load angle over a period, the flux reference has the length asked for, and the voltage moves the flux
there in one period.
"""

from __future__ import annotations

import math
from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, voltage_to
from benchtool.emulator.jit import njit
from benchtool.emulator.rotate import rotate


@njit
def voltage(at: StateEstimate, torque: float, psi_s: float, drive: Any, control: Any) -> tuple[float, float]:
    """Return the mean voltage (u_alpha, u_beta) of a control period that begins in the state estimate `at`.

    The turning of the rotor is added to the increment, so that the PI rests at zero in the steady state. Its
    integral is of the torque as measured, not as predicted, since it corrects the errors of the model; it
    stands still after a period in which the voltage did not suffice.
    """
    if control.limited == 0:
        control.delta_integral += drive.K_i_delta * drive.control_period * (torque - drive.torque)
    growth = drive.K_p_delta * (torque - at.torque) + control.delta_integral
    magnitude = math.sqrt(at.psi_d * at.psi_d + at.psi_q * at.psi_q)
    direction_d, direction_q = rotate(at.psi_d / magnitude, at.psi_q / magnitude, growth)
    return voltage_to(psi_s * direction_d, psi_s * direction_q, at, drive)
