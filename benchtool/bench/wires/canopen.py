"""CANopen over any adapter of python-can; an emulated drive offers it behind a serial adapter (slcan)."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from benchtool.bench.wires.address import Address, AddressSyntax, whole_number
from benchtool.bench.wires.wire import Connection, Offered, Opening, StreamLimits, Wire
from benchtool.errors import UsageError

if TYPE_CHECKING:
    import can

    from benchtool.emulator import EmulatedBench
    from benchtool.emulator.servers import OnGone
    from benchtool.link import Found, Link, Port

_SCHEME = "can"
_OFFERED_BITRATE = 500_000


def bus_at(address: Address) -> can.BusABC:
    """Return the bus that an address of this wire names.

    Raises:
        LinkError: it cannot be opened.
    """
    from benchtool.link.canopen import open_bus

    interface, channel = address.place
    return open_bus(interface, channel, address.number("bitrate"))


def require_interface(address: Address) -> None:
    """Refuse an address whose interface python-can has not.

    Raises:
        UsageError: it has none of that name.
    """
    from can.interfaces import VALID_INTERFACES

    from benchtool.document import closest

    interface = address.place[0]
    if interface not in VALID_INTERFACES:
        raise UsageError(
            f"link '{address.url}': no interface '{interface}' of python-can: "
            f"{closest(interface, sorted(VALID_INTERFACES))}"
        )


def _connect(_stack: ExitStack, address: Address, opening: Opening) -> Connection:
    from benchtool.clock import RealClock
    from benchtool.link.canopen import AdapterTimestamps, CanopenLink, timestamp

    clock = RealClock()

    def open_link() -> Link:
        bus = bus_at(address)
        if opening.frames is None:
            return CanopenLink(bus, opening.node_id, clock, arrival_s=AdapterTimestamps(clock))
        tapped = opening.frames.tap(bus, clock, stamp=True)
        return CanopenLink(tapped, opening.node_id, clock, arrival_s=timestamp)

    return Connection(clock, open_link)


def _host_link(bench: EmulatedBench, opening: Opening) -> Callable[[], Link]:
    from benchtool.link.canopen import CanopenLink, timestamp

    def open_link() -> Link:
        bus: can.BusABC = bench.host_bus()
        if opening.frames is not None:
            bus = opening.frames.tap(bus, bench.clock)
        return CanopenLink(bus, opening.node_id, bench.clock, arrival_s=timestamp)

    return open_link


def _offer_slcan(bench: EmulatedBench, port: Port, place: str, node_id: int, on_gone: OnGone) -> Offered:
    from benchtool.emulator.servers import SlcanAdapter

    adapter = SlcanAdapter(port, name=place)
    bench.add_can(adapter, on_gone)
    link = f"{_SCHEME}:slcan:{place}?bitrate={_OFFERED_BITRATE}&node={node_id}"
    return Offered(link, lambda: adapter.traffic)


def _discover(address: Address, timeout_s: float) -> list[Found]:
    from benchtool.clock import RealClock
    from benchtool.errors import NoAnswer
    from benchtool.link.canopen import scan_bus

    bus, bitrate = bus_at(address), address.number("bitrate")
    found = scan_bus(address.without_options, bus, bitrate, timeout_s, RealClock())
    if not found:
        raise NoAnswer("no node answered or was heard; check the bit rate and the wiring")
    return found


WIRE = Wire(
    "can",
    AddressSyntax(
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
