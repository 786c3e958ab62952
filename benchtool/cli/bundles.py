"""What every verb that records needs for its bundle: a folder, and the conditions that a person states."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from benchtool.cli.options import require_temperature
from benchtool.recording import Conditions
from benchtool.recording.failures import writing


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


def conditions(
    operator: str, serial_number: str, temperature_degC: float | None, instruments: Sequence[str]
) -> Conditions:
    """What the operator states of a test.

    Raises:
        UsageError: a temperature that is no number.
    """
    require_temperature(temperature_degC)
    return Conditions(
        operator=operator,
        test_object_serial_number=serial_number,
        temperature_degC=temperature_degC,
        instruments=tuple(instruments),
    )
