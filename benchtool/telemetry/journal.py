"""The log of a run: messages of the drive and steps of the host, as events."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

from benchtool.errors import BenchError
from benchtool.protocol import State
from benchtool.protocol.canopen import Emergency
from benchtool.recording import Event, Level

_FAULTS = (State.FAULT, State.FAULT_REACTION_ACTIVE)


class Observable(Protocol):
    """A drive that can be observed and provides its tick, such as a `RemoteDrive`."""

    def observed(self, observer: Journal) -> AbstractContextManager[None]: ...
    def tick_now(self) -> int | None: ...


@contextmanager
def keep_journal(drive: Observable, takers: Sequence[Callable[[Event], None]]) -> Iterator[Journal]:
    """Keep a journal of a drive for the length of a `with` block; an exception becomes its last event.

    Raises:
        RecordingError: events could not be written.
    """
    journal = Journal(drive.tick_now, takers)
    with drive.observed(journal):
        try:
            yield journal
        except BaseException as failure:
            if isinstance(failure, KeyboardInterrupt):
                journal.note("interrupted", Level.WARN)
            else:
                journal.note(f"{type(failure).__name__}: {failure}".rstrip(": "), Level.ERROR)
            raise
    journal.check()


class Journal:
    """Make events and pass each to its receivers, in the caller's thread. Observes a drive.

    Args:
        tick: the drive's now, None where it is not known.
        takers: called with every event; their exceptions are kept for `check`.
    """

    def __init__(self, tick: Callable[[], int | None], takers: Sequence[Callable[[Event], None]]) -> None:
        self._tick = tick
        self._takers = tuple(takers)
        self._state: State | None = None
        self._failure: BenchError | None = None

    def note(self, text: str, level: Level = Level.INFO) -> None:
        """Note an event that happens now."""
        self._hand_on(Event(text=text, level=level, tick=self._tick()))

    def state(self, state: State, tick: int | None = None) -> None:
        """Note the state of the drive; an event if it has changed."""
        if state is not self._state:
            self._state = state
            level = Level.ERROR if state in _FAULTS else Level.INFO
            self._hand_on(Event(text=f"state: {state.value}", level=level, tick=tick, state=state.value))

    def emergency(self, emergency: Emergency, tick: int | None = None) -> None:
        """Note an emergency of the drive."""
        level = Level.ERROR if emergency.code else Level.INFO
        self._hand_on(Event(text=f"emergency: {emergency.text}", level=level, tick=tick))

    def check(self) -> None:
        """Raise the exception of a receiver, once.

        Raises:
            RecordingError: events could not be written.
        """
        failure, self._failure = self._failure, None
        if failure is not None:
            raise failure

    def _hand_on(self, event: Event) -> None:
        for take in self._takers:
            try:
                take(event)
            except BenchError as failure:  # not now: the drive may just be being disabled
                self._failure = self._failure or failure
