"""The full-rate stream: batches of records of one schema, put together to Blocks.

The records of a batch are consecutive, so rows can only be missing between batches. Sequence number and tick
must both continue; a batch that fits only one of them, of another stream or repeated, is dropped.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block, Channel, Gap
from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.variable import Variable
from benchtool.protocol.serial.messages import Batch, StreamFormat
from benchtool.protocol.telemetry import StreamCounters
from benchtool.ticks import TICKS, ticks_since, unwrap_tick

_NO_VALUE = -(1 << 15)  # what a drive sends for a value that is not finite or beyond the int16's reach


class BatchDecoder:
    """Converts batches to Blocks. Never raises on received data.

    Args:
        channels: objects of a record in their order, of four bytes each.
        stride: ticks between two records.
        tick_s: the drive's control period.
        format: a `StreamFormat`.
        scales: of format INT16 the object's unit per bit of each channel, else empty.
        schema: number that the drive gave the configuration.
        near: a tick of the drive at about this time, counted on, which the ticks of the records follow.

    Raises:
        ValueRefused: these cannot be the channels or scales of a stream.
    """

    def __init__(
        self,
        channels: Sequence[Variable],
        stride: int,
        tick_s: float,
        format: int,
        scales: Sequence[float],
        schema: int,
        near: int | None = None,
    ) -> None:
        words = format == StreamFormat.WORDS
        if not channels or any(
            each.type not in (DataType.F32, DataType.U32, DataType.I32) for each in channels
        ):
            shown = ", ".join(f"{each.name} ({each.type})" for each in channels)
            raise ValueRefused(
                f"channels of a stream are [{shown}], one or more of f32, u32, i32 are expected: choose such"
            )
        if len(scales) != (0 if words else len(channels)):
            raise ValueRefused(
                f"{len(scales)} scales for {len(channels)} channels of format {format}: "
                f"give one for each of format 1, none of format 0"
            )
        self.arrival_s = 0.0
        """Arrival of the last batch received."""
        self.tick = 0
        """Tick of its last record, counted on past 2**32."""
        self.other_schema = 0
        """Batches of another schema, which were ignored."""
        self._stride, self._tick_s, self._schema = stride, tick_s, schema
        self._channels = tuple(Channel(each.name, each.unit) for each in channels)
        self._types = [np.dtype(each.type.numpy) for each in channels]
        steps = np.ones(len(channels)) if words else np.array(scales, dtype=np.float32).astype(np.float64)
        self._factors = steps * np.array([each.factor for each in channels])
        self._words = words
        self._record_bytes = (4 if words else 2) * len(channels)
        self._near = near
        self._sequence = 0
        self._batches: list[bytes] = []
        self._spans: list[tuple[int, int]] = []  # first tick and number of rows of each batch
        self._rows = 0
        self._received = self._missing = self._lost = self._off_grid = self._malformed = 0

    @property
    def counters(self) -> StreamCounters:
        """Snapshot, in records, but for `malformed`, which counts batches.

        Records between two batches whose sequence numbers do not follow each other are both missing and lost.
        """
        return StreamCounters(
            received=self._received,
            missing=self._missing,
            lost=self._lost,
            off_grid=self._off_grid,
            malformed=self._malformed,
        )

    @property
    def rows(self) -> int:
        """Rows that wait to be taken."""
        return self._rows

    def feed(self, batch: Batch, arrival_s: float) -> int:
        """Add a batch; return the number of rows accepted."""
        if batch.schema != self._schema:
            self.other_schema += 1
            return 0
        if (
            batch.n <= 0
            or len(batch.data) != batch.n * self._record_bytes
            or batch.stride != self._stride
            or not self._stride
        ):
            self._malformed += 1
            return 0
        first_tick = unwrap_tick(batch.first_tick, self._near)
        if self._received:
            ticks_ahead = ticks_since(batch.first_tick, self.tick)
            batches_ahead = ticks_since(batch.sequence, self._sequence)
            records_ahead, rest = divmod(ticks_ahead, self._stride)
            # Every batch between, and this one, has at least one of the records between.
            if rest or ticks_ahead >= TICKS // 2 or not 0 < batches_ahead <= records_ahead:
                self._off_grid += batch.n
                return 0
            self._missing += records_ahead - 1
            if batches_ahead > 1:
                self._lost += records_ahead - 1
            first_tick = self.tick + ticks_ahead
        self._sequence = batch.sequence
        self.tick = first_tick + (batch.n - 1) * self._stride
        self.arrival_s = arrival_s
        self._received += batch.n
        self._rows += batch.n
        self._batches.append(batch.data)
        self._spans.append((first_tick, batch.n))
        return batch.n

    def pop_block(self) -> Block | None:
        """Return the rows since the last call and clear them; None if there are none."""
        if not self._rows:
            return None
        data = self._values(b"".join(self._batches))
        gaps, row = [], 0
        for (before, n), (tick, _) in pairwise(self._spans):
            row += n
            missing = (tick - before) // self._stride - n
            if missing:
                gaps.append(Gap(row, missing))
        first_tick = self._spans[0][0]
        self._batches, self._spans, self._rows = [], [], 0
        return Block(self._channels, first_tick, self._stride, self._tick_s, data, tuple(gaps))

    def _values(self, records: bytes) -> NDArray[np.float64]:
        """Return the values in the units of the channels, shape (rows, channels)."""
        shape = -1, len(self._channels)
        if self._words:
            words = np.frombuffer(records, dtype="<u4").reshape(shape)
            data = np.empty(words.shape)
            for kind in set(self._types):
                columns = [number for number, each in enumerate(self._types) if each == kind]
                # A whole matrix of one type is converted in one go, several times faster than by columns.
                if len(columns) == len(self._types):
                    data[:] = words.view(kind)
                else:
                    data[:, columns] = words.view(kind)[:, columns]
        else:
            steps = np.frombuffer(records, dtype="<i2").reshape(shape)
            data = steps.astype(np.float64)
            data[steps == _NO_VALUE] = np.nan
        if np.any(self._factors != 1.0):
            data *= self._factors
        return data
