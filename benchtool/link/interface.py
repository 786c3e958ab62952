"""Interfaces of links, independent of the wire."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol, runtime_checkable

from benchtool.clock import Clock
from benchtool.link.process_data import ProcessData

if TYPE_CHECKING:
    from benchtool.protocol.canopen import Emergency, NmtCommand, NmtState
    from benchtool.protocol.serial import Batch, StreamReply


@dataclass(frozen=True)
class LinkCounters:
    """Counters of a link since it was opened."""

    frames_received: int = 0
    frames_dropped: int = 0  # malformed
    receive_errors: int = 0  # the adapter's driver raised; reception went on
    overruns: int = 0  # well-formed, but not taken in time
    retries: int = 0  # reads, or chunks of one, that were asked for again
    stale_answers: int = 0  # to a request that had been given up
    sdo_aborts: int = 0
    emcy_received: int = 0
    emcy_lost: int = 0  # by the numbers of those received, where the wire has such
    heartbeats_received: int = 0
    boots_received: int = 0  # boot-up messages: the drive, or another node with its number, has started


class Frame(NamedTuple):
    """A frame as it arrived, at `arrival_s` of the host's clock."""

    can_id: int
    data: bytes
    arrival_s: float


class ReceivedEmergency(NamedTuple):
    """An emergency as it arrived, at `arrival_s` of the host's clock."""

    emergency: Emergency
    arrival_s: float


FrameReceiver = Callable[[Frame], None]
BatchReceiver = Callable[["Batch", float], None]
"""Takes a batch of telemetry, and when it arrived on the host's clock."""


@runtime_checkable
class CountsMalformed(Protocol):
    """A bus whose adapter protocol counts malformed input."""

    @property
    def malformed(self) -> int:
        """Number of malformed inputs."""


@runtime_checkable
class CountsAnswers(Protocol):
    """A link on which two nodes may have the same number."""

    def answers(self, index: int, sub: int) -> int:
        """Return how many answers come to one request for an object.

        Raises:
            NoAnswer: none.
        """


class Link(Protocol):
    """One drive at the other end. Every call is synchronous and may come from any thread.

    Each method but `close` raises LinkClosed once the link is closed or its adapter is gone.
    """

    @property
    def node_id(self) -> int:
        """The drive's address."""

    @property
    def counters(self) -> LinkCounters:
        """Snapshot."""

    @property
    def clock(self) -> Clock:
        """Clock of its waits and arrival times."""

    @property
    def process_data(self) -> ProcessData:
        """How it carries streams and setpoints."""

    def upload(self, index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        """Return the bytes of one object; `block` for a transfer that is fast for long ones. The request is
        repeated once if necessary.

        `length` is how many bytes the object has: so many are taken of an answer that brings four and does
        not say how many of them count, as an expedited SDO transfer may. It changes no other answer.

        Raises:
            NoAnswer: no response came.
            SdoAbort: the drive refused.
            LinkError: the response is damaged or out of protocol.
        """

    def download(self, index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        """Write one object. Sent once: whether to repeat a write that failed is for the caller to decide.

        Raises:
            NoAnswer: nothing came back; the drive may hold either value.
            SdoAbort: the drive refused.
            LinkError: the response is damaged or out of protocol.
        """

    def nmt(self, command: NmtCommand) -> None:
        """Send an NMT command; only the heartbeat confirms it."""

    def send_heartbeat(self) -> None:
        """Feed the drive's link supervision, once."""

    def heartbeat_state(self) -> NmtState | None:
        """Return the state in the drive's last heartbeat; None before the first."""

    def wait_heartbeat(self, timeout_s: float) -> NmtState:
        """Return the state in the drive's next heartbeat.

        Raises:
            NoAnswer: none came within `timeout_s` of the link's clock.
        """

    def emergencies(self) -> tuple[ReceivedEmergency, ...]:
        """Return the emergencies since the last call, oldest first."""

    def close(self) -> None:
        """End reception and close the adapter; a second call does nothing."""


@runtime_checkable
class FrameLink(Link, Protocol):
    """A link whose process data are CAN frames."""

    def subscribe(self, can_ids: Iterable[int], receiver: FrameReceiver) -> None:
        """Have `receiver` called with every frame of these identifiers, in the receive thread: it must be
        quick, and must not transfer."""

    def unsubscribe(self, can_ids: Iterable[int]) -> None:
        """Cancel a subscription."""

    def send_pdo(self, can_id: int, data: bytes) -> None:
        """Send process data, which are not confirmed."""


@runtime_checkable
class BatchLink(Link, Protocol):
    """A link whose process data are setpoints and batches of records."""

    def batch_rows(self, channels: int) -> int:
        """Return the records of so many words of four bytes that the drive can put in one batch; 0 if none
        fits."""

    def configure_stream(self, mappings: Sequence[int] = (), stride: int = 0, batch: int = 1) -> StreamReply:
        """Have the drive stream these objects every `stride` ticks, `batch` records at a time; 0 stops it.

        The request is sent once.

        Raises:
            NoAnswer: nothing came back; the drive may stream or not.
            SdoAbort: the drive refused.
        """

    def on_batch(self, receiver: BatchReceiver | None) -> None:
        """Have `receiver` called with every batch, in the receive thread: it must be quick, and must not
        transfer."""

    def send_setpoint(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        """Send both setpoints, which are not confirmed."""
