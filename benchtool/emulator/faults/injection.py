"""Faults injected into an emulated bench at moments of drive time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

from benchtool.emulator.core.core import Core
from benchtool.emulator.faults import in_drive, in_plant, on_wires
from benchtool.emulator.faults.context import Context, Undo
from benchtool.emulator.faults.declaration import Fault
from benchtool.emulator.faults.spelling import parse_fault
from benchtool.emulator.servers.drive_node import DriveNode
from benchtool.errors import ValueRefused

_EFFECTS: Final[Mapping[str, Callable[[Context, Fault], Undo]]] = {
    **on_wires.EFFECTS,
    **in_drive.EFFECTS,
    **in_plant.EFFECTS,
}


@dataclass(frozen=True)
class Begun:
    """A fault that has begun, in which tick of the drive."""

    fault: Fault
    tick: int


class FaultInjector:
    """Begins and ends faults of one emulated bench, each in a tick of its own.

    The same faults, seed and commands give the same course to the bit.

    Args:
        node: the drive and its wires.
        core: machine, sensors and load below it.
    """

    def __init__(self, node: DriveNode, core: Core) -> None:
        self._node = node
        self._context = Context(node, core)
        self._undo: dict[int, Undo] = {}
        self._begun: list[Begun] = []

    @property
    def begun(self) -> tuple[Begun, ...]:
        """The faults that have begun since power-up, in this order."""
        return tuple(self._begun)

    def inject(self, fault: Fault | str) -> Fault:
        """Arm a fault, which begins `fault.at_s` of drive time from now; may be called from any thread.

        Raises:
            ValueRefused: no such fault, a value that it cannot have, or a fault that this bench cannot have.
        """
        armed = parse_fault(fault) if isinstance(fault, str) else fault
        node = self._node
        with node.lock:
            if armed.kind.can_only and not node.on_can:
                raise ValueRefused(
                    f"fault '{armed}' is one of a CAN bus, and the drive is on none: offer one, or leave it "
                    f"out"
                )
            if armed.kind.name == "phase_open":
                self._context.core.prepare_motor(in_plant.open_phase(self._context.core.motor, armed))
            ahead = round(armed.at_s / node.firmware.period_s)
            node.schedule.add(node.tick + ahead, lambda: self._begin(armed))
            if ahead == 0:
                node.schedule.run(node.tick)
        return armed

    def end(self) -> None:
        """End every fault, and forget those that have not begun; what they have caused stays."""
        with self._node.lock:
            self._node.schedule.clear()
            for key in reversed(list(self._undo)):
                self._end(key)

    def _begin(self, fault: Fault) -> None:
        node, key = self._node, len(self._begun)
        self._begun.append(Begun(fault, node.tick))
        self._undo[key] = _EFFECTS[fault.kind.name](self._context, fault)
        if fault.duration_s > 0.0:
            ticks = max(1, round(fault.duration_s / node.firmware.period_s))
            node.schedule.add(node.tick + ticks, lambda: self._end(key))

    def _end(self, key: int) -> None:
        if (undo := self._undo.pop(key, None)) is not None:
            undo()
