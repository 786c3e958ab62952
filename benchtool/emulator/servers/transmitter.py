"""The sending side of a serial server: the drive never waits for its line."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator

import serial

from benchtool.emulator.ports.client import HungUp

CAPACITY = 64 * 1024
RESERVE = 16 * 1024
"""Bytes of the capacity that telemetry leaves to answers."""

_AT_ONCE = 4096


class DirectTransmitter:
    """For a line that takes everything at once, as one within the process does.

    Args:
        write: sends bytes.
        lost: takes the OSError of a write.
    """

    def __init__(self, write: Callable[[bytes], None], lost: Callable[[OSError], None]) -> None:
        self.sent = self.dropped = 0
        self._write = write
        self._lost = lost

    def send(self, frame: bytes, *, telemetry: bool = False) -> bool:
        """Send a frame; False if it was dropped."""
        try:
            self._write(frame)
        except OSError as reason:
            self.dropped += 1
            self._lost(reason)
            return False
        self.sent += 1
        return True

    def send_each(self, frames: Iterator[bytes]) -> None:
        """Send frames that are made as the line takes them, in place of those of the call before."""
        while (frame := next(frames, None)) is not None and self.send(frame):
            pass

    def clear(self) -> None:
        """Drop queued frames, as their client has gone."""

    def close(self) -> None:
        """Send no more; what waits is lost."""


class QueuedTransmitter:
    """For a line that takes its time: frames wait in a buffer for a thread that writes them.

    What the buffer cannot hold is dropped, telemetry before the rest. Frames leave in the order in which they
    came; those of `send_each` are made one by one between them.

    Args:
        write: sends bytes and may block for a while. If it gives up because of a timeout, or because no
            client has the other end open (`HungUp`), these bytes are lost; any other OSError is the end of
            the line.
        lost: takes that OSError.

    Attributes:
        sent: frames that the line took.
        dropped: frames that it did not take in time; frames without a client are counted in neither.
    """

    def __init__(self, write: Callable[[bytes], None], lost: Callable[[OSError], None]) -> None:
        self.sent = self.dropped = 0
        self._write = write
        self._lost = lost
        self._frames: deque[bytes] = deque()
        self._waiting = 0
        self._made: Iterator[bytes] = iter(())
        self._making = False
        self._open = True
        self._changed = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="emulated-drive-writer", daemon=True)
        self._thread.start()

    def send(self, frame: bytes, *, telemetry: bool = False) -> bool:
        """See `DirectTransmitter.send`."""
        with self._changed:
            room = CAPACITY - self._waiting - (RESERVE if telemetry else 0)
            if not self._open or len(frame) > room:
                self.dropped += 1
                return False
            self._frames.append(frame)
            self._waiting += len(frame)
            self._changed.notify()
        return True

    def send_each(self, frames: Iterator[bytes]) -> None:
        """See `DirectTransmitter.send_each`; `frames` is used in the thread that writes."""
        with self._changed:
            self._made, self._making = frames, True
            self._changed.notify()

    def clear(self) -> None:
        """See `DirectTransmitter.clear`."""
        with self._changed:
            self._frames.clear()
            self._waiting = 0
            self._made, self._making = iter(()), False

    def close(self) -> None:
        """See `DirectTransmitter.close`; a write that blocks must be ended by closing the port first."""
        with self._changed:
            self._open = False
            self._changed.notify()
        if self._thread is not threading.current_thread():
            self._thread.join()

    def _run(self) -> None:
        while (frames := self._take()) is not None:
            try:
                if frames:
                    self._write(b"".join(frames))
                    self.sent += len(frames)
            except HungUp:
                continue
            except (TimeoutError, serial.SerialTimeoutException):
                with self._changed:
                    self.dropped += len(frames)
            except OSError as reason:
                self._lost(reason)
                return

    def _take(self) -> list[bytes] | None:
        """Return what is to be written next, as soon as there is something; None once it is closed."""
        with self._changed:
            while self._open and not self._frames and not self._making:
                self._changed.wait()
            if not self._open:
                return None
            taken: list[bytes] = []
            size = 0
            while self._frames and size < _AT_ONCE:
                taken.append(self._frames.popleft())
                size += len(taken[-1])
            self._waiting -= size
            if self._making:
                frame = next(self._made, None)
                self._making = frame is not None
                if frame is not None:
                    taken.append(frame)
            return taken
