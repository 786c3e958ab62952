"""Options that several verbs share."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

Profile = Annotated[str, typer.Option(metavar="NAME|FILE", help="Profile of motor and drive.")]
Link = Annotated[
    str,
    typer.Option(
        metavar="URL",
        help="'emulated', 'can:INTERFACE:CHANNEL?bitrate=500000&node=1', "
        "'serial:PORT?baudrate=921600&node=1' or 'replay:DIR'.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on standard output.")]
Seed = Annotated[int, typer.Option(help="Seed of the emulated bench's noise.")]
Yes = Annotated[
    bool, typer.Option("--yes", help="Take as done what a person has to do on a bench without load machine.")
]
Out = Annotated[
    Path | None, typer.Option(help="Folder of the run bundle.", show_default="runs/<time>-<plan>")
]
RealTime = Annotated[bool, typer.Option("--real-time", help="Pace the emulated bench by the wall clock.")]


def listed(names: str) -> tuple[str, ...]:
    """Names that an option lists with commas; none of an option that was not given."""
    return tuple(name.strip() for name in names.split(",")) if names else ()


def wall_time() -> datetime:
    """Now, with its offset from UTC."""
    return datetime.now().astimezone()


@contextmanager
def bundle_folder(out: Path | None, when: datetime, name: str) -> Iterator[Path]:
    """The folder asked for, or one of its own for this run, which no other run takes as well.

    One of its own is there at once; it goes again if the `with` block leaves nothing in it.

    Raises:
        RecordingError: it cannot be made.
    """
    if out is not None:
        yield out
        return
    from benchtool.recording.failures import writing

    wanted = Path("runs") / f"{when:%Y%m%d-%H%M%S}-{name.replace('/', '-')}"
    with writing(wanted):
        first_of_all = not wanted.parent.exists()
        wanted.parent.mkdir(exist_ok=True)
        folder = next(each for each in _numbered(wanted) if _made(each))
    try:
        yield folder
    finally:
        with suppress(OSError):  # it has content
            folder.rmdir()
            if first_of_all:
                folder.parent.rmdir()


def _numbered(wanted: Path) -> Iterator[Path]:
    yield wanted
    yield from (wanted.with_name(f"{wanted.name}-{number}") for number in itertools.count(2))


def _made(folder: Path) -> bool:
    try:
        folder.mkdir()
    except FileExistsError:
        return False
    return True
