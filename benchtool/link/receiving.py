"""Base of links with a receive thread: closing, failure, heartbeats and emergencies."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from dataclasses import fields
from types import TracebackType
from typing import Self

from benchtool.clock import Clock
from benchtool.errors import LinkClosed, LinkError
from benchtool.link.heartbeat_emcy import HeartbeatEmcyConsumer
from benchtool.link.interface import LinkCounters, ReceivedEmergency
from benchtool.protocol.canopen import NmtState


class ReceivingLink(ABC):
    """A link with a thread that runs `_receive`.

    What derives from it starts `_thread` when all that reception needs is there. `_receive` returns once
    `_stopping` is set, or when the device is gone, which it notes as `_failure`; it hands heartbeats and
    emergencies to `_announced`.

    Args:
        node_id: the drive's.
        clock: what `wait_heartbeat` goes by.
        thread_name: of the receive thread.
        device: what frames or bytes go through, for messages.
        check: what to look at when that has stopped working, for messages.
    """

    def __init__(self, node_id: int, clock: Clock, *, thread_name: str, device: str, check: str) -> None:
        self.clock = clock
        self._node_id = node_id
        self._device = device
        self._check = check
        self._close_lock = threading.Lock()
        self._stopping = threading.Event()
        self._failure: Exception | None = None
        self._announced = HeartbeatEmcyConsumer(node_id, clock, self._require_open)
        self._counts = dict.fromkeys((field.name for field in fields(LinkCounters)), 0)
        self._thread = threading.Thread(target=self._receive, name=thread_name, daemon=True)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @property
    def node_id(self) -> int:
        return self._node_id

    def heartbeat_state(self) -> NmtState | None:
        """See `Link.heartbeat_state`."""
        return self._announced.heartbeat_state()

    def wait_heartbeat(self, timeout_s: float) -> NmtState:
        """See `Link.wait_heartbeat`."""
        return self._announced.wait_heartbeat(timeout_s)

    def emergencies(self) -> tuple[ReceivedEmergency, ...]:
        """See `Link.emergencies`. The first 256 are kept, as the cause is among the first."""
        return self._announced.emergencies()

    def close(self) -> None:
        """See `Link.close`."""
        with self._close_lock:
            if self._stopping.is_set():
                return
            self._stop_receiving()
            self._thread.join()
            self._close_device()

    @abstractmethod
    def _receive(self) -> None:
        """What the receive thread does."""

    def _stop_receiving(self) -> None:
        """Have the receive thread end soon."""
        self._stopping.set()

    @abstractmethod
    def _close_device(self) -> None:
        """Close the device; the receive thread has ended."""

    def _require_open(self) -> None:
        if self._failure is not None:
            raise LinkClosed(
                f"the {self._device} of node {self._node_id} stopped working: {self._failure}; "
                f"check {self._check}, then connect again"
            ) from self._failure
        if self._stopping.is_set():
            raise LinkClosed(f"the link to node {self._node_id} is closed; connect again")

    def _send_failure(self, reason: Exception, failing_s: float, check: str) -> LinkError:
        """Return what to raise when sending has failed.

        Args:
            failing_s: how long reception takes at the most to fail when the device is gone.
            check: what to look at when it is not gone.

        Raises:
            LinkClosed: it is.
        """
        # If the device is gone, reception fails too, a moment later: then that is reported.
        self._thread.join(failing_s)
        self._require_open()
        return LinkError(f"sending to node {self._node_id} failed: {reason}; check {check}")
