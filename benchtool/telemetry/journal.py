"""The log of a run: what the host hears of the drive, and the steps that it takes itself, as events."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from typing import Protocol

from benchtool.errors import BenchError
from benchtool.protocol.canopen.emcy import Emergency
from benchtool.protocol.cia402 import State
from benchtool.recording import Event, Level

_FAULTS = (State.FAULT, State.FAULT_REACTION_ACTIVE)


class Observable(Protocol):
    """A drive that tells what is heard of it, and its tick: a `RemoteDrive` does."""

    def observed(self, observer: Journal) -> AbstractContextManager[None]: ...
    def tick_now(self) -> int | None: ...


@contextmanager
def keep_journal(drive: Observable, takers: Sequence[Callable[[Event], None]]) -> Iterator[Journal]:
    """A journal of a drive for the length of a `with` block; what ends the block too early is its last event.

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
    """Makes events and hands each to whoever takes them, in the caller's thread. Observes a drive.

    Args:
        tick: the drive's now, None where it is not known.
        takers: called with every event; what they raise is kept for `check`.
    """

    def __init__(self, tick: Callable[[], int | None], takers: Sequence[Callable[[Event], None]]) -> None:
        self._tick = tick
        self._takers = tuple(takers)
        self._state: State | None = None
        self._failure: BenchError | None = None

    def note(self, text: str, level: Level = Level.INFO) -> None:
        """Something happens now."""
        self._hand_on(Event(text=text, level=level, tick=self._tick()))

    def state(self, state: State, tick: int | None = None) -> None:
        """The drive is in a state; an event if it is another one than before."""
        if state is not self._state:
            self._state = state
            level = Level.ERROR if state in _FAULTS else Level.INFO
            self._hand_on(Event(text=f"state: {state.value}", level=level, tick=tick, state=state.value))

    def emergency(self, emergency: Emergency, tick: int | None = None) -> None:
        """The drive has reported something."""
        level = Level.ERROR if emergency.code else Level.INFO
        self._hand_on(Event(text=f"emergency: {emergency.text}", level=level, tick=tick))

    def check(self) -> None:
        """Raise what a taker has raised, once.

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
            except BenchError as failure:  # not now: the drive may just be on its way to disabled
                self._failure = self._failure or failure
