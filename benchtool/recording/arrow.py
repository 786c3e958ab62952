"""A Block as Arrow columns: units in the fields, the time base in the schema, nothing that names the moment.

The same samples give the same bytes, so that two recordings can be compared with `cmp`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from benchtool.block import Block, Channel, Gap


@dataclass(frozen=True)
class TimeBase:
    """What turns a row number into time: see `Block`."""

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
    """Columns of 64-bit floats named as the channels; `gaps` where they are known already."""
    fields = [
        pa.field(each.name, pa.float64(), nullable=False, metadata={"unit": each.unit}) for each in channels
    ]
    metadata = time_base.to_metadata()
    if gaps is not None:
        metadata["gaps"] = gaps_to_text(gaps)
    return pa.schema(fields, metadata=metadata)


def channels_of(schema: pa.Schema) -> tuple[Channel, ...]:
    """Channels of a schema that `schema_of` made."""
    return tuple(Channel(field.name, (field.metadata or {}).get(b"unit", b"").decode()) for field in schema)


def batch_of(block: Block, schema: pa.Schema) -> pa.RecordBatch:
    """Rows of a block as one batch."""
    columns = [pa.array(np.ascontiguousarray(column)) for column in block.data.T]
    return pa.RecordBatch.from_arrays(columns, schema=schema)


def block_of(
    schema: pa.Schema, batches: Iterable[pa.RecordBatch], rows: int, time_base: TimeBase, gaps: Sequence[Gap]
) -> Block:
    """The block of batches that hold `rows` rows together; each channel's samples lie side by side."""
    data = np.empty((rows, len(schema)), order="F")
    row = 0
    for batch in batches:
        for number, column in enumerate(batch.columns):
            data[row : row + len(batch), number] = column.to_numpy(zero_copy_only=False)
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
