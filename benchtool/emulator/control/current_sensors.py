"""Current sensors: their offsets calibrated, their readings corrected and put in the order of the phases."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from benchtool.emulator.jit import njit

_OF_RANGE = 0.1  # of the converter's range: an offset beyond it is that of a broken sensor, or a current
_ACB = 1  # of `phase_order`


class CalibrationState(IntEnum):
    """Object `offset_calibration_state`."""

    IDLE = 0
    RUNNING = 1
    DONE = 2
    FAILED = 3


_IDLE, _RUNNING = int(CalibrationState.IDLE), int(CalibrationState.RUNNING)
_DONE, _FAILED = int(CalibrationState.DONE), int(CalibrationState.FAILED)


@njit
def correct(drive: Any, measurement: Any) -> None:
    """Replace the readings of the three outputs by the currents of the motor's phases a, b and c."""
    i_a = (measurement.i_a - drive.current_offset_a) * drive.current_gain_a
    i_b = (measurement.i_b - drive.current_offset_b) * drive.current_gain_b
    i_c = (measurement.i_c - drive.current_offset_c) * drive.current_gain_c
    if drive.phase_order == _ACB:
        i_b, i_c = i_c, i_b
    measurement.i_a, measurement.i_b, measurement.i_c = i_a, i_b, i_c


@njit
def calibrate(drive: Any, command: Any, measurement: Any) -> None:
    """Add the readings of this tick to a calibration that runs; the last one puts the means in force.

    The power stage must stay off, so that no current flows: going on, it ends the calibration. A mean beyond
    a tenth of the converter's range, or none at all, leaves the offsets as they were.
    """
    if command.calibration != _RUNNING:
        return
    if command.pwm_enabled != 0:
        command.calibration = _IDLE
        return
    command.sum_a += measurement.i_a
    command.sum_b += measurement.i_b
    command.sum_c += measurement.i_c
    command.calibration_left -= 1
    if command.calibration_left > 0:
        return
    ticks = command.calibration_ticks
    mean_a, mean_b, mean_c = command.sum_a / ticks, command.sum_b / ticks, command.sum_c / ticks
    within = _OF_RANGE * drive.i_full_scale
    if not (abs(mean_a) <= within and abs(mean_b) <= within and abs(mean_c) <= within):
        command.calibration = _FAILED
        return
    drive.current_offset_a, drive.current_offset_b, drive.current_offset_c = mean_a, mean_b, mean_c
    command.calibration = _DONE
