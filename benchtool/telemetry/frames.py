"""Log of all frames of a session, in a file that `candump`, Wireshark and `--link replay:DIR` read."""

from __future__ import annotations

import io
import threading
from pathlib import Path
from typing import BinaryIO, cast

import can
from can.io import CanutilsLogWriter

from benchtool.clock import Clock
from benchtool.errors import RecordingError
from benchtool.link import FRAMES, CountsMalformed
from benchtool.recording import Checkpoints, HashedFile, writing
from benchtool.telemetry.worker import Worker

_WAITING = 1 << 15
_ROOM_S = 2.0
_FLUSH_S = 0.2


class FrameLog:
    """Takes frames from the moment of `tap` and writes them from the moment of `start`: earlier frames, the
    identification of the drive, are kept until then."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._early: list[can.Message] = []
        self._file: _LogFile | None = None
        self._closed = False
        self._lost = 0

    def tap(self, bus: can.BusABC, clock: Clock, *, stamp: bool = False) -> can.BusABC:
        """Return a bus in place of `bus` that shows its frames here.

        Args:
            clock: of the time of frames that are sent.
            stamp: put that time on received frames too, in place of their adapter's.
        """
        return _TappedBus(bus, self, clock, stamp)

    def start(self, bundle: Path) -> None:
        """Write into the folder of a bundle from now on.

        Raises:
            RecordingError: the file cannot be written.
        """
        with self._lock:
            self._file = _LogFile(bundle)
            early, self._early = self._early, []
        for frame in early:
            self.append(frame)

    def append(self, frame: can.Message) -> None:
        """Note a frame; from any thread."""
        with self._lock:
            if self._closed:
                return
            if self._file is None:
                self._early.append(frame)
            elif not self._file.worker.put(frame, _ROOM_S):
                self._lost += 1

    def check(self) -> None:
        """Raise an error of the writing thread.

        Raises:
            RecordingError: the file cannot be written, or the disk does not keep up.
        """
        if self._file is None:
            return
        self._file.worker.check()
        if self._lost:
            raise RecordingError(
                f"{self._lost} frames were lost on their way to {self._file.path}, none may be: use a faster "
                f"disk, or record without --frames"
            )

    def close(self) -> None:
        """Write queued frames and close the file; later frames are dropped.

        Raises:
            RecordingError: it could not be written.
        """
        with self._lock:
            self._closed = True
        if self._file is not None:
            self._file.close()
            self.check()


class _LogFile:
    """The file and the thread that writes it."""

    def __init__(self, bundle: Path) -> None:
        self.path = bundle / FRAMES
        self._checkpoints = Checkpoints(bundle)
        with writing(self.path):
            self._file = HashedFile(self.path)
            text = io.TextIOWrapper(cast(BinaryIO, self._file), encoding="utf-8", newline="\n")
            self._writer = CanutilsLogWriter(text)
        self._flushed_s = 0.0
        self.worker = Worker("benchtool-frames", self._write, _WAITING)

    def close(self) -> None:
        self.worker.close()
        with writing(self.path):
            self._writer.stop()

    def _write(self, frame: can.Message) -> None:
        with writing(self.path):
            self._writer.on_message_received(frame)
            if frame.timestamp - self._flushed_s >= _FLUSH_S:
                self._flushed_s = frame.timestamp
                self._writer.file.flush()
                self._checkpoints.note(self.path, self._file.state)


class _TappedBus(can.BusABC):
    """A bus whose frames are logged; it owns the bus behind it."""

    def __init__(self, bus: can.BusABC, log: FrameLog, clock: Clock, stamp: bool) -> None:
        super().__init__(channel=bus.channel_info)
        self.channel_info = bus.channel_info
        self._bus = bus
        self._log = log
        self._clock = clock
        self._stamp = stamp

    @property
    def malformed(self) -> int:
        """See `CountsMalformed`; 0 of a bus that does not count."""
        return self._bus.malformed if isinstance(self._bus, CountsMalformed) else 0

    def recv(self, timeout: float | None = None) -> can.Message | None:
        frame = self._bus.recv(timeout)
        if frame is not None:
            if self._stamp:
                frame.timestamp = self._clock.now_s()
            self._log.append(_copy(frame, frame.timestamp, is_rx=True))
        return frame

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        # Before it is sent: an answer must not stand before its request.
        self._log.append(_copy(msg, self._clock.now_s(), is_rx=False))
        self._bus.send(msg, timeout)

    def shutdown(self) -> None:
        super().shutdown()
        self._bus.shutdown()


def _copy(frame: can.Message, timestamp: float, *, is_rx: bool) -> can.Message:
    """Return the frame without the name of its channel, which is not the same in another session."""
    return can.Message(
        timestamp=timestamp,
        arbitration_id=frame.arbitration_id,
        is_extended_id=frame.is_extended_id,
        is_remote_frame=frame.is_remote_frame,
        is_error_frame=frame.is_error_frame,
        dlc=frame.dlc,
        data=bytes(frame.data),
        is_rx=is_rx,
    )
