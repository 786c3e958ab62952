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
    OVERLOAD = 16


_OVERCURRENT, _OVERSPEED = int(Trip.OVERCURRENT), int(Trip.OVERSPEED)
_UNDERVOLTAGE, _OVERVOLTAGE = int(Trip.UNDERVOLTAGE), int(Trip.OVERVOLTAGE)
_OVERLOAD = int(Trip.OVERLOAD)
_MOST_TIMES = 1e6  # of the square that is borne


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


@njit
def overload(drive: Any, control: Any, measurement: Any) -> int:
    """Have the heat of the winding follow the square of the current, I2t, and return the mask of its trip.

    A thermal mass with one time constant (IEC 60255-149): T dh/dt = (i / i_b)^2 - h, with the length i of the
    space vector and the current i_b that is borne at length. It cools with the power stage off, too. A
    current that is no number heats like a very large one.
    """
    a, b, c = measurement.i_a, measurement.i_b, measurement.i_c
    square = (2.0 / 3.0) * (a * a + b * b + c * c)
    borne = drive.i2t_current * drive.i2t_current
    if not square <= _MOST_TIMES * borne:  # also what is no number, and a current of 0 that is borne
        square = _MOST_TIMES * borne
    target = square / borne if borne > 0.0 else _MOST_TIMES
    control.heat += drive.control_period / drive.i2t_tau * (target - control.heat)
    drive.i2t_level = control.heat
    return 0 if control.heat <= 1.0 else _OVERLOAD
