"""Trips: faults that switch the power stage off in the tick in which they are detected."""

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
    """Return the mask of the limits that this tick's measurements violate.

    Each test asks whether a value is within its level, so that nan, in either, trips. A reading at the end of
    the converter's range may be anything beyond it. Low dc link and saturated currents are faults only of a
    power stage that is on.
    """
    mask = 0
    within = (
        abs(measurement.i_a) <= drive.i_trip
        and abs(measurement.i_b) <= drive.i_trip
        and abs(measurement.i_c) <= drive.i_trip
    )
    if not within or (pwm_enabled and measurement.saturated != 0):
        mask |= _OVERCURRENT
    if not abs(omega_m) <= drive.omega_m_trip:
        mask |= _OVERSPEED
    if pwm_enabled and not measurement.u_dc >= drive.u_dc_min:
        mask |= _UNDERVOLTAGE
    if not measurement.u_dc <= drive.u_dc_max or measurement.u_dc_saturated != 0:
        mask |= _OVERVOLTAGE
    return mask
