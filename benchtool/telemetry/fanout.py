"""Blocks from one stream to several sinks, each with a thread and a bounded queue of its own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack

from benchtool.block import Block
from benchtool.errors import RecordingError
from benchtool.telemetry.worker import Worker

_ROOM_S = 2.0


class Sink:
    """A destination of blocks.

    Args:
        name: for messages.
        take: called with each block, in the thread of the sink.
        lossless: wait for a full queue, and raise an error after `room_s`; otherwise drop and count blocks.
        size: blocks that may wait.
        room_s: wall time that a lossless sink has to make room.
    """

    def __init__(
        self,
        name: str,
        take: Callable[[Block], None],
        *,
        lossless: bool,
        size: int = 64,
        room_s: float = _ROOM_S,
    ) -> None:
        self.name = name
        self.lossless = lossless
        self.rows_dropped = 0
        self.worker = Worker(f"benchtool-{name}", take, size)
        self._size = size
        self._room_s = room_s

    def put(self, block: Block) -> None:
        """Hand over a block.

        Raises:
            RecordingError: the sink is lossless and does not keep up.
        """
        if self.worker.put(block, self._room_s if self.lossless else 0.0):
            return
        if self.lossless:
            raise RecordingError(
                f"sink '{self.name}' is {self._size} blocks behind and took none for {self._room_s:g} s, "
                f"nothing may be lost on the way to it: use a faster disk, fewer channels or a lower rate"
            )
        self.rows_dropped += len(block.data)


class FanOut:
    """Passes every block to every sink."""

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self.sinks = tuple(sinks)

    def put(self, block: Block) -> None:
        """Hand a block to all.

        Raises:
            RecordingError: a lossless sink does not keep up.
        """
        for sink in self.sinks:
            sink.put(block)

    def check(self) -> None:
        """Raise the exception of a lossless sink; a failure of a viewer only stops the viewer."""
        for sink in self.sinks:
            if sink.lossless:
                sink.worker.check()

    def close(self) -> None:
        """Handle all queued blocks, and end the threads."""
        with ExitStack() as stack:
            for sink in self.sinks:
                stack.callback(sink.worker.close)
