"""Options that several verbs share."""

from __future__ import annotations

import math
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from benchtool.bench.wires import registry
from benchtool.cli import proposals
from benchtool.errors import UsageError

Profile = Annotated[
    str,
    typer.Option(metavar="NAME|FILE", help="Profile of motor and drive.", autocompletion=proposals.profiles),
]
Link = Annotated[
    str,
    typer.Option(
        metavar="URL",
        help=registry.links_help(),
        autocompletion=proposals.links,
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]
Seed = Annotated[int, typer.Option(help="Seed of the emulated bench's noise.")]
Yes = Annotated[
    bool, typer.Option("--yes", help="Confirm the operator's actions on a bench without load machine.")
]
Out = Annotated[
    Path | None, typer.Option(help="Folder of the run bundle.", show_default="runs/<time>-<plan>")
]
Note = Annotated[str, typer.Option(help="A line for the manifest.")]
Operator = Annotated[str, typer.Option(help="Who runs the test, for the manifest.")]
SerialNumber = Annotated[str, typer.Option(help="Of the motor under test, for the manifest.")]
Temperature = Annotated[
    float | None, typer.Option(min=-273.15, help="Of the surroundings in degrees Celsius, likewise.")
]
InstrumentsBeside = Annotated[
    list[str] | None,
    typer.Option("--instrument", help="An instrument beside the drive, with its certificate; once for each."),
]
RealTime = Annotated[bool, typer.Option("--real-time", help="Pace the emulated bench by the wall clock.")]
Web = Annotated[
    bool,
    typer.Option("--web", help="Serve the live view to a browser on this machine, and stay until Ctrl-C."),
]

Live = Annotated[
    list[str] | None,
    typer.Option(
        metavar="viewer|web|FILE.rrd",
        help="Show it live in Rerun's viewer, in a browser, or write a file; several times for several.",
        autocompletion=proposals.destinations,
    ),
]


def require_temperature(temperature_degC: float | None) -> None:
    """Refuse a temperature that is not finite.

    Raises:
        UsageError: it is not finite.
    """
    if temperature_degC is not None and not math.isfinite(temperature_degC):
        raise UsageError(f"--temperature is {temperature_degC}: give a number of degrees Celsius")


def listed(names: str) -> tuple[str, ...]:
    """Return the names that an option lists with commas; none of an option that was not given."""
    return tuple(name.strip() for name in names.split(",")) if names else ()


def wall_time() -> datetime:
    """Return the present time, with its offset from UTC."""
    return datetime.now().astimezone()
