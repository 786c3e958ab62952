"""Trips: what switches the power stage off in the very tick it is seen."""

from __future__ import annotations

from enum import IntFlag
from typing import Any

from benchtool.emulator.jit import njit


class Trip(IntFlag):
    """Bits of the command record's `trip`."""

    OVERCURRENT = 1
    OVERSPEED = 2
    UNDERVOLTAGE = 4
    OVERVOLTAGE = 8


_OVERCURRENT, _OVERSPEED = int(Trip.OVERCURRENT), int(Trip.OVERSPEED)
_UNDERVOLTAGE, _OVERVOLTAGE = int(Trip.UNDERVOLTAGE), int(Trip.OVERVOLTAGE)


@njit
def trips(drive: Any, measurement: Any, omega_m: float, pwm_enabled: bool) -> int:
    """Mask of the limits that this tick's measurements violate.

    A low dc link is a fault only while the power stage needs it.
    """
    mask = 0
    largest = max(abs(measurement.i_a), abs(measurement.i_b), abs(measurement.i_c))
    if largest > drive.i_trip:
        mask |= _OVERCURRENT
    if abs(omega_m) > drive.omega_m_trip:
        mask |= _OVERSPEED
    if pwm_enabled and measurement.u_dc < drive.u_dc_min:
        mask |= _UNDERVOLTAGE
    if measurement.u_dc > drive.u_dc_max:
        mask |= _OVERVOLTAGE
    return mask
