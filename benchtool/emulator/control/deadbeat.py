"""Deadbeat control of torque and flux: a voltage of free length meets both at the end of one period.

The counterpart of TPC's fixed |u_s|. Torque and flux magnitude determine one flux vector in the rotor's frame
(`operating_point`, also with saliency); the voltage is what moves the flux there from where it is predicted.
A voltage beyond the hexagon keeps its direction.
"""

from __future__ import annotations

from typing import Any

from benchtool.emulator.control.estimation import StateEstimate, voltage_to
from benchtool.emulator.control.flux import operating_point
from benchtool.emulator.jit import njit


@njit
def voltage(at: StateEstimate, torque: float, psi_s: float, drive: Any) -> tuple[float, float, bool]:
    """Return the mean voltage (u_alpha, u_beta) of a control period that begins in the state estimate `at`.

    Returns also whether no flux of that length makes the torque, and the torque was clipped.
    """
    psi_d, psi_q, clipped = operating_point(torque, psi_s, drive)
    u_alpha, u_beta = voltage_to(psi_d, psi_q, at, drive)
    return u_alpha, u_beta, clipped
