"""A recorded session in place of a drive: the frames of a bundle."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

from benchtool.bench.wires.address import Address, AddressSyntax, whole_number
from benchtool.bench.wires.wire import Connection, FarEnd, Opening, Wire


def _connect(stack: ExitStack, address: Address, opening: Opening) -> Connection:
    from benchtool.clock import VirtualClock
    from benchtool.link import ReplayLink
    from benchtool.recording import MANIFEST, Bundle

    clock = VirtualClock(paced=opening.real_time)
    folder = Path(address.place[0])
    if (folder / MANIFEST).is_file():
        Bundle.open(folder).require_intact()
    link = ReplayLink(folder, opening.node_id, clock)
    stack.callback(link.close)
    return Connection(clock, lambda: link, reopens=False)


WIRE = Wire(
    "replay",
    AddressSyntax(
        "replay",
        ("DIR",),
        {"node": whole_number},
        remark=" with the folder of a run that was recorded with --frames",
    ),
    _connect,
    FarEnd.RECORDING,
)
