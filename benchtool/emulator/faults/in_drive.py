"""Faults of the drive's electronics and firmware."""

from __future__ import annotations

from typing import Final

from benchtool.emulator.faults.context import Context, Undo, nothing
from benchtool.emulator.faults.declaration import Fault
from benchtool.errors import ValueRefused
from benchtool.protocol.canopen import ErrorCode


def _drive_reset(context: Context, fault: Fault) -> Undo:
    context.node.restart()
    return nothing


def _drive_hung(context: Context, fault: Fault) -> Undo:
    node, watchdog_s = context.node, fault.number("watchdog_s")
    node.firmware.hung = True

    def restart() -> None:
        if node.firmware.hung:
            node.restart()
            node.firmware.report(ErrorCode.WATCHDOG)

    if watchdog_s > 0.0:
        node.schedule.add(node.tick + max(1, round(watchdog_s / node.firmware.period_s)), restart)
    return restart


def _other_firmware(context: Context, fault: Fault) -> Undo:
    node = context.node
    node.restart()
    node.firmware.objects["dictionary_hash"] = int(node.firmware.objects["dictionary_hash"]) ^ 0xFFFF

    def flash() -> None:
        node.firmware.objects["dictionary_hash"] = node.firmware.objects.table.hash

    return flash


def _wrong_parameter(context: Context, fault: Fault) -> Undo:
    objects, name = context.firmware.objects, fault.word("name")
    entry = objects.table.by_name.get(name)
    if entry is None or entry.role != "parameter":
        raise ValueRefused(f"fault '{fault}': the drive has no parameter '{name}': name one")
    before = objects[name]
    value = before * fault.number("times")
    objects[name] = value if isinstance(before, float) else round(value)

    def restore() -> None:
        objects[name] = before

    return restore


EFFECTS: Final = {
    "drive_reset": _drive_reset,
    "drive_hung": _drive_hung,
    "other_firmware": _other_firmware,
    "wrong_parameter": _wrong_parameter,
}
