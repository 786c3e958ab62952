"""A serial line within the process, with a barrier that makes virtual time independent of threads."""

from __future__ import annotations

import threading
import time
from collections import deque

from benchtool.clock import Clock
from benchtool.errors import LinkClosed
from benchtool.link.port import READ_S

_LIVENESS_S = 0.1


def pipe(clock: Clock) -> tuple[PipePort, PipePort]:
    """Return the two ends of a line; bytes bear the time of `clock` at which they were written."""
    lock = threading.Condition()
    one, other = PipePort(clock, lock), PipePort(clock, lock)
    one.peer, other.peer = other, one
    return one, other


class PipePort:
    """One end: a `Port` that knows when its reader has handled everything sent to it.

    A receive loop reads again only after it has handled the bytes before, so each call of `read` marks them
    as done. An end that is closed hangs up: the other gets an OSError.
    """

    peer: PipePort

    def __init__(self, clock: Clock, lock: threading.Condition) -> None:
        self._clock = clock
        self._lock = lock
        self._arrived: deque[tuple[bytes, float]] = deque()
        self._in_hand = False
        self._reader: threading.Thread | None = None
        self._open = True
        self._woken = False
        self._told = False  # the reader knows that the other end has hung up
        self._concluded = False  # and has come back since

    def read(self) -> bytes:
        """See `Port.read`: the bytes of one write."""
        return self.read_timed()[0]

    def read_timed(self) -> tuple[bytes, float]:
        """As `read`, with the time of the bytes on the clock of the line; that of the call if there are none.

        Raises:
            OSError: either end is closed.
        """
        with self._lock:
            self._reader = threading.current_thread()
            self._in_hand = False
            self._concluded = self._told
            self._lock.notify_all()
            if not (self._arrived or self._woken) and self._open and self.peer._open:
                self._lock.wait(READ_S)
            self._woken = False
            if not self._open:
                raise OSError("the port was closed")
            if self._arrived:
                self._in_hand = True
                return self._arrived.popleft()
            if not self.peer._open:
                self._told = True
                raise OSError("the other end hung up")
        return b"", self._clock.now_s()

    def write(self, data: bytes) -> None:
        """See `Port.write`."""
        self.write_at(data, self._clock.now_s())

    def write_at(self, data: bytes, now_s: float) -> None:
        """As `write`, at a time that the writer tells: the clock stands still while a drive runs up to it."""
        with self._lock:
            if not self._open:
                raise OSError("the port was closed")
            if not self.peer._open:
                raise OSError("the other end hung up")
            self.peer._arrived.append((data, now_s))
            self._lock.notify_all()

    def wake(self) -> None:
        """Have a `read` that waits, or else the next, return at once."""
        with self._lock:
            self._woken = True
            self._lock.notify_all()

    def close(self) -> None:
        """See `Port.close`."""
        with self._lock:
            self._open = False
            self._arrived.clear()
            self._in_hand = False
            self._lock.notify_all()

    def settle(self, timeout_s: float = 5.0) -> bool:
        """Wait until every byte sent to this end, and a hang-up, has been handled; return whether there was
        any.

        Bytes sent to an end that has since been closed are not waited for.

        Raises:
            LinkClosed: the reader has ended without closing its end, or does not come back for `timeout_s`.
        """
        deadline_s = time.monotonic() + timeout_s
        with self._lock:
            if not self._is_waited_for():
                return False
            while self._is_waited_for():
                reason = self._stall_reason(deadline_s)
                if reason:
                    raise LinkClosed(
                        f"bytes on a serial line are not dealt with because {reason}; the reader must call "
                        f"read until it is closed: look for what ended it"
                    )
                self._lock.wait(min(_LIVENESS_S, timeout_s))
        return True

    def _is_waited_for(self) -> bool:
        return self._open and bool(self._arrived or self._in_hand or self._is_being_told())

    def _is_being_told(self) -> bool:
        """Return whether the other end has hung up, and the reader has yet to handle it."""
        if self.peer._open or self._concluded:
            return False
        reader = self._reader
        return reader is not None and reader is not threading.current_thread() and reader.is_alive()

    def _stall_reason(self, deadline_s: float) -> str:
        if self._is_waited_for() and self._reader is not None and not self._reader.is_alive():
            return f"the receive thread '{self._reader.name}' has ended"
        if time.monotonic() > deadline_s:
            return "the reader does not come back for more"
        return ""
