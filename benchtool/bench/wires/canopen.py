"""CANopen over any adapter of python-can; an emulated drive offers it behind a serial adapter (slcan)."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from benchtool.bench.wires.address import Address, Form, whole_number
from benchtool.bench.wires.wire import Connection, Offered, Opening, StreamLimits, Wire

if TYPE_CHECKING:
    import can

    from benchtool.emulator.bench import EmulatedBench
    from benchtool.emulator.servers.drive_node import OnGone
    from benchtool.link import Link
    from benchtool.link.discovery import Found
    from benchtool.link.port import Port

_SCHEME = "can"
_OFFERED_BITRATE = 500_000


def bus_at(address: Address) -> can.BusABC:
    """The bus that an address of this wire names.

    Raises:
        LinkError: it cannot be opened.
    """
    from benchtool.link.canopen.bus import open_bus

    interface, channel = address.place
    return open_bus(interface, channel, address.number("bitrate"))


def _connect(_stack: ExitStack, address: Address, opening: Opening) -> Connection:
    from benchtool.clock import RealClock
    from benchtool.link.canopen.link import CanopenLink
    from benchtool.link.canopen.stamps import AdapterStamps, timestamp

    clock = RealClock()

    def open_link() -> Link:
        bus = bus_at(address)
        if opening.frames is None:
            return CanopenLink(bus, opening.node_id, clock, arrival_s=AdapterStamps(clock))
        tapped = opening.frames.tap(bus, clock, stamp=True)
        return CanopenLink(tapped, opening.node_id, clock, arrival_s=timestamp)

    return Connection(clock, open_link)


def _host_link(bench: EmulatedBench, opening: Opening) -> Callable[[], Link]:
    from benchtool.link.canopen.link import CanopenLink
    from benchtool.link.canopen.stamps import timestamp

    def open_link() -> Link:
        bus: can.BusABC = bench.host_bus()
        if opening.frames is not None:
            bus = opening.frames.tap(bus, bench.clock)
        return CanopenLink(bus, opening.node_id, bench.clock, arrival_s=timestamp)

    return open_link


def _offer_slcan(bench: EmulatedBench, port: Port, place: str, node_id: int, on_gone: OnGone) -> Offered:
    from benchtool.emulator.servers.slcan import SlcanAdapter

    adapter = SlcanAdapter(port, name=place)
    bench.add_can(adapter, on_gone)
    link = f"{_SCHEME}:slcan:{place}?bitrate={_OFFERED_BITRATE}&node={node_id}"
    return Offered(link, lambda: adapter.traffic)


def _discover(address: Address, timeout_s: float) -> list[Found]:
    from benchtool.clock import RealClock
    from benchtool.errors import NoAnswer
    from benchtool.link.canopen.discovery import ask_bus

    bus, bitrate = bus_at(address), address.number("bitrate")
    found = ask_bus(address.without_options, bus, bitrate, timeout_s, RealClock())
    if not found:
        raise NoAnswer("no node answered or was heard; check the bit rate and the wiring")
    return found


WIRE = Wire(
    "can",
    Form(
        _SCHEME,
        ("INTERFACE", "CHANNEL"),
        {"bitrate": whole_number, "node": whole_number},
        example="bitrate=500000&node=1",
    ),
    _connect,
    carries_frames=True,
    stream=StreamLimits("CAN", signals="13", rate="1000"),
    host_link=_host_link,
    offers={"slcan": _offer_slcan},
    discover=_discover,
)
