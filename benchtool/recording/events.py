"""Events of a run: steps, states, faults, one line each, at their drive ticks."""

from __future__ import annotations

import hashlib
import threading
from enum import StrEnum
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from benchtool.document import Section
from benchtool.recording.checkpoints import Checkpoints
from benchtool.recording.failures import reading, writing
from benchtool.recording.seal import FileHash

EVENTS: Final = Path("data", "events.jsonl")


class Level(StrEnum):
    """Severity of an event."""

    INFO = "INFO"
    WARN = "WARN"
    ERROR = "ERROR"


class Event(Section):
    """One event; `tick` of the drive, None where that is not known; `state` if it is a change of state."""

    text: str
    level: Level = Level.INFO
    tick: int | None = None
    state: str | None = None


class EventFile:
    """Appends events to a bundle, from any thread; each is on its way to the disk when `append` returns."""

    def __init__(self, directory: Path) -> None:
        self._path = directory / EVENTS
        self._checkpoints = Checkpoints(directory)
        self._hash = hashlib.sha256(self._path.read_bytes() if self._path.is_file() else b"")
        self._lock = threading.Lock()

    def append(self, event: Event) -> None:
        """Add one event.

        Raises:
            RecordingError: the file cannot be written.
        """
        line = event.model_dump_json(exclude_defaults=True).encode() + b"\n"
        with self._lock, writing(self._path), self._path.open("ab") as file:
            file.write(line)
            file.flush()
            self._hash.update(line)
            state = FileHash(size_B=file.tell(), sha256=self._hash.hexdigest())
            self._checkpoints.note(self._path, state)


def read_events(directory: Path, size_B: int | None = None) -> tuple[Event, ...]:
    """Return the events of a bundle in the order in which they were noted; none if it has no file of them.

    Invalid lines, such as a last one that was cut short, are skipped; `size_B` is the acknowledged size of
    the file, without it all is read.

    Raises:
        RecordingError: the file is there and cannot be read.
    """
    path = directory / EVENTS
    with reading(path):
        lines = path.read_bytes()[:size_B].split(b"\n") if path.is_file() else []
    events = []
    for line in lines:
        try:
            events.append(Event.model_validate_json(line))
        except ValidationError:
            continue
    return tuple(events)
