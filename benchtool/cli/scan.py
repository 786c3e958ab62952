"""`benchtool scan`."""

from __future__ import annotations

import shlex
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import typer

from benchtool.bench.wires import Address, naming_wires, registry
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import LinkError, NoAnswer, PlugInError
from benchtool.link import Found, duplicates

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
    transfer at a time, so do not scan a bus on which another program is transferring.
    """
    output = Output(as_json=as_json)
    speeds = [f"?baudrate={each}" for each in baudrate or ()] or [""]
    with naming_wires():
        own = [place for wire in registry.wires() for place in wire.own_places()] if own_ports else []
    named = [f"serial:{each}" for each in ports or ()]
    asked = [*dict.fromkeys([*own, *named]), *(f"can:{each}" for each in can or ())]
    at_speeds = ([each + it for it in speeds] if each.startswith("serial:") else [each] for each in asked)
    places = [registry.parse(each) for several in at_speeds for each in several]
    names = ", ".join(dict.fromkeys(each.without_options for each in places))
    names = names or "no place: there are no serial ports"
    output.note(f"asking at {names}")
    with ThreadPoolExecutor(_AT_ONCE) as pool:
        outcomes = list(pool.map(lambda place: _ask(place, timeout), places))
    found = [each for outcome in outcomes if not isinstance(outcome, Silent) for each in outcome]
    silent = [outcome for outcome in outcomes if isinstance(outcome, Silent)]
    _show(output, found, silent)
    if not found:
        raise NoAnswer(
            f"no drive answered at {names}; check that it is powered, the cable, the baud or bit rate, and "
            f"name its CAN bus with --can INTERFACE:CHANNEL?bitrate=500000"
        )
    return 0


def _ask(place: Address, timeout_s: float) -> list[Found] | Silent:
    discover = registry.wire_of(place).discover
    if discover is None:
        return Silent(place.without_options, "drives cannot be looked for there")
    try:
        with naming_wires():
            return discover(place, timeout_s)
    except (LinkError, PlugInError) as reason:
        return Silent(place.without_options, str(reason))


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
