"""Options that several verbs share."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from benchtool.bench.wires import registry

Profile = Annotated[str, typer.Option(metavar="NAME|FILE", help="Profile of motor and drive.")]
Link = Annotated[
    str,
    typer.Option(
        metavar="URL",
        help=registry.links_help(),
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]
Seed = Annotated[int, typer.Option(help="Seed of the emulated bench's noise.")]
Out = Annotated[
    Path | None, typer.Option(help="Folder of the run bundle.", show_default="runs/<time>-<plan>")
]
RealTime = Annotated[bool, typer.Option("--real-time", help="Pace the emulated bench by the wall clock.")]


Live = Annotated[
    list[str] | None,
    typer.Option(
        metavar="viewer|web|FILE.rrd",
        help="Show it live in Rerun's viewer, in a browser, or write a file; several times for several.",
    ),
]


def listed(names: str) -> tuple[str, ...]:
    """Names that an option lists with commas; none of an option that was not given."""
    return tuple(name.strip() for name in names.split(",")) if names else ()


def wall_time() -> datetime:
    """Now, with its offset from UTC."""
    return datetime.now().astimezone()
