"""Faults of wires and of the host."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from benchtool.emulator.faults.context import Context, Undo
from benchtool.emulator.faults.declaration import Fault
from benchtool.emulator.servers.disturbance import NEVER_S, Disturbance, Harm, Way
from benchtool.emulator.servers.parties import Babbler, Impostor, Party
from benchtool.protocol.canopen import ErrorCode

_BOTH: Final = frozenset(Way)
_TO_DRIVE: Final = frozenset({Way.TO_DRIVE})


def _ways(fault: Fault) -> frozenset[Way]:
    way = fault.word("way")
    return _BOTH if way == "both" else frozenset({Way(way)})


def _disturb(context: Context, disturbance: Disturbance) -> Undo:
    node = context.node
    node.disturbances.begin(disturbance)
    return lambda: node.disturbances.end(disturbance)


def _hitting(harm: Harm, time_key: str = "") -> Callable[[Context, Fault], Undo]:
    """Return a fault that hits a share of the frames of its ways."""

    def begin(context: Context, fault: Fault) -> Undo:
        time_s = fault.number(time_key) if time_key else 0.0
        return _disturb(context, Disturbance(harm, _ways(fault), fault.number("share"), time_s))

    return begin


def _cable_pulled(context: Context, fault: Fault) -> Undo:
    return _disturb(context, Disturbance(Harm.LOST, _BOTH))


def _bus_off(context: Context, fault: Fault) -> Undo:
    plug_in = _cable_pulled(context, fault)

    def recover() -> None:
        plug_in()
        context.firmware.report(ErrorCode.BUS_OFF_RECOVERED)

    return recover


def _host_killed(context: Context, fault: Fault) -> Undo:
    return _disturb(context, Disturbance(Harm.LOST, _TO_DRIVE))


def _host_frozen(context: Context, fault: Fault) -> Undo:
    until_s = context.now_s + fault.duration_s if fault.duration_s > 0.0 else NEVER_S
    return _disturb(context, Disturbance(Harm.HELD, _TO_DRIVE, until_s=until_s))


def _join(context: Context, party: Party) -> Undo:
    node = context.node
    node.parties.append(party)
    return lambda: node.parties.remove(party)


def _duplicate_node(context: Context, fault: Fault) -> Undo:
    node = context.node
    return _join(context, Impostor(node.node_id, node.tick, node.firmware.period_s))


def _babbling_node(context: Context, fault: Fault) -> Undo:
    node = context.node
    every = round(1.0 / (fault.number("rate_Hz") * node.firmware.period_s))
    leave = _join(context, Babbler(int(fault.number("can_id")), every, node.tick))
    make_room = _disturb(context, Disturbance(Harm.LOST, _BOTH, fault.number("share")))

    def end() -> None:
        leave()
        make_room()

    return end


EFFECTS: Final = {
    "frames_lost": _hitting(Harm.LOST),
    "frames_late": _hitting(Harm.LATE, "delay_s"),
    "frames_duplicated": _hitting(Harm.TWICE),
    "frames_reordered": _hitting(Harm.OVERTAKEN, "hold_s"),
    "frames_corrupted": _hitting(Harm.CORRUPTED),
    "cable_pulled": _cable_pulled,
    "bus_off": _bus_off,
    "duplicate_node": _duplicate_node,
    "babbling_node": _babbling_node,
    "host_frozen": _host_frozen,
    "host_killed": _host_killed,
}
