"""The frame bus of an in-process bench, with a barrier that makes virtual time independent of threads."""

from __future__ import annotations

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any
from weakref import WeakSet

import can
from can.interfaces.virtual import VirtualBus

from benchtool.clock import Clock
from benchtool.errors import LinkClosed

_LIVENESS_S = 0.1
_TAKE_BURSTS: WeakSet[queue.Queue[Any]] = WeakSet()
_SETTLED: WeakSet[queue.Queue[Any]] = WeakSet()  # whose frames need no thread of their own


@dataclass(frozen=True)
class FrameBurst:
    """Data frames of one identifier that were sent at once; `timestamp` and the rest are of each."""

    can_id: int
    frames: tuple[bytes, ...]
    timestamp: float
    channel: Any
    is_rx: bool

    def __iter__(self) -> Iterator[can.Message]:
        return (
            _data_frame(self.can_id, data, self.timestamp, self.channel, self.is_rx) for data in self.frames
        )

    def __len__(self) -> int:
        return len(self.frames)


Received = can.Message | FrameBurst


class VirtualTimeBus(VirtualBus):
    """A python-can virtual bus that knows when its receiver has handled everything sent to it.

    A receive loop asks for the next frame only after it has handled the one before, so `recv` marks frames as
    done when it comes back for more than it had taken. Plain python-can buses on the channel are its peers.

    Args:
        channel: name that peers share.
        clock: what stamps the frames sent from here; the wall clock's time of day if None. With a virtual one
            `settle` must be registered.
        options: those of python-can's VirtualBus.
    """

    def __init__(self, channel: str, *, clock: Clock | None = None, **options: Any) -> None:
        super().__init__(channel, **options)
        self._clock = clock
        self._taken: deque[Received | None] = deque()
        self._in_hand = 0
        self._receiver: threading.Thread | None = None
        self._handle: Callable[[Received], None] | None = None
        self._handling = threading.Lock()
        self._failures: deque[Exception] = deque()
        _TAKE_BURSTS.add(self.queue)

    def settle(self, timeout_s: float = 5.0) -> bool:
        """Wait until every frame sent to this bus has been handled; return whether there was one.

        Frames sent to a bus that has since been closed are not waited for.

        Raises:
            LinkClosed: the receiver has ended without closing the bus, or has not come back for `timeout_s`.
        """
        deadline_s = time.monotonic() + timeout_s
        if not (self._open and self.queue.unfinished_tasks):
            return False
        while True:
            handle = self._handle
            if handle is not None and not self._failures:
                self._hand_on_for_receiver(handle, timeout_s)
            with self.queue.all_tasks_done:
                waiting = self.queue.unfinished_tasks
                if not (self._open and waiting):
                    return True
                reason = self._stall_reason(deadline_s)
                if reason:
                    raise LinkClosed(
                        f"{waiting} frames on '{self.channel_id}' are not dealt with because {reason}; "
                        f"the receiver must call recv until it is closed: look for what ended it"
                    )
                if self._handle is None or self._failures:
                    self.queue.all_tasks_done.wait(min(_LIVENESS_S, timeout_s))

    def handle_with(self, handle: Callable[[Received], None]) -> bool:
        """Have `handle` take all frames from now on, called by `serve` and by `settle`, one at a time.

        With a virtual clock a frame wakes no thread then: to change threads twice for each takes longer than
        all else that is done with it, and who waits for an answer settles. Return False, and do nothing,
        where `recv` is another's or the number of frames that may wait is bounded.
        """
        if type(self).recv is not VirtualTimeBus.recv or self.queue.maxsize > 0:
            return False
        self._handle = handle
        if self._clock is not None and self._clock.virtual:
            _SETTLED.add(self.queue)
        return True

    def leave(self) -> None:
        """Undo `handle_with`: the receiver has ended."""
        self._handle = None
        _SETTLED.discard(self.queue)

    def serve(self, timeout_s: float) -> None:
        """Wait for frames and have them handled; return after `timeout_s` at the latest, or at `wake`.

        Raises:
            can.CanOperationError: the bus is closed.
            Exception: what `handle` has raised, here or while another thread settled.
        """
        self._check_if_open()
        self._receiver = threading.current_thread()
        with self.queue.not_empty:
            if not (self.queue.queue or self._failures):
                self.queue.not_empty.wait(timeout_s)
        if self._failures:
            raise self._failures.popleft()
        if self._handle is not None:
            self._hand_on(self._handle, timeout_s)

    def _hand_on_for_receiver(self, handle: Callable[[Received], None], timeout_s: float) -> None:
        """Hand frames on in place of the receiver; what `handle` raises is the receiver's."""
        try:
            self._hand_on(handle, timeout_s)
        except Exception as failure:  # noqa: BLE001 # raised by `serve`
            with self.queue.not_empty:
                self._failures.append(failure)
                self.queue.not_empty.notify()

    def _hand_on(self, handle: Callable[[Received], None], timeout_s: float) -> None:
        if not self._handling.acquire(timeout=timeout_s):
            return
        taken: deque[Received | None] = deque()
        done = 0
        try:
            with self.queue.mutex:
                taken.extend(self.queue.queue)
                self.queue.queue.clear()
            while taken:
                frame = taken.popleft()
                if frame is None:
                    continue  # of `wake`
                done += len(frame) if isinstance(frame, FrameBurst) else 1
                self._pass_filters(frame, handle)
        finally:
            with self.queue.all_tasks_done:
                self.queue.queue.extendleft(reversed(taken))
                self.queue.unfinished_tasks -= done
                if not self.queue.unfinished_tasks:
                    self.queue.all_tasks_done.notify_all()
            self._handling.release()

    def _pass_filters(self, received: Received, handle: Callable[[Received], None]) -> None:
        if self._filters is None:
            handle(received)
            return
        for each in received if isinstance(received, FrameBurst) else (received,):
            if self._matches_filters(each):
                handle(each)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """As in python-can, but without its deep copy, which costs more than the rest of the way."""
        self._check_if_open()
        timestamp = self._stamp(msg.timestamp)
        receivers = [each for each in self.channel if self.receive_own_messages or each is not self.queue]
        full = False
        for receiver in receivers:
            copy = _copied(msg)
            copy.timestamp, copy.channel, copy.is_rx = timestamp, self.channel_id, receiver is not self.queue
            if receiver.maxsize <= 0:
                with receiver.mutex:  # the queue's own `put`, where nothing is to be waited for
                    receiver.queue.append(copy)
                    receiver.unfinished_tasks += 1
                    if receiver not in _SETTLED:
                        receiver.not_empty.notify()
                continue
            try:
                receiver.put(copy, timeout=timeout)
            except queue.Full:
                full = True
        if full:
            raise can.CanOperationError("Could not send message to one or more recipients")

    def send_data(self, can_id: int, frames: Sequence[bytes], timestamp: float) -> None:
        """Send one or more data frames of an 11-bit identifier, as by `send`, at a tenth of its cost.

        Only where no peer bounds its queue, which python-can's buses do not unless they are asked to.
        """
        self._check_if_open()
        burst = FrameBurst(can_id, tuple(frames), self._stamp(timestamp), self.channel_id, is_rx=True)
        for receiver in self.channel:
            own = receiver is self.queue
            if own and not self.receive_own_messages:
                continue
            copy = replace(burst, is_rx=False) if own else burst
            with receiver.mutex:
                receiver.queue.extend([copy] if receiver in _TAKE_BURSTS else copy)
                receiver.unfinished_tasks += len(frames)
                if receiver not in _SETTLED:
                    receiver.not_empty.notify()

    def _stamp(self, given_s: float) -> float:
        if self.preserve_timestamps:
            return given_s
        return time.time() if self._clock is None else self._clock.now_s()

    @property
    def is_unbounded(self) -> bool:
        """Whether none of its peers bounds its queue."""
        return all(receiver.maxsize <= 0 for receiver in self.channel)

    def shutdown(self) -> None:
        super().shutdown()
        with self.queue.all_tasks_done:
            self.queue.all_tasks_done.notify_all()

    def recv(self, timeout: float | None = None) -> can.Message | None:
        """As in python-can; what is there already is taken at once, at a tenth of the cost."""
        if self._filters is not None:
            return super().recv(timeout)
        return self._recv_internal(timeout)[0]

    def wake(self) -> None:
        """Have a `recv` that waits, or else the next, return without a frame."""
        with self.queue.mutex:
            self.queue.queue.append(None)  # no task: there is nothing to handle
            self.queue.not_empty.notify()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        taken = self._take(timeout)
        if isinstance(taken, FrameBurst):
            first, *others = taken
            self._taken.extendleft(reversed(others))
            return first, False
        return taken, False

    def _take(self, timeout: float | None) -> Received | None:
        self._check_if_open()
        if not self._taken:
            self._take_all()
        if self._taken:
            return self._taken.popleft()
        taken: Received | None = super()._recv_internal(timeout)[0]
        self._in_hand = len(taken) if isinstance(taken, FrameBurst) else int(taken is not None)
        return taken

    def _take_all(self) -> None:
        """Take what is there, unless a peer may wait for room; frames taken before are done."""
        self._receiver = threading.current_thread()
        with self.queue.all_tasks_done:
            self.queue.unfinished_tasks -= self._in_hand
            if self._in_hand and not self.queue.unfinished_tasks:
                self.queue.all_tasks_done.notify_all()
            self._in_hand = 0
            if self.queue.maxsize <= 0:
                self._taken.extend(self.queue.queue)
                self.queue.queue.clear()
                self._in_hand = self.queue.unfinished_tasks

    def _stall_reason(self, deadline_s: float) -> str:
        if self._receiver is not None and not self._receiver.is_alive():
            return f"the receive thread '{self._receiver.name}' has ended"
        if time.monotonic() > deadline_s:
            return "the receiver does not come back for the next one"
        return ""


def _data_frame(can_id: int, data: bytes, timestamp: float, channel: Any, is_rx: bool) -> can.Message:
    """Return a data frame, without the constructor, as `_copied`."""
    frame = can.Message.__new__(can.Message)
    frame.arbitration_id, frame.dlc, frame.data = can_id, len(data), bytearray(data)
    frame.timestamp, frame.channel, frame.is_rx = timestamp, channel, is_rx
    frame.is_extended_id = frame.is_remote_frame = frame.is_error_frame = False
    frame.is_fd = frame.bitrate_switch = frame.error_state_indicator = False
    return frame


def _copied(msg: can.Message) -> can.Message:
    """Return a copy of a frame, without the constructor, which takes three times as long."""
    copy = can.Message.__new__(can.Message)
    copy.arbitration_id = msg.arbitration_id
    copy.is_extended_id = msg.is_extended_id
    copy.is_remote_frame = msg.is_remote_frame
    copy.is_error_frame = msg.is_error_frame
    copy.dlc = msg.dlc
    copy.data = bytearray(msg.data)
    copy.is_fd = msg.is_fd
    copy.bitrate_switch = msg.bitrate_switch
    copy.error_state_indicator = msg.error_state_indicator
    return copy
