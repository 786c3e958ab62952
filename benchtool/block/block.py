"""The Block itself: columns, time base and gaps; cropped, joined, and as pandas, Arrow or a picture."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchtool.errors import AnalysisError, UsageError
from benchtool.notebook import table_html

if TYPE_CHECKING:
    import pandas as pd
    import pyarrow as pa
    from matplotlib.figure import Figure

    from benchtool.block.plot import Plot


def as_samples(values: ArrayLike, name: str = "signal") -> NDArray[np.float64]:
    """Return one signal as samples, shape (n,), float64; not copied where it is that already.

    Raises:
        AnalysisError: not real numbers, or of another shape.
    """
    try:
        found = np.asarray(values)
        samples = None if np.iscomplexobj(found) else found.astype(np.float64, copy=False)
    except (TypeError, ValueError):
        samples = None
    if samples is None:
        raise AnalysisError(f"'{name}' holds what is no real number, one signal is needed: pass its samples")
    if samples.ndim != 1:
        raise AnalysisError(
            f"'{name}' has the shape {samples.shape}, samples of shape (n,) are needed: pass one column, "
            f"such as array[:, 0]"
        )
    return samples


def require_rate(sample_rate_Hz: float) -> None:
    """Refuse a sample rate that is not positive and finite.

    Raises:
        AnalysisError: not positive, or not finite.
    """
    if not (sample_rate_Hz > 0.0 and math.isfinite(sample_rate_Hz)):
        raise AnalysisError(
            f"the sample rate is {sample_rate_Hz:g} Hz, a positive one is needed: state rows per second"
        )


def read_only(array: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return a view that cannot be written to."""
    view = array.view()
    view.flags.writeable = False
    return view


@dataclass(frozen=True)
class Channel:
    """One column: its name as in the dictionary and its unit (empty for counts and flags)."""

    name: str
    unit: str


@dataclass(frozen=True)
class Gap:
    """Rows that were lost: `missing_rows` of them would stand before row `row`."""

    row: int
    missing_rows: int


