"""A serial line: a port or any URL of pyserial, with messages of `firmware_protocol/serial.md`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from benchtool.bench.wires.address import Address, AddressSyntax, whole_number
from benchtool.bench.wires.wire import Connection, Offered, Opening, StreamLimits, Wire

if TYPE_CHECKING:
    from benchtool.emulator import EmulatedBench
    from benchtool.emulator.servers import OnGone
    from benchtool.link import Found, Link, Port

_SCHEME = "serial"


def _open_port(address: Address) -> tuple[Port, int]:
    """Return the port of an address, and its baud rate in bit/s."""
    from benchtool.link import DEFAULT_BAUDRATE, open_port

    baudrate = address.number("baudrate") or DEFAULT_BAUDRATE
    return open_port(address.place[0], baudrate), baudrate


def _connect(_stack: ExitStack, address: Address, opening: Opening) -> Connection:
    from benchtool.clock import RealClock
    from benchtool.link.serial import SerialLink

    clock = RealClock()
    return Connection(clock, lambda: SerialLink(_open_port(address)[0], opening.node_id, clock))


def _host_link(bench: EmulatedBench, opening: Opening) -> Callable[[], Link]:
    from benchtool.link.serial import SerialLink

    return lambda: SerialLink(bench.host_port(), opening.node_id, bench.clock)


def _offer(bench: EmulatedBench, port: Port, place: str, node_id: int, on_gone: OnGone) -> Offered:
    server = bench.add_serial(port, on_gone)
    return Offered(f"{_SCHEME}:{place}?node={node_id}", lambda: server.traffic)


def _own_places() -> Sequence[str]:
    from serial.tools import list_ports

    return [f"{_SCHEME}:{device}" for device in sorted(str(port.device) for port in list_ports.comports())]


def _discover(address: Address, timeout_s: float) -> list[Found]:
    from benchtool.clock import RealClock
    from benchtool.link.serial import scan_port

    port, baudrate = _open_port(address)
    return [scan_port(address.place[0], port, baudrate, timeout_s, RealClock())]


WIRE = Wire(
    "serial",
    AddressSyntax(
        _SCHEME, ("PORT",), {"baudrate": whole_number, "node": whole_number}, example="baudrate=921600&node=1"
    ),
    _connect,
    stream=StreamLimits("a serial line", signals="16", rate="the rate of the control"),
    host_link=_host_link,
    offers={"serial": _offer},
    own_places=_own_places,
    discover=_discover,
)
