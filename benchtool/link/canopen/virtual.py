"""The frame bus of an in-process bench, with a barrier that makes virtual time independent of threads."""

from __future__ import annotations

import queue
import threading
import time
from typing import Any

import can
from can.interfaces.virtual import VirtualBus

from benchtool.clock import Clock
from benchtool.errors import LinkClosed

_LIVENESS_S = 0.1


class VirtualTimeBus(VirtualBus):
    """A python-can virtual bus that knows when its receiver has handled everything sent to it.

    A receive loop asks for the next frame only after it has handled the one before, so each call of `recv`
    marks the previous frame as done. Plain python-can buses on the channel are its peers.

    Args:
        channel: name that peers share.
        clock: what stamps the frames sent from here; the wall clock's time of day if None.
        options: those of python-can's VirtualBus.
    """

    def __init__(self, channel: str, *, clock: Clock | None = None, **options: Any) -> None:
        super().__init__(channel, **options)
        self._clock = clock
        self._in_hand = False
        self._receiver: threading.Thread | None = None

    def settle(self, timeout_s: float = 5.0) -> bool:
        """Wait until every frame sent to this bus has been handled; return whether there was one.

        Frames sent to a bus that has since been closed are not waited for.

        Raises:
            LinkClosed: the receiver has ended without closing the bus, or has not come back for `timeout_s`.
        """
        deadline_s = time.monotonic() + timeout_s
        with self.queue.all_tasks_done:
            if not (self._open and self.queue.unfinished_tasks):
                return False
            while self._open and (waiting := self.queue.unfinished_tasks):
                reason = self._stall_reason(deadline_s)
                if reason:
                    raise LinkClosed(
                        f"{waiting} frames on '{self.channel_id}' are not dealt with because {reason}; "
                        f"the receiver must call recv until it is closed: look for what ended it"
                    )
                self.queue.all_tasks_done.wait(min(_LIVENESS_S, timeout_s))
        return True

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """As in python-can, but without its deep copy, which costs more than the rest of the way."""
        self._check_if_open()
        if self.preserve_timestamps:
            timestamp = msg.timestamp
        else:
            timestamp = time.time() if self._clock is None else self._clock.now_s()
        full = False
        for receiver in tuple(self.channel):
            own = receiver is self.queue
            if own and not self.receive_own_messages:
                continue
            copy = can.Message(
                timestamp=timestamp,
                arbitration_id=msg.arbitration_id,
                is_extended_id=msg.is_extended_id,
                is_remote_frame=msg.is_remote_frame,
                is_error_frame=msg.is_error_frame,
                channel=self.channel_id,
                dlc=msg.dlc,
                data=bytes(msg.data),
                is_fd=msg.is_fd,
                is_rx=not own,
                bitrate_switch=msg.bitrate_switch,
                error_state_indicator=msg.error_state_indicator,
            )
            try:
                receiver.put(copy, timeout=timeout)
            except queue.Full:
                full = True
        if full:
            raise can.CanOperationError("Could not send message to one or more recipients")

    def shutdown(self) -> None:
        super().shutdown()
        with self.queue.all_tasks_done:
            self.queue.all_tasks_done.notify_all()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        self._receiver = threading.current_thread()
        if self._in_hand:
            self._in_hand = False
            self.queue.task_done()
        received = super()._recv_internal(timeout)
        self._in_hand = received[0] is not None
        return received

    def _stall_reason(self, deadline_s: float) -> str:
        if self._receiver is not None and not self._receiver.is_alive():
            return f"the receive thread '{self._receiver.name}' has ended"
        if time.monotonic() > deadline_s:
            return "the receiver does not come back for the next one"
        return ""
