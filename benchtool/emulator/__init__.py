"""The emulated drive: machine, inverter and sensors, its control and its firmware, behind frames alone."""

from benchtool.emulator.machine.open_loop import OpenLoop, open_loop

__all__ = ["OpenLoop", "open_loop"]
