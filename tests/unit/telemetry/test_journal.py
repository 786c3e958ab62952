"""Messages of a drive become events; their receivers cannot disturb the sender."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from benchtool.errors import DriveFault, RecordingError
from benchtool.protocol.canopen.emcy import Emergency
from benchtool.protocol.cia402 import State
from benchtool.recording import Event, Level
from benchtool.telemetry import Journal, keep_journal


class Drive:
    """Tells its tick, and whether anybody observes it."""

    def __init__(self) -> None:
        self.observer: Journal | None = None

    @contextmanager
    def observed(self, observer: Journal) -> Iterator[None]:
        self.observer = observer
        yield
        self.observer = None

    def tick_now(self) -> int | None:
        return 77


def test_states_are_events_where_they_change_and_emergencies_always() -> None:
    events: list[Event] = []
    journal = Journal(lambda: 5, [events.append])
    for state in (State.SWITCHED_ON, State.SWITCHED_ON, State.OPERATION_ENABLED, State.FAULT):
        journal.state(state, 10)
    journal.emergency(Emergency(0x2310, 3), 9)
    journal.emergency(Emergency(0, 0))
    journal.note("settling")
    assert events == [
        Event(text="state: switched on", tick=10, state="switched on"),
        Event(text="state: operation enabled", tick=10, state="operation enabled"),
        Event(text="state: fault", level=Level.ERROR, tick=10, state="fault"),
        Event(text="emergency: 0x2310 continuous overcurrent at the output", level=Level.ERROR, tick=9),
        Event(text="emergency: 0x0000 no error: all errors are reset"),
        Event(text="settling", tick=5),
    ]


def test_what_ends_a_run_is_its_last_event() -> None:
    events: list[Event] = []
    drive = Drive()
    with pytest.raises(KeyboardInterrupt), keep_journal(drive, [events.append]):
        raise KeyboardInterrupt
    with pytest.raises(DriveFault), keep_journal(drive, [events.append]):
        raise DriveFault("too hot")
    assert events == [
        Event(text="interrupted", level=Level.WARN, tick=77),
        Event(text="DriveFault: too hot", level=Level.ERROR, tick=77),
    ]


def test_a_disk_that_is_full_is_told_at_the_end_and_not_in_the_middle() -> None:
    events: list[Event] = []

    def refuse(event: Event) -> None:
        raise RecordingError(f"no room for {event.text}")

    drive = Drive()
    with pytest.raises(RecordingError, match="no room for one"), keep_journal(drive, [refuse, events.append]):
        assert drive.observer is not None
        drive.observer.note("one")
        drive.observer.note("two")
    assert [event.text for event in events] == ["one", "two"]
    assert drive.observer is None
