"""What happened in a run besides its data: steps, states, faults, one line each, at their drive ticks."""

from __future__ import annotations

import threading
from enum import StrEnum
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from benchtool.document import Section
from benchtool.recording.failures import reading, writing

EVENTS: Final = Path("data", "events.jsonl")


class Level(StrEnum):
    """How much an event matters."""

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
        self._lock = threading.Lock()

    def append(self, event: Event) -> None:
        """Add one event.

        Raises:
            RecordingError: the file cannot be written.
        """
        line = event.model_dump_json(exclude_defaults=True).encode() + b"\n"
        with self._lock, writing(self._path), self._path.open("ab") as file:
            file.write(line)


def read_events(directory: Path) -> tuple[Event, ...]:
    """Events of a bundle in the order in which they were noted; none if it has no file of them.

    Lines that are no events, such as a last one that was cut short, are left out.

    Raises:
        RecordingError: the file is there and cannot be read.
    """
    path = directory / EVENTS
    with reading(path):
        lines = path.read_bytes().split(b"\n") if path.is_file() else []
    events = []
    for line in lines:
        try:
            events.append(Event.model_validate_json(line))
        except ValidationError:
            continue
    return tuple(events)
