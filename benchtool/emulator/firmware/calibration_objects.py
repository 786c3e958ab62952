"""The objects that calibrate the current sensors, in front of the core's sums."""

from __future__ import annotations

from benchtool.emulator.control.current_sensors import CalibrationState
from benchtool.emulator.core.core import Core
from benchtool.emulator.firmware.objects import ObjectStore
from benchtool.protocol.dictionary import Number

_START = 1


class CalibrationObjects:
    """Object 0x2017 of one drive; the table refuses a start with the power stage on."""

    def __init__(self, objects: ObjectStore, core: Core) -> None:
        self._objects = objects
        self._command = core.command
        objects.on_write("offset_calibration", self._control)
        objects.compute("offset_calibration_state", lambda: int(self._command.calibration))

    def stop(self) -> None:
        """End a calibration that runs; the offsets stay as they are."""
        if self._command.calibration == CalibrationState.RUNNING:
            self._command.calibration = CalibrationState.IDLE

    def _control(self, raw: Number) -> None:
        if raw != _START:
            self.stop()
            return
        command, ticks = self._command, int(self._objects["offset_calibration_ticks"])
        command.sum_a = command.sum_b = command.sum_c = 0.0
        command.calibration_left = command.calibration_ticks = ticks
        command.calibration = CalibrationState.RUNNING
