"""The emulated bench in this process, its drive reached over a wire of choice."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from benchtool.bench.wires.address import Address, AddressSyntax, Check, any_text, whole_number
from benchtool.bench.wires.wire import Connection, FarEnd, Opening, Wire

SCHEME = "emulated"


def emulated(carrier: Callable[[Address], Wire], check: Check) -> Wire:
    """Return the wire to the bench; `carrier` is the one that an address chooses, `check` refuses others."""

    def connect(stack: ExitStack, address: Address, opening: Opening) -> Connection:
        from benchtool.emulator import EmulatedBench

        wire = carrier(address)
        assert wire.host_link is not None
        channel = address.options.get("channel", "")
        bench = EmulatedBench(
            opening.profile,
            channel,
            seed=opening.seed,
            paced=opening.real_time,
            first_tick=opening.first_tick,
            # A named bus may have listeners, even if the host uses another wire.
            has_bus=bool(channel) or wire.carries_frames,
            note=opening.note,
        )
        stack.callback(bench.close)
        return Connection(bench.clock, wire.host_link(bench, opening), bench=bench)

    syntax = AddressSyntax(SCHEME, options={"channel": any_text, "node": whole_number, "wire": check})
    return Wire(SCHEME, syntax, connect, FarEnd.EMULATED_DRIVE)
