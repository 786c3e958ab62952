"""A sink that sends one recording to one destination, which may be slow, stuck or gone."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable
from typing import Final, Protocol

import rerun as rr

from benchtool.errors import EnvironmentFailure
from benchtool.live.messages import Columns, Message

APPLICATION: Final = "benchtool"
PATIENCE_S: Final = 0.5
_BATCHES = 8
_POLL_S = 0.05
_RELEASE_TIMEOUT_S = 10.0

_Batch = tuple[tuple[Message, ...], int]


class Destination(Protocol):
    """Where recordings go: a file, or a viewer."""

    @property
    def name(self) -> str:
        """For messages."""

    @property
    def closing_timeout_s(self) -> float:
        """How long the end of a recording may wait for it."""

    @property
    def batch_timeout_s(self) -> float:
        """How long it may take over one batch before it counts as lost."""

    @property
    def replaceable(self) -> bool:
        """Whether there may be another in its place, once it is gone."""

    def closing_note(self) -> str:
        """Return advice for the user once it is gone; empty if there is none."""

    def connect(self, stream: rr.RecordingStream) -> None:
        """Have a recording go there.

        Raises:
            EnvironmentFailure: it cannot.
        """

    def alive(self) -> bool:
        """Return whether the destination, or one started in its place, can receive."""

    def lost(self) -> None:
        """Take note that what was sent did not arrive."""

    def give_up(self) -> None:
        """Cut the connection."""


class RecordingSink:
    """Sends to one destination from a thread of its own, with a bounded queue.

    After every batch that thread flushes the recording and waits for as long as the destination may take: the
    SDK holds one batch at most, this queue eight, whatever the destination does. `send` waits for room; once
    that has taken `patience_s` the destination counts as stuck: until there is room again, batches are
    discarded and counted at once. That thread ends the recording as well, as the SDK may wait without end for
    that too.

    A destination that was gone and is back gets the static content (names, layout, documents) and the batches
    from then on.

    Args:
        destination: where to.
        recording_id: of the recording; several sinks of one recording share it.
        title: of the recording, for people.
        note: takes a line if the destination is stuck, gone or back.
        patience_s: see above.

    Raises:
        EnvironmentFailure: the destination cannot be opened.
    """

    def __init__(
        self,
        destination: Destination,
        recording_id: str,
        title: str,
        note: Callable[[str], None],
        *,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self.rows_dropped = 0
        self._destination = destination
        self._recording_id = recording_id
        self._title = title
        self._note = note
        self._patience_s = patience_s
        self._stuck = self._gone = self._over = False
        self._standing: dict[str, Message] = {}
        self._lock = threading.Lock()
        self._batches: queue.Queue[_Batch | None] = queue.Queue(_BATCHES)
        self._stream = self._open()
        self._thread = threading.Thread(target=self._run, name=f"benchtool-live-{self.name}", daemon=True)
        self._thread.start()

    @property
    def name(self) -> str:
        return self._destination.name

    def send(self, messages: Iterable[Message], rows: int = 0) -> bool:
        """Have a batch sent, of so many rows of data, or discard it; whether it will be. Never raises."""
        batch = tuple(messages)
        with self._lock:
            self._standing |= {each.place: each for each in batch if not isinstance(each, Columns)}
        if self._put((batch, rows)):
            return True
        self.discard(rows)
        return False

    def discard(self, rows: int) -> None:
        """Count rows that are not sent."""
        with self._lock:
            self.rows_dropped += rows

    def close(self) -> None:
        """Let what waits be sent, for `closing_timeout_s` at most, and end the recording."""
        self._finish(self._destination.closing_timeout_s, self._destination.alive)
        self._over = True
        # What the thread waits for in the SDK ends when the other end has gone.
        self._finish(_RELEASE_TIMEOUT_S, self._abort_destination)

    def _open(self) -> rr.RecordingStream:
        stream = rr.RecordingStream(APPLICATION, recording_id=self._recording_id)
        self._destination.connect(stream)
        stream.send_recording_name(self._title)
        return stream

    def _finish(self, left_s: float, may_wait: Callable[[], bool]) -> None:
        """Have the thread end behind what waits, for so long at most."""
        told = False
        while self._thread.is_alive() and left_s > 0.0 and may_wait():
            told = told or self._try_put(None, 0.0)
            self._thread.join(_POLL_S)
            left_s -= _POLL_S

    def _abort_destination(self) -> bool:
        """Abort the destination, at every turn: the thread may just have reconnected."""
        self._destination.give_up()
        return True

    def _put(self, batch: _Batch) -> bool:
        if (self._gone and not self._destination.replaceable) or not self._destination.alive():
            self._mark_gone()
            return False
        if self._try_put(batch, 0.0 if self._stuck else self._patience_s):
            if self._stuck:
                self._stuck = False
                self._note_return()
            return True
        if not self._stuck:
            self._stuck = True
            self._note(f"{self.name} took nothing for {self._patience_s:g} s: rows are dropped until it does")
        return False

    def _note_return(self) -> None:
        self._note(f"{self.name} is back; {self.rows_dropped} rows were not shown")

    def _mark_gone(self, reason: str = "") -> None:
        with self._lock:
            known, self._gone = self._gone, True
        if not (known or self._over):
            more = "".join(f"; {text}" for text in (reason, self._destination.closing_note()) if text)
            self._note(f"{self.name} is gone, the measurement goes on without it{more}")

    def _try_put(self, batch: _Batch | None, wait_s: float) -> bool:
        try:
            self._batches.put(batch, block=wait_s > 0.0, timeout=wait_s or None)
        except queue.Full:
            return False
        return True

    def _run(self) -> None:
        while (batch := self._batches.get()) is not None:
            messages, rows = batch
            try:
                if self._over or (self._gone and not self._reconnect()):
                    self.discard(rows)
                    continue
                self._pass_on(messages)
            except (RuntimeError, ValueError) as reason:  # what the SDK makes of a broken connection
                self._destination.lost()
                self._mark_gone("" if self._destination.replaceable else str(reason))
                self.discard(rows)
        self._stream.disconnect()

    def _reconnect(self) -> bool:
        """Reconnect to a destination that is back; return whether it is."""
        if not (self._destination.replaceable and self._destination.alive()):
            return False
        self._stream.disconnect()
        try:
            self._stream = self._open()
        except EnvironmentFailure:
            return False
        with self._lock:
            standing = tuple(self._standing.values())
        self._pass_on(standing)
        self._gone = False  # not before: a viewer that is just ending may seem to be there
        self._note_return()
        return True

    def _pass_on(self, messages: Iterable[Message]) -> None:
        for message in messages:
            message.send(self._stream)
        self._stream.flush(timeout_sec=self._destination.batch_timeout_s)
