"""The stream at the control rate: rows of up to 16 signals go into a ring for as long as it runs.

The kernel never waits for a reader. It counts the rows it writes; a reader that is too late finds the oldest
rows overwritten, and gets their number.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit
from benchtool.emulator.memory import Record, record_type, word_offset
from benchtool.errors import ValueRefused
from benchtool.ticks import wrap_tick

MAX_CHANNELS = 16
RING_ROWS = 4096

# `written` counts rows since the start, `row` is where the next one goes.
STREAM = record_type(
    [("running", "u4"), ("stride", "u4"), ("until_row", "u4"), ("written", "i8"), ("row", "i8")]
)


@njit
def stream_row(
    stream: Any,
    drive_words: NDArray[np.uint32],
    channels: NDArray[np.uint32],
    ring: NDArray[np.uint32],
) -> None:
    """Write a row if one is due, when all signals of the tick are fresh."""
    if stream.running == 0:
        return
    if stream.until_row > 0:
        stream.until_row -= 1
        return
    stream.until_row = stream.stride - 1
    for column in range(channels.size):
        ring[stream.row, column] = drive_words[channels[column]]
    stream.row = stream.row + 1 if stream.row + 1 < ring.shape[0] else 0
    stream.written += 1


class StreamRows(NamedTuple):
    """Rows in order of time: `lost` were overwritten before them, the first one left is of `first_tick`."""

    lost: int
    first_tick: int
    rows: NDArray[np.uint32]


class StreamRecorder:
    """The stream of one drive; the kernel fills its ring while the core runs.

    Args:
        memory: the drive's.
        tick: tells its tick, counted on past 2**32: the grid of a stream does not shift where that wraps.
    """

    def __init__(self, memory: Record, tick: Callable[[], int]) -> None:
        self._memory = memory
        self._tick = tick
        self.record: Record = np.zeros(1, STREAM)
        self.channels = np.zeros(0, np.uint32)
        self.ring = np.zeros((1, 0), np.uint32)
        self._origin = 0
        self._read = 0

    def start(self, names: Sequence[str], stride: int) -> None:
        """Discard unread rows, and write a row in every tick that is a multiple of `stride` from now on.

        Raises:
            ValueRefused: a name is no four-byte field of the memory, or a number is out of its limits.
        """
        fields = self._memory.dtype.names or ()
        for name in names:
            if name not in fields or self._memory.dtype[name].itemsize != 4:
                raise ValueRefused(
                    f"'{name}' cannot be streamed, a signal of four bytes is needed: choose one"
                )
        if not 1 <= len(names) <= MAX_CHANNELS:
            raise ValueRefused(f"{len(names)} channels to stream, 1 to {MAX_CHANNELS} can be: choose fewer")
        if stride < 1:
            raise ValueRefused(f"stride of {stride}, 1 or more is needed: correct it")
        tick = self._tick()
        self.channels = np.array([word_offset(self._memory, name) for name in names], np.uint32)
        self.ring = np.zeros((RING_ROWS, len(names)), np.uint32)
        self._origin = (tick // stride + 1) * stride
        self._read = 0
        self.record[:] = 0
        stream = self.record[0]
        stream.stride = stride
        stream.until_row = self._origin - tick - 1
        stream.running = 1

    def stop(self) -> None:
        """Write no more; what is in the ring can still be taken."""
        self.record[0].running = 0

    def ticks_until(self, rows: int) -> int:
        """Return the ticks from now until `rows` rows wait to be taken; 0 if they do."""
        stream = self.record[0]
        missing = rows - (int(stream.written) - self._read)
        return int(stream.until_row) + 1 + (missing - 1) * int(stream.stride) if missing > 0 else 0

    @property
    def waiting(self) -> int:
        """Rows written and not yet taken, overwritten ones among them."""
        return int(self.record[0].written) - self._read

    def read(self, rows: int) -> StreamRows:
        """Return the oldest rows, at most so many, which are given away; shape (rows, channels), as 32-bit
        words."""
        lost = max(0, self.waiting - len(self.ring))
        first = self._read + lost
        self._read = min(first + rows, int(self.record[0].written))
        first_tick = wrap_tick(self._origin + first * int(self.record[0].stride))
        return StreamRows(lost, first_tick, self.ring[np.arange(first, self._read) % len(self.ring)])
