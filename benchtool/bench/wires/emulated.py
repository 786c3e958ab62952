"""The emulated bench in this process, its drive reached over a wire of choice."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

from benchtool.bench.wires.address import Address, Check, Form, any_text, whole_number
from benchtool.bench.wires.wire import Connection, FarEnd, Opening, Wire

SCHEME = "emulated"


def emulated(carrier: Callable[[Address], Wire], check: Check) -> Wire:
    """The wire to the bench; `carrier` is the one that an address chooses, `check` refuses others."""

    def connect(stack: ExitStack, address: Address, opening: Opening) -> Connection:
        from benchtool.emulator.bench import EmulatedBench
        from benchtool.emulator.core.kernel import kernel_is_cached

        if not kernel_is_cached():
            opening.note("compiling the emulated drive, once on this machine: a few seconds")
        wire = carrier(address)
        assert wire.host_link is not None
        channel = address.options.get("channel", "")
        bench = EmulatedBench(
            opening.profile,
            channel,
            seed=opening.seed,
            paced=opening.real_time,
            first_tick=opening.first_tick,
            # A bus that is named may have listeners, whatever the host itself goes over.
            has_bus=bool(channel) or wire.carries_frames,
        )
        stack.callback(bench.close)
        return Connection(bench.clock, wire.host_link(bench, opening), bench=bench)

    form = Form(SCHEME, options={"channel": any_text, "node": whole_number, "wire": check})
    return Wire(SCHEME, form, connect, FarEnd.EMULATED_DRIVE)
