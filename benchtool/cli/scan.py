"""`benchtool scan`."""

from __future__ import annotations

import shlex
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import typer
from serial.tools import list_ports

from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.clock import RealClock
from benchtool.errors import LinkError, NoAnswer
from benchtool.link.address import DEFAULT_BAUDRATE, Address
from benchtool.link.canopen.bus import open_bus
from benchtool.link.discovery import Found, ask_bus, ask_port, duplicates
from benchtool.link.port import open_port

_AT_ONCE = 8


@dataclass(frozen=True)
class Silent:
    """A place where no drive was found, and why."""

    place: str
    reason: str


def scan(
    ports: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="PORT",
            help="Serial ports to ask besides: /dev/pts/4, socket://HOST:PORT, ...",
            show_default=False,
        ),
    ] = None,
    can: Annotated[
        list[str] | None,
        typer.Option(
            "--can", metavar="INTERFACE:CHANNEL?bitrate=500000", help="A CAN bus to ask. May be repeated."
        ),
    ] = None,
    baudrate: Annotated[
        list[int] | None,
        typer.Option(
            metavar="BIT_S",
            min=1,
            help="Of serial ports. May be repeated.",
            show_default="921600",
        ),
    ] = None,
    own_ports: Annotated[
        bool,
        typer.Option(
            "--ports/--no-ports", help="Ask all serial ports of this computer, or those named only."
        ),
    ] = True,
    timeout: Annotated[
        float, typer.Option(metavar="S", min=0.05, help="How long to wait for answers at each place.")
    ] = 1.0,
    as_json: options.Json = False,
) -> int:
    """Drives on serial ports and CAN buses, with the link to paste. Nothing is written, nothing enabled.

    A serial port gets one question of some bytes, each node of a CAN bus one SDO read. A node serves one
    transfer at a time, so better not scan a bus on which another program is transferring.
    """

    output = Output(as_json=as_json)
    buses = [Address.parse(f"can:{each}") for each in can or ()]
    places = list(dict.fromkeys([*(_own_ports() if own_ports else ()), *(ports or ())]))
    asked = [(place, each) for place in places for each in baudrate or (DEFAULT_BAUDRATE,)]
    names = ", ".join([*places, *(_place(bus) for bus in buses)]) or "no place: there are no serial ports"
    output.note(f"asking at {names}")
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        outcomes = [
            *pool.map(lambda port: _ask_port(port[0], port[1], timeout), asked),
            *pool.map(lambda bus: _ask_bus(bus, timeout), buses),
        ]
    found = [each for outcome in outcomes if not isinstance(outcome, Silent) for each in outcome]
    silent = [outcome for outcome in outcomes if isinstance(outcome, Silent)]
    _show(output, found, silent)
    if not found:
        raise NoAnswer(
            f"no drive answered at {names}; check that it is powered, the cable, the baud or bit rate, and "
            f"name its CAN bus with --can INTERFACE:CHANNEL?bitrate=500000"
        )
    return 0


def _own_ports() -> list[str]:

    return sorted(str(port.device) for port in list_ports.comports())


def _ask_port(place: str, baudrate: int, timeout_s: float) -> list[Found] | Silent:

    try:
        return [ask_port(place, open_port(place, baudrate), baudrate, timeout_s, RealClock())]
    except LinkError as reason:
        return Silent(f"serial:{place}", str(reason))


def _ask_bus(address: Address, timeout_s: float) -> list[Found] | Silent:

    try:
        found = ask_bus(address, open_bus(address), timeout_s, RealClock())
    except LinkError as reason:
        return Silent(_place(address), str(reason))
    return found or Silent(
        _place(address), "no node answered or was heard; check the bit rate and the wiring"
    )


def _place(address: Address) -> str:
    return f"can:{address.interface}:{address.channel}"


def _show(output: Output, found: list[Found], silent: list[Silent]) -> None:

    twice = duplicates(found)
    for drive in found:
        output.line(f"--link {shlex.quote(drive.link)}", style="bold")
        output.line(f"    {_description(drive)}")
    for place in silent:
        output.line(f"{place.place}: {place.reason}", style="dim")
    for line in twice:
        output.line(line, style="yellow")
    drives: list[dict[str, Any]] = [{**asdict(each), "nmt_state": _state(each)} for each in found]
    output.document({"drives": drives, "silent": [asdict(each) for each in silent], "duplicates": twice})


def _description(found: Found) -> str:
    facts = {
        "firmware": found.firmware_version,
        "vendor": _hex(found.vendor_id),
        "product": _hex(found.product_code),
        "serial number": found.serial_number,
    }
    known = [f"{name} {value}" for name, value in facts.items() if value is not None]
    return ", ".join([found.device_name or "no name", *known, _state(found) or "no heartbeat"])


def _hex(value: int | None) -> str | None:
    return None if value is None else f"0x{value:X}"


def _state(found: Found) -> str | None:
    return None if found.nmt_state is None else found.nmt_state.name.lower().replace("_", "-")
