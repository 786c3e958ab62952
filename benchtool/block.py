"""The Block: the only thing that flows from the wire to the report."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchtool.errors import AnalysisError


def as_samples(values: ArrayLike, name: str = "signal") -> NDArray[np.float64]:
    """Values of one signal as samples, shape (n,), float64; not copied where they are that already.

    Raises:
        AnalysisError: no real numbers, or of another shape.
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
    """Refuse a sample rate that is none.

    Raises:
        AnalysisError: not positive, or not finite.
    """
    if not (sample_rate_Hz > 0.0 and math.isfinite(sample_rate_Hz)):
        raise AnalysisError(
            f"the sample rate is {sample_rate_Hz:g} Hz, a positive one is needed: state rows per second"
        )


def read_only(array: NDArray[np.generic]) -> NDArray[np.generic]:
    """A view that cannot be written to."""
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


@dataclass(frozen=True)
class Block:
    """Uniformly clocked samples of several channels.

    `data` has shape (n, channels). Row k was taken at drive tick `first_tick + k * stride` plus the
    rows that `gaps` counts before it; a tick lasts `tick_s` seconds of the source's own clock, so that
    the time axis is never typed in by hand. Rows that another clock than the drive's has stamped are at their
    drive ticks within the standard uncertainty `alignment_s`; 0 of rows that the drive itself counted.
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
        """Channels that were sampled together at `rate_Hz`, without gaps, each of shape (n,), by name.

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

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(channel.name for channel in self.channels)

    @property
    def sample_rate_Hz(self) -> float:
        return 1.0 / (self.stride * self.tick_s)

    def column(self, name: str) -> NDArray[np.float64]:
        """Samples of one channel, shape (n,).

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

    def unit(self, name: str) -> str:
        """Unit of one channel."""
        return self.channels[self.names.index(name)].unit

    def ticks(self) -> NDArray[np.int64]:
        """Drive tick of every row, shape (n,), with the gaps in it."""
        rows = np.arange(len(self.data), dtype=np.int64)
        for gap in self.gaps:
            rows[gap.row :] += gap.missing_rows
        return self.first_tick + rows * self.stride

    def time_s(self) -> NDArray[np.float64]:
        """Time of every row since the first, shape (n,)."""
        return np.multiply(self.ticks() - self.first_tick, self.tick_s, dtype=np.float64)

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
