"""The stream of a serial line: its signals, its batches, and the count of what the line did not take."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.core.stream_ring import MAX_CHANNELS, StreamRecorder
from benchtool.emulator.firmware.objects import ObjectStore, Refused
from benchtool.emulator.servers.drive_node import NEVER
from benchtool.protocol.canopen import Abort
from benchtool.protocol.dictionary import Entry
from benchtool.protocol.serial import Batch, Stream, StreamFormat
from benchtool.ticks import wrap_tick

_WORD_BITS = 32
_NO_VALUE = -(1 << 15)
_HEADER_BYTES = 14


@dataclass(frozen=True)
class _Layout:
    """What a record holds, and how many of them make a batch."""

    entries: tuple[Entry, ...]
    scales: tuple[float, ...]
    format: StreamFormat
    stride: int
    batch: int

    def encode(self, rows: NDArray[np.uint32]) -> bytes:
        """Return the records of rows of 32-bit words, shape (rows, entries)."""
        if self.format is StreamFormat.WORDS:
            return rows.astype("<u4", copy=False).tobytes()
        steps = np.empty(rows.shape, "<i2")
        for number, (entry, scale) in enumerate(zip(self.entries, self.scales, strict=True)):
            assert entry.type.numpy is not None
            column = np.ascontiguousarray(rows[:, number]).view(entry.type.numpy)
            with np.errstate(invalid="ignore"):  # nan has a code of its own
                value = np.rint(column.astype(np.float64) / scale)
            inside = np.abs(value) < -_NO_VALUE
            steps[:, number] = np.where(inside, value, _NO_VALUE)
        return steps.tobytes()


class ControlRateStream:
    """The stream of one serial server; it uses the drive's recorder while it is configured.

    Args:
        objects: the drive's dictionary.
        recorder: the drive's, which the kernel fills.
        send: takes a batch; says whether the line did.
        max_payload: longest message that the host takes, bytes.
    """

    def __init__(
        self,
        objects: ObjectStore,
        recorder: StreamRecorder,
        send: Callable[[Batch], bool],
        max_payload: int,
    ) -> None:
        self.schema = 0
        self.sent = 0
        """Records under the last schema, whether the line took them or not."""
        self.dropped = 0
        """Those of them that it did not take."""
        self._objects = objects
        self._recorder = recorder
        self._send = send
        self._max_payload = max_payload
        self._layout: _Layout | None = None
        self._running = False
        self._sequence = 0

    @property
    def configured(self) -> bool:
        return self._layout is not None

    def layout(self, message: Stream) -> _Layout | None:
        """Return what a message asks for; None to stop.

        Raises:
            Refused: it cannot be.
        """
        if message.stride == 0:
            return None
        n = len(message.mappings)
        if message.batch == 0 or n == 0:
            raise Refused(Abort.VALUE_LOW)
        if n > MAX_CHANNELS:
            raise Refused(Abort.VALUE_HIGH)
        entries = tuple(self._signal(mapping) for mapping in message.mappings)
        if not all(math.isfinite(scale) and scale > 0.0 for scale in message.scales):
            raise Refused(Abort.VALUE)
        stream_format = StreamFormat(message.format)
        record = (4 if stream_format is StreamFormat.WORDS else 2) * n
        if _HEADER_BYTES + message.batch * record > self._max_payload:
            raise Refused(Abort.MAPPING_TOO_LONG)
        return _Layout(entries, message.scales, stream_format, message.stride, message.batch)

    def end(self) -> None:
        """Send what was recorded and record no more; the counts stay."""
        self.pause()
        self._layout = None

    def begin(self, layout: _Layout) -> None:
        """Make this the schema in force; counts restart, records with `resume`."""
        self._layout = layout
        self.schema = (self.schema + 1) & 0xFFFF
        self.sent = self.dropped = self._sequence = 0

    def resume(self) -> None:
        """Record from now on, if there is something to be recorded."""
        if self._layout is not None and not self._running:
            self._running = True
            self._recorder.start([entry.name for entry in self._layout.entries], self._layout.stride)

    def pause(self) -> None:
        """Send what was recorded, and record no more until `resume`."""
        if self._layout is not None and self._running:
            self._running = False
            self._recorder.stop()
            self.transmit()
            if self._recorder.waiting:
                self._send_batch(self._layout)

    def next_tick(self, tick: int) -> int:
        """Return the tick after `tick` in which a batch will be full."""
        if self._layout is None or not self._running:
            return NEVER
        return tick + max(1, self._recorder.ticks_until(self._layout.batch))

    def transmit(self) -> None:
        """Send every batch that is full."""
        if self._layout is not None:
            while self._recorder.waiting >= self._layout.batch:
                self._send_batch(self._layout)

    def _send_batch(self, layout: _Layout) -> None:
        lost, first_tick, rows = self._recorder.read(layout.batch)
        if lost:  # they count as a batch that was dropped, so that the host sees who lost them
            self._count(lost, sent=False)
        batch = Batch(self.schema, self._sequence, first_tick, layout.stride, len(rows), layout.encode(rows))
        self._count(len(rows), sent=self._send(batch))

    def _count(self, records: int, *, sent: bool) -> None:
        self._sequence = wrap_tick(self._sequence + 1)
        self.sent = wrap_tick(self.sent + records)
        if not sent:
            self.dropped = wrap_tick(self.dropped + records)

    def _signal(self, mapping: int) -> Entry:
        entry = self._objects.table.by_key.get((mapping >> 16, mapping >> 8 & 0xFF))
        if entry is None:
            raise Refused(Abort.NO_OBJECT)
        if (
            entry.mapping != mapping
            or not entry.mappable
            or entry.type.bits != _WORD_BITS
            or entry.access == "wo"
            or self._objects.is_computed(entry.name)
        ):
            raise Refused(Abort.NOT_MAPPABLE)
        return entry
