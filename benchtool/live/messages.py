"""Conversion of Blocks to messages of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from benchtool.block import Block, Channel
from benchtool.live import names


@dataclass(frozen=True)
class Columns:
    """Rows of one entity, ready for any number of recordings."""

    entity: str
    indexes: tuple[rr.TimeColumn, ...]
    columns: tuple[rr.ComponentColumn, ...]

    def send(self, stream: rr.RecordingStream) -> None:
        """Send all rows into one recording."""
        stream.send_columns(self.entity, self.indexes, self.columns, strict=True)


@dataclass(frozen=True)
class StaticContent:
    """Static content, valid at every time, such as the names of series; a later one replaces it."""

    entity: str
    content: rr.AsComponents

    @property
    def place(self) -> str:
        """Key by which a later message replaces this one."""
        return f"{self.entity}:{type(self.content).__name__}"

    def send(self, stream: rr.RecordingStream) -> None:
        """Send it into one recording."""
        stream.log(self.entity, self.content, static=True, strict=True)


@dataclass(frozen=True)
class LayoutMessage:
    """The layout of the viewer from now on."""

    blueprint: rrb.Blueprint

    @property
    def place(self) -> str:
        """There is one layout at a time."""
        return ""

    def send(self, stream: rr.RecordingStream) -> None:
        """Send it into one recording."""
        stream.send_blueprint(self.blueprint)


Message = Columns | StaticContent | LayoutMessage


@dataclass(frozen=True)
class TimeAxis:
    """The three timelines of a tick; see `names` for what they mean.

    `wall_s` is the wall time, in seconds since 1970, of `first_tick`.
    """

    tick_s: float
    first_tick: int
    wall_s: float

    def indexes(self, ticks: NDArray[np.int64], tick_s: float | None = None) -> tuple[rr.TimeColumn, ...]:
        """Return the time columns of ticks, shape (n,); times are whole nanoseconds.

        `tick_s` is for what counts faster than the drive from the same moment: several of its rows are then
        of one drive tick.
        """
        drive_ns = np.rint(ticks * ((tick_s or self.tick_s) * 1e9))
        own = ticks if tick_s in (None, self.tick_s) else self.of(drive_ns * 1e-9)
        drive_ns = drive_ns.astype("timedelta64[ns]")
        wall = np.datetime64(round((self.wall_s - self.first_tick * self.tick_s) * 1e9), "ns") + drive_ns
        return (
            rr.TimeColumn(names.TICK, sequence=own),
            rr.TimeColumn(names.DRIVE_TIME, duration=drive_ns),
            rr.TimeColumn(names.WALL_TIME, timestamp=wall),
        )

    def of(self, drive_s: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the ticks that moments of drive time fall into."""
        return np.floor(drive_s / self.tick_s + 1e-6).astype(np.int64)

    def ticks(self, block: Block) -> NDArray[np.int64]:
        """Drive ticks of a block's rows, shape (rows,)."""
        ticks = block.ticks()
        return ticks if block.tick_s == self.tick_s else self.of(np.asarray(ticks * block.tick_s, np.float64))

    def tick(self, block: Block, row: int) -> int:
        """Drive tick of one row of a block."""
        return int(self.ticks(block)[row])


def scalars(
    entity: str,
    axis: TimeAxis,
    ticks: NDArray[np.int64],
    values: NDArray[np.float64],
    tick_s: float | None = None,
) -> Columns:
    """Return the values of shape (n, series) at ticks of shape (n,); `tick_s` as of `TimeAxis.indexes`."""
    widths = np.full(len(values), values.shape[1])
    batch = rr.Scalars.columns(scalars=np.ascontiguousarray(values).ravel()).partition(widths)
    return Columns(entity, axis.indexes(ticks, tick_s), tuple(batch))


def block_columns(block: Block, axis: TimeAxis, source: str, next_tick: int | None = None) -> list[Columns]:
    """Return every sample of a Block, one message for each quantity.

    Where rows are missing, within the block or since `next_tick`, a row of nan at the first tick that is
    missing breaks the line: a plot would otherwise draw a straight line over the gap.
    """
    ticks, data = block.ticks(), block.data
    rows = [gap.row for gap in block.gaps]
    missing = [ticks[gap.row] - gap.missing_rows * block.stride for gap in block.gaps]
    if next_tick is not None and len(ticks) and ticks[0] > next_tick:
        rows.insert(0, 0)
        missing.insert(0, np.int64(next_tick))
    if rows:
        ticks = np.insert(ticks, rows, missing)
        data = np.insert(data, rows, np.nan, axis=0)
    return [
        scalars(f"{source}/{name}", axis, ticks, data[:, list(columns)], block.tick_s)
        for name, columns in names.columns_by_quantity(block.channels).items()
    ]


def parts(block: Block, rows: int) -> list[Block]:
    """Return a block cut into blocks of so many rows, each with its own gaps; a gap at a cut stays between
    two."""
    ticks = block.ticks()
    cut = []
    for begin in range(0, len(block.data), rows):
        end = min(begin + rows, len(block.data))
        gaps = tuple(replace(gap, row=gap.row - begin) for gap in block.gaps if begin < gap.row < end)
        cut.append(replace(block, first_tick=int(ticks[begin]), data=block.data[begin:end], gaps=gaps))
    return cut


def series(channels: tuple[Channel, ...], source: str) -> list[StaticContent]:
    """Return the names with units and colours of a Block's series.

    Where a plot has less pixels than samples, the viewer draws their minimum and maximum; every sample is in
    the recording.
    """
    width = 1.5 if source == names.STREAM else 1.0
    return [
        StaticContent(
            f"{source}/{name}",
            rr.SeriesLines(
                names=[names.label(channels[column], source) for column in columns],
                colors=[
                    names.colour(channels[column], place, source) for place, column in enumerate(columns)
                ],
                widths=[width] * len(columns),
                aggregation_policy=rr.components.AggregationPolicy.MinMax,
            ),
        )
        for name, columns in names.columns_by_quantity(channels).items()
    ]


def lines(entity: str, styles: Mapping[str, tuple[names.Colour, float]]) -> StaticContent:
    """Names, colours and widths of series that are not channels."""
    return StaticContent(
        entity,
        rr.SeriesLines(
            names=list(styles),
            colors=[colour for colour, _ in styles.values()],
            widths=[width for _, width in styles.values()],
        ),
    )


def at(entity: str, axis: TimeAxis, tick: int, columns: Any) -> Columns:
    """Return one row of any archetype, `columns` being what its `columns` method gave."""
    return Columns(entity, axis.indexes(np.array([tick], dtype=np.int64)), tuple(columns))
