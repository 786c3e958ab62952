"""The folder of a run: the one asked for, or one of its own."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from benchtool.recording import writing


@contextmanager
def bundle_folder(out: Path | None, when: datetime, name: str) -> Iterator[Path]:
    """Yield the folder asked for, or a new one for this run alone.

    A new folder is created at once, and removed again if the `with` block leaves it empty.

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
