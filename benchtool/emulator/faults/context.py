"""What a fault reaches of the emulated bench."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchtool.emulator.core.core import Core
from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.machine.sensor_truth import SensorTruth
from benchtool.emulator.servers.drive_node import DriveNode

Undo = Callable[[], None]
"""Ends a fault."""


@dataclass(frozen=True)
class Context:
    """The drive with its wires, and the core with machine, load and sensors below it."""

    node: DriveNode
    core: Core

    @property
    def firmware(self) -> Firmware:
        return self.node.firmware

    @property
    def now_s(self) -> float:
        """Drive time."""
        return self.node.firmware.now_s

    def change_sensors(self, sensors: SensorTruth) -> None:
        """Have other sensors from the next tick on."""
        self.core.set_sensors(sensors)


def nothing() -> None:
    """End a fault that has no end of its own."""
