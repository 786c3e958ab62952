"""`benchtool emulate`."""

from __future__ import annotations

import json
import shlex
import sys
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from benchtool.bench import Endpoint, ServedDrive, fault_table, serve
from benchtool.cli import options
from benchtool.cli.output import Output
from benchtool.errors import UsageError

_TELL_S = 0.5
_DEFAULT_PROFILE = "zhu2011"
_LOOPBACK = "127.0.0.1"
_OUTCOMES = {"stops": "stops", "ended": "does not notice, the host does", "goes on": "goes on"}


def emulate(
    profile: options.Profile = _DEFAULT_PROFILE,
    serial: Annotated[bool, typer.Option("--serial", help="A serial line, at a pseudo-terminal.")] = False,
    slcan: Annotated[
        bool, typer.Option("--slcan", help="CAN behind a serial adapter (slcan), at a pseudo-terminal.")
    ] = False,
    serial_at: Annotated[
        Path | None,
        typer.Option(
            metavar="PATH", help="As --serial, under this name: a symbolic link.", show_default=False
        ),
    ] = None,
    slcan_at: Annotated[
        Path | None,
        typer.Option(
            metavar="PATH", help="As --slcan, under this name: a symbolic link.", show_default=False
        ),
    ] = None,
    tcp: Annotated[
        int | None,
        typer.Option(metavar="PORT", min=0, max=65535, help="The serial line at a TCP port; 0: any."),
    ] = None,
    slcan_tcp: Annotated[
        int | None,
        typer.Option(metavar="PORT", min=0, max=65535, help="The CAN adapter at a TCP port; 0: any."),
    ] = None,
    offer: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="A wire that an installed package brings, at a pseudo-terminal. May be repeated.",
        ),
    ] = None,
    bind: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Where TCP ports listen; loopback is this computer only.")
    ] = _LOOPBACK,
    speed: Annotated[
        float,
        typer.Option(
            metavar="N",
            help="Drive seconds in a second. The drive supervises its host in its own time: above 3 or so "
            "the usual 0.5 s are short for one.",
        ),
    ] = 1.0,
    seed: options.Seed = 0,
    load_torque: Annotated[
        float,
        typer.Option(
            metavar="NM", help="Load the shaft while the drive is enabled, against positive rotation."
        ),
    ] = 0.0,
    hold_speed: Annotated[
        float | None,
        typer.Option(metavar="RAD_S", help="Hold the shaft at this speed at any torque."),
    ] = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME[:KEY=VALUE,...][@SECONDS]",
            help="A fault, so many seconds of drive time after power-up. May be repeated.",
        ),
    ] = None,
    faults: Annotated[bool, typer.Option("--faults", help="List the faults, and end.")] = False,
    as_json: options.Json = False,
) -> int:
    """An emulated drive in real time, for other programs to open. Ctrl-C or SIGTERM ends it: exit code 0.

    All wires lead to the one drive, and clients may come and go. If no wire is named, there are --serial and
    --slcan.
    """

    output = Output(as_json=as_json)
    if faults:
        return _list_faults(output, as_json=as_json)
    if hold_speed is not None and load_torque:
        raise UsageError("both of --load-torque and --hold-speed: the load machine does one of the two")
    endpoints = [
        *([Endpoint("serial", name=serial_at)] if serial or serial_at else []),
        *([Endpoint("slcan", name=slcan_at)] if slcan or slcan_at else []),
        *([Endpoint("serial", tcp=(bind, tcp))] if tcp is not None else []),
        *([Endpoint("slcan", tcp=(bind, slcan_tcp))] if slcan_tcp is not None else []),
        *(Endpoint(each) for each in offer or ()),
    ]
    try:
        with serve(
            profile,
            endpoints or [Endpoint("serial"), Endpoint("slcan")],
            seed=seed,
            speed=speed,
            load_torque_Nm=load_torque,
            hold_omega_m_rad_s=hold_speed,
            faults=fault or (),
            note=output.note,
        ) as drive:
            _announce(drive, profile, as_json=as_json)
            output.note("Ctrl-C ends it")
            _live(drive, output)
    except KeyboardInterrupt:  # the regular end of a server
        output.note("the emulated drive was switched off")
    return 0


def _list_faults(output: Output, *, as_json: bool) -> int:
    """Print the table of faults."""
    rows = fault_table()
    if as_json:
        listed = [
            asdict(row)
            | {
                "parameters": [
                    dict(zip(("name", "default", "unit", "meaning"), each, strict=True))
                    for each in row.parameters
                ]
            }
            for row in rows
        ]
        output.document({"faults": listed})
        return 0
    for row in rows:
        where = ", CAN only" if row.can_only else ""
        sys.stdout.write(f"{row.name} ({row.place}{where}): {row.does} The drive {_OUTCOMES[row.outcome]}.\n")
        for name, default, unit, meaning in row.parameters:
            value = default if isinstance(default, str) else f"{default:g}"
            sys.stdout.write(f"    {name}={value}{f' {unit}' if unit else ''}  {meaning}\n")
        sys.stdout.write(f"    told by: {row.named}\n")
    return 0


def _announce(drive: ServedDrive, profile: str, *, as_json: bool) -> None:
    """Print the drive's addresses, without buffering."""
    if as_json:
        wires = [{"wire": each.wire, "place": each.place, "link": each.link} for each in drive.wires]
        document: dict[str, Any] = {"profile": profile, "node_id": drive.node_id, "wires": wires}
        sys.stdout.write(json.dumps(document) + "\n")
    else:
        chosen = "" if profile == _DEFAULT_PROFILE else f" --profile {shlex.quote(profile)}"
        for each in drive.wires:
            sys.stdout.write(f"{each.wire:<7} --link {shlex.quote(each.link)}{chosen}\n")
    sys.stdout.flush()


def _live(drive: ServedDrive, output: Output) -> None:
    """Run the drive, and show its state on a terminal, until an exception is raised."""
    with ExitStack() as stack:
        show = None
        if output.progress.is_terminal:
            show = stack.enter_context(
                Live(_status(drive), console=output.progress, auto_refresh=False, transient=True)
            )
        while True:
            drive.run(_TELL_S)
            if show is not None:
                show.update(_status(drive), refresh=True)


def _status(drive: ServedDrive) -> Group:
    now = drive.status()
    facts = (
        f"{now.drive_s:.1f} s",
        now.state,
        now.nmt_state.name.lower().replace("_", "-"),
        f"{now.omega_m_rad_s:.2f} rad/s",
        f"{now.torque_Nm:.3f} Nm",
        *([f"{now.late_s:.1f} s late"] if now.late_s else []),
    )
    table = Table(show_edge=False, pad_edge=False)
    for column in ("wire", "place"):
        table.add_column(column, overflow="fold")
    for column in ("in", "out", "dropped"):
        table.add_column(column, justify="right")
    for each in drive.wires:
        traffic = each.traffic()
        frames = (traffic.received, traffic.sent, traffic.dropped)
        table.add_row(each.wire, Text(each.place), *(str(count) for count in frames))
    return Group(Text(", ".join(facts), style="bold"), table)
