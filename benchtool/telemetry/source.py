"""What a stream asks of the wire that carries it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeVar

from benchtool.block import Block
from benchtool.protocol.telemetry import StreamCounters
from benchtool.telemetry.node import Node

Item = TypeVar("Item")


@dataclass(frozen=True)
class Sent:
    """What the drive says of a stream that has ended.

    `records` is how many there were to send, `dropped` how many of them it could not, as its line was full.
    """

    records: int
    dropped: int = 0


class Decoder(Protocol):
    """What makes Blocks of what has come, as the stream sees it: how it is fed differs by wire."""

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

    def take(self) -> Block | None:
        """The rows since the last call, which are given away; None if there are none."""


class Source(Protocol[Item]):
    """One configuration of a stream over one wire: `start`, then `feed`, `stop`, `detach`.

    `start`, `stop` and `detach` are called by whoever owns the stream; `feed`, and `take` of the decoder, in
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
            SdoAbort, NoAnswer, WriteNotVerified: the drive does not let itself be set up.
        """

    def stop(self) -> Sent:
        """Have the drive stop."""

    def detach(self) -> None:
        """Take the receiver back; nothing is asked of the drive."""

    def feed(self, item: Item) -> bool:
        """Give the decoder what was received; whether it completed a record. Never raises."""


def control_period_s(node: Node) -> float:
    """The drive's control period, to whole nanoseconds: the drive has it as a float32."""
    return round(node.number("control_period") * 1e9) * 1e-9