@dataclass(frozen=True, repr=False)
class Block:
    """Uniformly clocked samples of several channels.

    `data` has shape (n, channels). Row k was taken at drive tick `first_tick + k * stride` plus the rows that
    `gaps` counts before it; a tick lasts `tick_s` seconds of the source's own clock, which gives the time
    axis. Rows that another clock than the drive's has stamped are at their drive ticks within the standard
    uncertainty `alignment_s`; 0 of rows that the drive itself counted.
    """

    channels: tuple[Channel, ...]
    first_tick: int
    stride: int
    tick_s: float
    data: NDArray[np.float64]
    gaps: tuple[Gap, ...] = field(default=())
    alignment_s: float = 0.0

    def __post_init__(self) -> None:
        if self.data.ndim != 2 or self.data.shape[1] != len(self.channels):
            raise ValueError(f"data of shape {self.data.shape} for {len(self.channels)} channels")

    @classmethod
    def from_arrays(cls, rate_Hz: float, units: Mapping[str, str], /, **channels: ArrayLike) -> Self:
        """Return a block of channels sampled together at `rate_Hz`, without gaps, each of shape (n,).

        `units` are theirs, such as {"i_a": "A", "torque": "Nm"}; what is not in it (counts, flags) has none.
        The data are copied and cannot be written to.

        Raises:
            AnalysisError: no channel, arrays of several lengths or other shapes, the unit of none of them, or
                a rate that is not positive.
        """
        require_rate(rate_Hz)
        columns = {name: as_samples(values, name) for name, values in channels.items()}
        if unknown := [name for name in units if name not in columns]:
            raise AnalysisError(
                f"a unit is stated for '{unknown[0]}', which is no channel: the channels are "
                f"{', '.join(columns) or 'none'}, pass that one or leave out its unit"
            )
        lengths = {name: len(column) for name, column in columns.items()}
        if len(set(lengths.values())) != 1:
            seen = ", ".join(f"'{name}' has {rows} rows" for name, rows in lengths.items())
            raise AnalysisError(
                f"{seen or 'no channel was passed'}, as many of each and one channel at least are needed: "
                f"pass what was sampled together"
            )
        data = np.column_stack(list(columns.values()))
        data.flags.writeable = False
        named = tuple(Channel(name, units.get(name, "")) for name in columns)
        return cls(named, 0, 1, 1.0 / rate_Hz, data)

    @classmethod
    def joined(cls, blocks: Sequence[Block]) -> Self:
        """Join blocks of one source into one; ticks that are missing between them become a gap.

        Raises:
            AnalysisError: there is none, their channels or rates differ, or one begins before its
                predecessor ends.
        """
        if not blocks:
            raise AnalysisError("no block to join, one at least is needed: record something first")
        first, gaps, rows, next_tick = blocks[0], [], 0, blocks[0].first_tick
        for block in blocks:
            if (block.channels, block.stride, block.tick_s) != (first.channels, first.stride, first.tick_s):
                raise AnalysisError(
                    f"blocks of {', '.join(first.names)} at {first.sample_rate_Hz:g} Hz and of "
                    f"{', '.join(block.names)} at {block.sample_rate_Hz:g} Hz, the same of each are needed: "
                    f"join those of one recording"
                )
            missing, remainder = divmod(block.first_tick - next_tick, first.stride)
            if missing < 0 or remainder:
                raise AnalysisError(
                    f"a block begins at tick {block.first_tick}, tick {next_tick} or a whole number of rows "
                    f"later is needed: join blocks of one recording, in their order"
                )
            gaps += [Gap(rows, missing)] if missing else []
            gaps += [Gap(rows + gap.row, gap.missing_rows) for gap in block.gaps]
            rows += len(block.data)
            if len(block.data):
                next_tick = int(block.ticks()[-1]) + block.stride
        data = np.concatenate([block.data for block in blocks])
        alignment_s = max(block.alignment_s for block in blocks)
        tick = first.first_tick
        return cls(first.channels, tick, first.stride, first.tick_s, data, tuple(gaps), alignment_s)

    def __repr__(self) -> str:
        channels = ", ".join(f"{each.name} [{each.unit or '–'}]" for each in self.channels)
        return f"<{type(self).__name__}: {self._extent}: {channels}>"

    def _repr_html_(self) -> str:
        """Show the channels with unit, mean, least and greatest value, for a notebook."""
        rows: list[tuple[str, ...]] = []
        for channel, column in zip(self.channels, self.data.T, strict=True):
            found = column[np.isfinite(column)]
            numbers = (found.mean(), found.min(), found.max()) if len(found) else (math.nan,) * 3
            rows.append((channel.name, *(f"{value:.5g}" for value in numbers), channel.unit))
        return table_html(("channel", ">mean", ">min", ">max", "unit"), rows, self._extent)

    @property
    def _extent(self) -> str:
        lost = sum(gap.missing_rows for gap in self.gaps)
        gaps = f", {lost} rows missing in {len(self.gaps)} gaps" if lost else ""
        return f"{len(self.data)} rows at {self.sample_rate_Hz:g} Hz, {self.duration_s:g} s{gaps}"

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(channel.name for channel in self.channels)

    @property
    def columns(self) -> Mapping[str, NDArray[np.float64]]:
        """Samples by channel, each of shape (n,), not copied; as `xarray.Dataset` and the like take them."""
        return dict(zip(self.names, self.data.T, strict=True))

    @property
    def sample_rate_Hz(self) -> float:
        return 1.0 / (self.stride * self.tick_s)

    @property
    def duration_s(self) -> float:
        """Time of all rows, those missing in gaps among them."""
        rows = len(self.data) + sum(gap.missing_rows for gap in self.gaps)
        return rows * self.stride * self.tick_s

    def column(self, name: str) -> NDArray[np.float64]:
        """Return the samples of one channel, shape (n,).

        Raises:
            AnalysisError: the block has no such channel.
        """
        try:
            return self.data[:, self.names.index(name)]
        except ValueError:
            raise AnalysisError(
                f"no channel '{name}' in this recording; it has {', '.join(self.names)}: "
                f"record '{name}' or choose one of these"
            ) from None

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        """As `column`."""
        return self.column(name)

    def unit(self, name: str) -> str:
        """Return the unit of one channel."""
        return self.channels[self.names.index(name)].unit

    def ticks(self) -> NDArray[np.int64]:
        """Drive tick of every row, shape (n,), with the gaps in it."""
        rows = np.arange(len(self.data), dtype=np.int64)
        for gap in self.gaps:
            rows[gap.row :] += gap.missing_rows
        return self.first_tick + rows * self.stride

    def time_s(self) -> NDArray[np.float64]:
        """Return the time of every row since the first, shape (n,)."""
        return np.multiply(self.ticks() - self.first_tick, self.tick_s, dtype=np.float64)

    def crop(self, begin_s: float | None = None, end_s: float | None = None) -> Self:
        """Return the rows from `begin_s` to before `end_s`, in seconds since the first, at their own ticks.

        The samples are not copied; `time_s` of the returned block begins at 0 again.

        Args:
            begin_s: None takes the rows from the first one on.
            end_s: None takes them to the last one.

        Raises:
            AnalysisError: the ends are in the wrong order or no numbers, or no row lies between them.
        """
        if begin_s is None and end_s is None:
            return self
        first_s, last_s = -math.inf if begin_s is None else begin_s, math.inf if end_s is None else end_s
        if not first_s < last_s:
            raise AnalysisError(
                f"a window from {first_s:g} s to {last_s:g} s has no length: give the earlier end first"
            )
        # Ticks are integers: a small share of a step takes up the rounding of seconds.
        rounding_s = 1e-6 * self.stride * self.tick_s
        first, last = np.searchsorted(self.time_s(), (first_s - rounding_s, last_s - rounding_s)).tolist()
        if first == last:
            begin = "" if begin_s is None else f" from {begin_s:g} s on"
            end = "" if end_s is None else f" before {end_s:g} s"
            raise AnalysisError(
                f"no row lies{begin}{end}, the block has 0 s to {self.duration_s:g} s: choose a window within"
            )
        gaps = tuple(Gap(gap.row - first, gap.missing_rows) for gap in self.gaps if first < gap.row < last)
        return replace(self, first_tick=int(self.ticks()[first]), data=self.data[first:last], gaps=gaps)

    def without(self, rows: NDArray[np.bool_]) -> Self:
        """Return the block in which these rows, shape (n,), are missing, but not all of them."""
        kept = np.flatnonzero(~rows)
        ticks = self.ticks()[kept]
        missing = np.diff(ticks) // self.stride - 1
        gaps = tuple(Gap(int(row) + 1, int(missing[row])) for row in np.flatnonzero(missing))
        return replace(self, first_tick=int(ticks[0]), data=self.data[kept], gaps=gaps)

    def to_pandas(self) -> pd.DataFrame:
        """Return a DataFrame with index `time_s`; `attrs["units"]` has the units, samples are not copied.

        Raises:
            UsageError: pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError:
            raise UsageError(
                "pandas is not installed, and the block was to become a DataFrame: "
                "pip install 'benchtool[pandas]'"
            ) from None
        index = pd.Index(self.time_s(), name="time_s")
        frame = pd.DataFrame(self.data, index=index, columns=list(self.names), copy=False)
        frame.attrs["units"] = {each.name: each.unit for each in self.channels}
        return frame

    def to_arrow(self) -> pa.RecordBatch:
        """Return Arrow columns, `time_s` before the channels.

        Units are metadata of the fields, the time base of the schema. Samples that lie one after the other,
        as of a recording, are not copied.
        """
        from benchtool.block.arrow import timed_batch_of

        return timed_batch_of(self)

    def plot(self, *channels: str, figure: Figure | None = None) -> Plot:
        """Draw channels against time, one panel for each unit; of all channels without a name.

        Args:
            channels: names.
            figure: where to draw, such as a new one of pyplot; one of its own without it.

        Raises:
            AnalysisError: the block has no such channel.
        """
        from benchtool.block.plot import plot

        return plot(self, channels, figure)

    def require_uniform(self) -> None:
        """Refuse a block with a gap.

        Raises:
            AnalysisError: rows are missing; nothing is ever interpolated silently.
        """
        if self.gaps:
            missing = sum(gap.missing_rows for gap in self.gaps)
            rows = "1 row is" if missing == 1 else f"{missing} rows are"
            gaps = "1 gap" if len(self.gaps) == 1 else f"{len(self.gaps)} gaps"
            raise AnalysisError(
                f"{rows} missing in {gaps}, a uniformly sampled window is "
                f"needed: choose a window without a gap or record again"
            )
