"""One stream of a bundle: an Arrow IPC stream while it is recorded, Parquet afterwards."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pyarrow as pa
from pyarrow import parquet

from benchtool.block import (
    Block,
    Gap,
    TimeBase,
    batch_of,
    block_of,
    gaps_from_text,
    gaps_to_text,
    number_array,
    recorded_fields,
    schema_of,
    times_s,
    with_time,
)
from benchtool.errors import RecordingError
from benchtool.recording.checkpoints import Checkpoints, HashedFile
from benchtool.recording.failures import reading, writing
from benchtool.recording.files import flush_to_disk
from benchtool.recording.seal import FileHash

DATA = "data"
RUNNING, FINISHED = ".arrows", ".parquet"
"""Folder of the streams in a bundle, and what ends the names of their files."""

_ROW_GROUP = 1 << 16


class StreamWriter:
    """Appends blocks to `path`; each is with the operating system when `append` returns.

    Gaps travel in the custom metadata of their batch, because later batches may never be written. Each batch
    is noted in `checkpoints` before `append` returns.
    """

    def __init__(self, path: Path, first: Block, checkpoints: Checkpoints) -> None:
        self.path = path
        self._checkpoints = checkpoints
        self.rows = 0
        self.gaps: list[Gap] = []
        self._channels = first.channels
        self._time_base = TimeBase.of(first)
        self._schema = schema_of(first.channels, self._time_base)
        self._broken = False
        with writing(path):
            self._file = HashedFile(path)
            self._stream = pa.ipc.new_stream(self._file, self._schema)

    @property
    def missing_rows(self) -> int:
        return sum(gap.missing_rows for gap in self.gaps)

    def append(self, block: Block) -> None:
        """Add the rows of a block; ticks missing since the previous one become a gap.

        Raises:
            RecordingError: it cannot be written, or does not continue this stream.
        """
        self._require_sound()
        gaps = self._gaps_of(block)
        self._broken = True
        with writing(self.path):
            self._stream.write_batch(
                batch_of(block, self._schema), custom_metadata={"gaps": gaps_to_text(gaps)}
            )
            self._file.flush()
        self._checkpoints.note(self.path, self._file.state)
        self._broken = False
        self.rows += len(block.data)
        self.gaps += gaps

    def _require_sound(self) -> None:
        if self._broken:
            raise RecordingError(
                f"{self.path} ends in a write that failed, a whole stream is needed: what came before "
                f"is readable, record again for the rest"
            )

    def _gaps_of(self, block: Block) -> list[Gap]:
        base = self._time_base
        if (block.channels, block.stride, block.tick_s) != (self._channels, base.stride, base.tick_s):
            raise RecordingError(
                f"a block of {', '.join(block.names)}, every {block.stride} ticks of {block.tick_s:g} s, "
                f"does not continue {self.path.name}, which has other channels or another rate: record it as "
                f"another stream"
            )
        expected = base.first_tick + (self.rows + self.missing_rows) * base.stride
        missing, remainder = divmod(int(block.first_tick) - expected, base.stride)
        if missing < 0 or remainder:
            raise RecordingError(
                f"a block from tick {block.first_tick} does not continue {self.path.name}, where tick "
                f"{expected} or whole strides of {base.stride} later are next: check the order of the blocks"
            )
        before = [Gap(self.rows, missing)] if missing else []
        return before + [Gap(self.rows + gap.row, gap.missing_rows) for gap in block.gaps]

    def close(self) -> None:
        """Release the file; a stream that failed stays as it is, as its failure was already reported."""
        if self._broken:
            with suppress(OSError):
                self._file.close()
            return
        with writing(self.path), self._file:
            self._stream.close()

    def convert(self, target: Path) -> FileHash:
        """Write the closed stream as Parquet to `target` and remove it; return the file's hash.

        Row groups have a fixed size, so that the bytes do not depend on how the rows arrived.

        Raises:
            RecordingError: the Parquet file cannot be written, or the stream failed; it is kept.
        """
        self._require_sound()
        schema = with_time(schema_of(self._channels, self._time_base, self.gaps))
        part = target.with_name(target.name + ".part")
        with reading(self.path), pa.memory_map(str(self.path)) as source:
            stream = pa.ipc.open_stream(source)
            with (
                writing(target),
                HashedFile(part) as hashed,
                parquet.ParquetWriter(
                    hashed, schema, compression="zstd", use_dictionary=False, use_byte_stream_split=True
                ) as file,
            ):
                first = 0
                for group in _regroup(stream):
                    file.write_table(self._timed(group, first, schema), row_group_size=_ROW_GROUP)
                    first += len(group)
        self._checkpoints.note(target, hashed.state)
        with writing(target):
            flush_to_disk(part)
            part.replace(target)
            self.path.unlink()
        return hashed.state

    def _timed(self, group: pa.Table, first: int, schema: pa.Schema) -> pa.Table:
        """Return rows from `first` on with their time before them, where the schema has one of its own."""
        columns = group.columns
        if len(schema) > len(columns):
            columns = [number_array(times_s(self._time_base, self.gaps, first, len(group))), *columns]
        return pa.Table.from_arrays(columns, schema=schema)


def _regroup(batches: Iterator[pa.RecordBatch]) -> Iterator[pa.Table]:
    """Yield the same rows as tables of `_ROW_GROUP` rows; the last one may be shorter."""
    waiting: list[pa.RecordBatch] = []
    rows = 0
    for batch in batches:
        waiting.append(batch)
        rows += len(batch)
        while rows >= _ROW_GROUP:
            table = pa.Table.from_batches(waiting)
            yield table.slice(0, _ROW_GROUP).combine_chunks()
            waiting = table.slice(_ROW_GROUP).to_batches()
            rows -= _ROW_GROUP
    if rows:
        yield pa.Table.from_batches(waiting).combine_chunks()


def read_stream(path: Path, size_B: int | None = None) -> Block:
    """Return the block of a stream that was never converted; a batch that was only half written is left out.

    Args:
        path: of the stream.
        size_B: how much of the file is known to be whole; without, all of it is read.

    Raises:
        RecordingError: it cannot be read, or holds no complete batch.
    """
    batches: list[pa.RecordBatch] = []
    gaps: list[Gap] = []
    with reading(path), pa.memory_map(str(path)) as source:
        stream = pa.ipc.open_stream(source if size_B is None else pa.BufferReader(source.read_buffer(size_B)))
        while True:
            try:
                batch, metadata = stream.read_next_batch_with_custom_metadata()
                gaps += gaps_from_text(metadata[b"gaps"])
            except (StopIteration, OSError, KeyError, TypeError, ValueError):
                break  # the end, or a batch that was being written when the process ended
            batches.append(batch)
        rows = sum(len(batch) for batch in batches)
        return block_of(stream.schema, batches, rows, _time_base(path, stream.schema), gaps)


def read_parquet(path: Path) -> Block:
    """Return the block of a finished stream.

    Raises:
        RecordingError: it cannot be read or was not written here.
    """
    with reading(path), path.open("rb") as raw, parquet.ParquetFile(raw) as file:
        schema = file.schema_arrow
        time_base = _time_base(path, schema)
        gaps = gaps_from_text(schema.metadata.get(b"gaps", b"[]"))
        names = [field.name for field in recorded_fields(schema)]
        batches = file.iter_batches(_ROW_GROUP, columns=names)
        return block_of(schema, batches, file.metadata.num_rows, time_base, gaps)


def _time_base(path: Path, schema: pa.Schema) -> TimeBase:
    try:
        return TimeBase.from_metadata(schema.metadata or {})
    except (KeyError, ValueError):
        raise RecordingError(
            f"{path} has no time base (first_tick, stride, tick_s), so its rows have no time: give a "
            f"file that benchtool recorded"
        ) from None
