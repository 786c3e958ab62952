"""What supervises an enabled drive by what it streams: between drive, streams and supervisor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from benchtool.block import Block


class StreamSupervisor(Protocol):
    """Looks at every stream of a drive, and streams itself while a drive is enabled that streams nothing."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Signals that it needs in a stream; none if it looks at nothing."""

    def begin(self) -> None:
        """The drive is about to be enabled.

        Raises:
            BenchError: it cannot be supervised; it must not be enabled.
        """

    def end(self) -> None:
        """The drive is disabled, or as far as it can be. Never raises."""

    def check(self) -> None:
        """Raise what was found since `begin`, after the drive was stopped.

        Raises:
            LimitTrip: a limit was passed.
        """

    def stream_opens(self, names: Sequence[str]) -> None:
        """A stream of these signals is about to begin; a drive has one at a time.

        Raises:
            ValueRefused: the drive is enabled, and signals are missing in it.
        """

    def stream_closed(self) -> None:
        """That stream has ended."""

    def take(self, block: Block) -> None:
        """Look at a block of a stream, in a thread of its own."""
