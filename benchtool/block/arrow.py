"""A Block as Arrow columns: units in the fields, the time base in the schema, no timestamp of the recording.

A finished file has a column `time_s` besides, for programs that do not read the time base: seconds since the
first row, by the ticks. Its field says that it is derived, and reading a block leaves it out.
The same samples give the same bytes, so that two recordings can be compared with `cmp`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from benchtool.block.block import Block, Channel, Gap

TIME: Final = "time_s"
_DERIVED: Final = b"derived_from"


@dataclass(frozen=True)
class TimeBase:
    """Time base of rows: see `Block`."""

    first_tick: int
    stride: int
    tick_s: float
    alignment_s: float = 0.0

    @classmethod
    def of(cls, block: Block) -> TimeBase:
        return cls(int(block.first_tick), int(block.stride), float(block.tick_s), float(block.alignment_s))

    def to_metadata(self) -> dict[str, str]:
        # repr of a float reads back as the same float
        told = {"first_tick": str(self.first_tick), "stride": str(self.stride), "tick_s": repr(self.tick_s)}
        return told | ({"alignment_s": repr(self.alignment_s)} if self.alignment_s else {})

    @classmethod
    def from_metadata(cls, metadata: Mapping[bytes, bytes]) -> TimeBase:
        """Raises ValueError or KeyError where the metadata are not those of `to_metadata`."""
        alignment_s = float(metadata.get(b"alignment_s", 0.0))
        return cls(
            int(metadata[b"first_tick"]), int(metadata[b"stride"]), float(metadata[b"tick_s"]), alignment_s
        )


def schema_of(
    channels: Sequence[Channel], time_base: TimeBase, gaps: Sequence[Gap] | None = None
) -> pa.Schema:
    """Return the columns of 64-bit floats named as the channels; `gaps` where they are known already."""
    fields = [
        pa.field(each.name, pa.float64(), nullable=False, metadata={"unit": each.unit}) for each in channels
    ]
    metadata = time_base.to_metadata()
    if gaps is not None:
        metadata["gaps"] = gaps_to_text(gaps)
    return pa.schema(fields, metadata=metadata)


def with_time(schema: pa.Schema) -> pa.Schema:
    """Return the schema with the column of the time before the others; as it is if a channel is called so."""
    if TIME in schema.names:
        return schema
    metadata = {"unit": "s", _DERIVED.decode(): "tick"}
    return schema.insert(0, pa.field(TIME, pa.float64(), nullable=False, metadata=metadata))


def recorded_fields(schema: pa.Schema) -> tuple[pa.Field, ...]:
    """Return the fields of the channels, without a time that is derived."""
    return tuple(field for field in schema if _DERIVED not in (field.metadata or {}))


def times_s(time_base: TimeBase, gaps: Sequence[Gap], first: int, count: int) -> NDArray[np.float64]:
    """Return the time of rows `first` to before `first + count` since the first row of all: that of
    `Block.time_s`."""
    rows = np.arange(first, first + count, dtype=np.int64)
    missing = np.cumsum([0, *(gap.missing_rows for gap in gaps)])
    rows += missing[np.searchsorted([gap.row for gap in gaps], rows, side="right")]
    return np.multiply(rows * time_base.stride, time_base.tick_s, dtype=np.float64)


def channels_of(schema: pa.Schema) -> tuple[Channel, ...]:
    """Return the channels of a schema that `schema_of` made, with a time or without."""
    return tuple(
        Channel(field.name, (field.metadata or {}).get(b"unit", b"").decode())
        for field in recorded_fields(schema)
    )


def batch_of(block: Block, schema: pa.Schema) -> pa.RecordBatch:
    """Return the rows of a block as one batch."""
    columns = [number_array(column) for column in block.data.T]
    return pa.RecordBatch.from_arrays(columns, schema=schema)


def number_array(values: NDArray[np.float64] | NDArray[np.int64]) -> pa.Array:
    """Return numbers as an array of Arrow, without a copy where they lie side by side.

    `pyarrow.array` imports pandas first, where that is installed: half a second of a command.
    """
    buffer = pa.py_buffer(np.ascontiguousarray(values))
    return pa.Array.from_buffers(pa.from_numpy_dtype(values.dtype), len(values), [None, buffer])


def timed_batch_of(block: Block) -> pa.RecordBatch:
    """Return the rows of a block as one batch, with their time since the first in a column `time_s` ahead."""
    schema = schema_of(block.channels, TimeBase.of(block), block.gaps)
    timed = with_time(schema)
    columns = batch_of(block, schema).columns
    if timed is not schema:
        columns = [number_array(block.time_s()), *columns]
    return pa.RecordBatch.from_arrays(columns, schema=timed)


def _numbers(column: pa.Array) -> NDArray[Any]:
    """Return the numbers of a column; `to_numpy` imports pandas first, as `pyarrow.array` does."""
    if column.null_count or not pa.types.is_floating(column.type):
        return np.asarray(column.to_numpy(zero_copy_only=False))
    return np.from_dlpack(column)


def block_of(
    schema: pa.Schema, batches: Iterable[pa.RecordBatch], rows: int, time_base: TimeBase, gaps: Sequence[Gap]
) -> Block:
    """Return the block of batches that hold `rows` rows together; each channel's samples lie side by side."""
    data = np.empty((rows, len(recorded_fields(schema))), order="F")
    row = 0
    for batch in batches:
        for number, column in enumerate(batch.columns):
            data[row : row + len(batch), number] = _numbers(column)
        row += len(batch)
    return Block(
        channels_of(schema),
        time_base.first_tick,
        time_base.stride,
        time_base.tick_s,
        data,
        tuple(gaps),
        time_base.alignment_s,
    )


def gaps_to_text(gaps: Sequence[Gap]) -> str:
    return json.dumps([[gap.row, gap.missing_rows] for gap in gaps])


def gaps_from_text(text: bytes) -> tuple[Gap, ...]:
    """Raises ValueError or TypeError where the text is not that of `gaps_to_text`."""
    return tuple(Gap(int(row), int(missing)) for row, missing in json.loads(text))
