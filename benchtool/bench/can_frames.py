"""Frames of instruments on a CAN bus: reception, checks against the DBC message, counters."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import can

from benchtool.clock import Clock
from benchtool.errors import LinkClosed, NoAnswer
from benchtool.link import Frame, FrameReceiver
from benchtool.link.canopen import receive_frames, stop_receiving
from benchtool.protocol import DbcMessage

_SILENT_FRAMES = 5
_SILENT_S = 0.1
_POLL_S = 0.02
_MOST_FRAMES = 1_000_000
_BEFORE_S = 0.1  # kept before a recording starts, so that it covers its first moment


class ReceivedFrame(NamedTuple):
    """A valid frame: its timestamp on the host's clock, and the values of its signals."""

    arrival_s: float
    values: Mapping[str, float]


@dataclass(frozen=True)
class FrameCounters:
    """Counters of the frames of one message since reception began.

    `malformed` could not be decoded, `out_of_range` had a signal beyond the range of the DBC file or not a
    number, `overflow` came when a recording was full: all of these were dropped.
    """

    received: int = 0
    malformed: int = 0
    out_of_range: int = 0
    overflow: int = 0

    @property
    def dropped(self) -> int:
        """Number of dropped frames."""
        return self.malformed + self.out_of_range + self.overflow


class MessageListener:
    """Takes the frames of one message, `rate_Hz` a second, from a receive thread.

    Args:
        message: what is listened to.
        rate_Hz: how often it is to come.
        clock: the host's, on which frames are stamped.
        check: raises the exception that ended reception, if there is one.
        most: frames that a recording may hold.
    """

    def __init__(
        self,
        message: DbcMessage,
        rate_Hz: float,
        clock: Clock,
        *,
        check: Callable[[], None] = lambda: None,
        most: int = _MOST_FRAMES,
    ) -> None:
        self.message = message
        self.longest_s = most / rate_Hz
        self.silence_s = max(_SILENT_FRAMES / rate_Hz, _SILENT_S)
        self._clock = clock
        self._check = check
        self._most = most
        self._lock = threading.Lock()
        self._counts = dict.fromkeys(("received", "malformed", "out_of_range", "overflow"), 0)
        self._recent: deque[ReceivedFrame] = deque(maxlen=max(2, round(_BEFORE_S * rate_Hz)))
        self._kept: list[ReceivedFrame] | None = None
        self._last_s: float | None = None

    @property
    def counters(self) -> FrameCounters:
        """Snapshot."""
        with self._lock:
            return FrameCounters(**self._counts)

    def on_frame(self, frame: Frame) -> None:
        """Take a frame of this message; called in a receive thread. Never raises."""
        values = self.message.decode(frame.data)
        with self._lock:
            self._counts["received"] += 1
            if values is None:
                self._counts["malformed"] += 1
                return
            self._last_s = frame.arrival_s  # a frame out of range still shows that the instrument is alive
            if not all(self.message.ranges[name].holds(value) for name, value in values.items()):
                self._counts["out_of_range"] += 1
                return
            arrived = ReceivedFrame(frame.arrival_s, values)
            self._recent.append(arrived)
            if self._kept is not None:
                if len(self._kept) < self._most:
                    self._kept.append(arrived)
                else:
                    self._counts["overflow"] += 1

    def start(self) -> None:
        """Keep every frame from a tenth of a second ago on."""
        with self._lock:
            self._kept = list(self._recent)

    def stop(self) -> list[ReceivedFrame]:
        """Return the frames kept since `start` and clear them."""
        with self._lock:
            kept, self._kept = self._kept or [], None
            return kept

    def require_alive(self) -> None:
        """Wait for a frame unless one came just now.

        Raises:
            NoAnswer: none comes.
        """
        waited_s = 0.0
        while self.silent_for_s() > self.silence_s:
            if waited_s > self.silence_s:
                raise self._silent()
            self._clock.wait(_POLL_S)
            waited_s += _POLL_S

    def require_still_alive(self) -> None:
        """Check that it has not fallen silent.

        Raises:
            NoAnswer: it has.
        """
        if self.silent_for_s() > self.silence_s:
            raise self._silent()

    def silent_for_s(self) -> float:
        """Return the seconds since the last frame; infinite before the first."""
        with self._lock:
            return float("inf") if self._last_s is None else self._clock.now_s() - self._last_s

    def latest(self) -> Mapping[str, float]:
        """Return the values of the last valid frame.

        Raises:
            NoAnswer: no recent frame.
        """
        self.require_alive()
        with self._lock:
            if self._recent and self._clock.now_s() - self._recent[-1].arrival_s <= self.silence_s:
                return self._recent[-1].values
        raise self._silent()

    def _silent(self) -> NoAnswer:
        self._check()
        counters = self.counters
        seen = f"{counters.received} frames came so far, {counters.dropped} of them damaged or out of range"
        return NoAnswer(
            f"no frame of '{self.message.name}' (identifier 0x{self.message.can_id:X}) for "
            f"{self.silence_s:g} s; {seen}: check that the instrument is powered and measures, its bit rate, "
            f"its wiring and the DBC file"
        )


class BusListener:
    """A receive thread on a bus of instruments; it never sends.

    Args:
        bus: open bus, owned from now on.
        arrival_s: when a frame arrived, on the host's clock.
    """

    def __init__(self, bus: can.BusABC, arrival_s: Callable[[can.Message], float]) -> None:
        self._bus = bus
        self._receivers: dict[tuple[int, bool], FrameReceiver] = {}
        self._arrival_s = arrival_s
        self._stopping = threading.Event()
        self._failure: Exception | None = None
        self._thread = threading.Thread(target=self._receive, name="benchtool-instruments", daemon=True)
        self._thread.start()

    def listen(self, can_id: int, receiver: FrameReceiver, *, extended: bool) -> None:
        """Have `receiver` called with every frame of an identifier, of 29 bits if `extended`."""
        self._receivers = self._receivers | {(can_id, extended): receiver}

    def close(self) -> None:
        """End reception and close the bus."""
        stop_receiving(self._bus, self._stopping)
        self._thread.join()
        self._bus.shutdown()

    def check(self) -> None:
        """Raise the exception that ended reception.

        Raises:
            LinkClosed: the adapter stopped working.
        """
        if self._failure is not None:
            raise LinkClosed(
                f"the adapter of the instruments stopped working: {self._failure}; check its cable and driver"
            ) from self._failure

    def _receive(self) -> None:
        self._failure = receive_frames(self._bus, self._stopping, self._handle)

    def _handle(self, frame: can.Message) -> None:
        if frame.is_error_frame or frame.is_remote_frame:
            return
        receiver = self._receivers.get((frame.arbitration_id, frame.is_extended_id))
        if receiver is not None:
            receiver(Frame(frame.arbitration_id, bytes(frame.data), self._arrival_s(frame)))
