"""A recording read back with Rerun's own reader."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from rerun.chunk import RrdReader

from benchtool.block import Block
from benchtool.live import names


@dataclass(frozen=True)
class Recording:
    """Rows by entity, in the order of their ticks; what holds always is under `still`."""

    rows: dict[str, pa.Table]
    still: dict[str, dict[str, Any]]

    @classmethod
    def read(cls, path: Path) -> Recording:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "RRD file has no footer")
            reader = RrdReader(path)
            (store,) = reader.recordings()
        parts: dict[str, list[pa.RecordBatch]] = {}
        still: dict[str, dict[str, Any]] = {}
        for chunk in reader.stream(store=store):
            batch = chunk.to_record_batch()
            if chunk.is_static:
                still.setdefault(chunk.entity_path, {}).update(
                    {name: batch.column(name)[-1].as_py() for name in batch.schema.names[1:]}
                )
            else:
                parts.setdefault(chunk.entity_path, []).append(batch)
        rows = {}
        for entity, batches in parts.items():
            plain = [pa.Table.from_batches([b.replace_schema_metadata(None)]) for b in batches]
            rows[entity] = pa.concat_tables(plain, promote_options="default")
        return cls(rows, still)

    def ticks(self, entity: str) -> NDArray[np.int64]:
        return np.asarray(self.rows[entity].column(names.TICK).to_numpy(), dtype=np.int64)

    def nanoseconds(self, entity: str, timeline: str) -> NDArray[np.int64]:
        return np.asarray(self.rows[entity].column(timeline).cast(pa.int64()).to_numpy(), dtype=np.int64)

    def values(self, entity: str) -> NDArray[np.float64]:
        """Scalars of shape (rows, series)."""
        column = self.rows[entity].column("Scalars:scalars").to_pylist()
        return np.array(column, dtype=np.float64)

    def texts(self, entity: str) -> list[str]:
        """Lines of a log."""
        return [text[0] for text in self.rows[entity].column("TextLog:text").to_pylist()]

    def series(self, entity: str) -> list[str]:
        """Names of an entity's series."""
        found: list[str] = self.still[entity]["SeriesLines:names"]
        return found


def assert_holds(recording: Recording, block: Block, source: str) -> None:
    """Every sample of a block is in the recording, exactly, under its name, unit and tick; and no other."""
    groups = names.columns_by_quantity(block.channels)
    held = {entity for entity in recording.rows if entity.startswith(f"{source}/")}
    assert held == {f"{source}/{quantity}" for quantity in groups}
    for quantity, columns in groups.items():
        entity = f"{source}/{quantity}"
        expected = [
            f"{block.channels[k].name}" + (f" ({block.channels[k].unit})" if block.channels[k].unit else "")
            for k in columns
        ]
        assert [name.removesuffix(", capture") for name in recording.series(entity)] == expected
        values, ticks = recording.values(entity), recording.ticks(entity)
        there = ~np.isnan(values).all(axis=1)
        assert np.count_nonzero(~there) <= len(block.gaps)
        assert np.array_equal(values[there], block.data[:, list(columns)])
        drive_ns = np.rint(block.ticks() * block.tick_s * 1e9)
        # half a nanosecond of rounding, either way
        assert np.abs(recording.nanoseconds(entity, names.DRIVE_TIME)[there] - drive_ns).max() <= 1.0
        if source != names.TRANSDUCER:
            assert np.array_equal(ticks[there], block.ticks())
