"""Process data as a wire carries them: the source of a stream, and setpoints at a rate.

A link has one `ProcessData`, so that the stream of a drive and its setpoints follow from the open link alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from benchtool.block import Block
from benchtool.clock import Clock
from benchtool.protocol import StreamCounters
from benchtool.protocol.dictionary import Dictionary, Value, Variable

Item = TypeVar("Item")


class DriveAccess(Protocol):
    """A drive by the names of its dictionary; see `RemoteDrive` for what its methods raise."""

    @property
    def dictionary(self) -> Dictionary: ...
    @property
    def clock(self) -> Clock: ...

    def tick_now(self) -> int | None: ...
    def number(self, name: str) -> float: ...
    def write(self, name: str, value: Value) -> None: ...


@dataclass(frozen=True)
class Sent:
    """Counts of a stream that has ended, as the drive reports them.

    `records` is how many there were to send, `dropped` how many of them it could not, as its line was full.
    """

    records: int
    dropped: int = 0


class Decoder(Protocol):
    """Converts received records to Blocks; how it is fed depends on the wire."""

    @property
    def counters(self) -> StreamCounters:
        """Snapshot."""

    @property
    def rows(self) -> int:
        """Rows that wait to be taken."""

    @property
    def tick(self) -> int:
        """Tick of the last record received, counted on past 2**32."""

    @property
    def arrival_s(self) -> float:
        """When that record arrived."""

    def pop_block(self) -> Block | None:
        """Return the rows since the last call and clear them; None if there are none."""


class Source(Protocol[Item]):
    """One configuration of a stream over one wire: `start`, then `feed`, `stop`, `detach`.

    `start`, `stop` and `detach` are called by the owner of the stream; `feed`, and `take` of the decoder, in
    one thread, which handles what `start`'s receiver was given.
    """

    @property
    def stride(self) -> int:
        """Ticks between two records."""

    @property
    def tick_s(self) -> float:
        """The drive's control period."""

    @property
    def decoder(self) -> Decoder:
        """Fed by `feed`; `start` may put another in its place."""

    def start(self, receive: Callable[[Item], None]) -> None:
        """Set the drive up; `receive` is called in the link's receive thread, and must be quick.

        Raises:
            SdoAbort, NoAnswer, WriteNotVerified: the drive cannot be set up.
        """

    def stop(self) -> Sent:
        """Have the drive stop."""

    def detach(self) -> None:
        """Remove the receiver; nothing is sent to the drive."""

    def feed(self, item: Item) -> bool:
        """Give the decoder what was received; whether it completed a record. Never raises."""


class SetpointMessage(Protocol):
    """Setpoints of torque and speed in one message that nothing confirms."""

    def encode(self, torque_Nm: float, omega_m_rad_s: float) -> bytes:
        """Return both as the drive takes them.

        Raises:
            ValueRefused: one is outside its limits.
        """

    def send(self, torque_Nm: float, omega_m_rad_s: float) -> None:
        """Send both.

        Raises:
            ValueRefused: one is outside its limits; nothing was sent.
        """

    def close(self) -> None:
        """Stop the drive from taking setpoints, and restore what was set up.

        Raises:
            BenchError: the drive does not answer or refuses; the notes say how it is left.
        """


class ProcessData(Protocol):
    """How one open link carries process data; the messages depend on the wire."""

    def fitting(self, dictionary: Dictionary, channels: Sequence[str]) -> tuple[str, ...]:
        """Return those of the signals that the drive has, at most as many as a record holds."""

    def source(
        self, drive: DriveAccess, channels: Sequence[str], rate_Hz: float, after: Source[Any] | None = None
    ) -> Source[Any]:
        """Return a stream of these signals; nothing is set up yet.

        `after` is the source that this one goes on for, which knows what the drive was set up for before.

        Raises:
            ValueRefused: the drive cannot stream this.
        """

    def setpoints(
        self, drive: DriveAccess, torque: Variable | None, speed: Variable | None
    ) -> SetpointMessage:
        """Set the drive up for setpoints of these objects in Nm and rad/s, of which one may be left out.

        Raises:
            ValueRefused: the drive takes no such setpoints.
            SdoAbort, NoAnswer, WriteNotVerified: it cannot be set up.
        """


def encoded(variable: Variable | None, value: float) -> bytes:
    """Return a setpoint as the drive takes it; nothing for one that is left out."""
    return b"" if variable is None else variable.encode(value)


def control_period_s(drive: DriveAccess) -> float:
    """Return the drive's control period, to whole nanoseconds: the drive has it as a float32."""
    return round(drive.number("control_period") * 1e9) * 1e-9
