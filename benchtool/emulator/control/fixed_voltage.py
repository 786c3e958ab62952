"""The direction of a voltage of fixed length, from which both TPCs are made.

Over a period the voltage moves the stator flux by u_s T_k, onto a circle about where the flux goes without
voltage. Two directions make the torque that is asked for, and the flux comparator chooses between them
(Zhu, Xiao and Li 2011, II-D). Where none does, the sine in (14) is beyond +-1 and both fall into one, which
leaves the flux to itself. There the direction is taken that brings the flux to its reference, and the torque
as near as that lets it come: to one of the two points where the circle meets that of the flux reference.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from benchtool.emulator.control.estimation import SQRT3, Situation
from benchtool.emulator.jit import njit

_END = 1  # of `lambda_reference`


class Direction(NamedTuple):
    """Direction of the voltage against the rotor flux, and whether no direction makes the torque."""

    cosine: float
    sine: float
    clipped: bool


@njit
def mean_voltage(drive: Any) -> float:
    """Mean of the voltage over the period: u_s for T_k, or what the inverter makes in every direction."""
    u: float = min(drive.u_s * drive.T_k_ratio, drive.u_dc * (1.0 / SQRT3))
    return u


@njit
def direction(
    needed: float,
    along_d: float,
    along_q: float,
    at: Situation,
    drifted: Situation,
    raise_below: float,
    drive: Any,
) -> Direction:
    """Direction that changes the torque by `needed` against what it drifts to without voltage.

    (along_d, along_q) is the change of the torque by that of the flux, Nm/Wb, and gives the angles from
    which (14) counts. A flux below `raise_below` is raised, any other lowered; beyond the pull-out angle,
    where raising the one lowers the other, it is led back.
    """
    per_steepest = 1.0 / math.sqrt(along_d * along_d + along_q * along_q)
    step = mean_voltage(drive) * drive.control_period
    sine = needed * per_steepest / step  # (14)
    e_d, e_q = along_d * per_steepest, along_q * per_steepest
    stable = e_q * drifted.psi_d - e_d * drifted.psi_q > 0.0
    if abs(sine) <= 1.0:
        # II-D: lambda raises the flux, pi - lambda lowers it, both make the same torque; hysteresis zero.
        cosine = math.sqrt(1.0 - sine * sine)
        if stable and at.psi_d * at.psi_d + at.psi_q * at.psi_q > raise_below * raise_below:
            cosine = -cosine
        return Direction(cosine * e_q + sine * e_d, sine * e_q - cosine * e_d, False)
    square = drifted.psi_d * drifted.psi_d + drifted.psi_q * drifted.psi_q
    magnitude = math.sqrt(square)
    cosine = (raise_below * raise_below - square - step * step) / (2.0 * magnitude * step)
    cosine = min(max(cosine, -1.0), 1.0)
    across = math.sqrt(1.0 - cosine * cosine)
    ahead = sine if stable else -drifted.psi_q
    across = math.copysign(across, ahead)
    r_d, r_q = drifted.psi_d / magnitude, drifted.psi_q / magnitude
    return Direction(cosine * r_d - across * r_q, cosine * r_q + across * r_d, True)


@njit
def lambda_axis(at: Situation, drifted: Situation, drive: Any) -> tuple[float, float]:
    """Direction (cosine, sine) of the rotor flux that lambda' is laid against.

    (14) reads as if psi_r stood still over the period: `lambda_reference` start takes it as it is when the
    period begins. The torque is met when the period ends: end takes it as it is there.
    """
    if drive.lambda_reference == _END:
        return drifted.cos_theta, drifted.sin_theta
    return at.cos_theta, at.sin_theta
