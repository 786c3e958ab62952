"""The Block: the only thing that flows from the wire to the report."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from benchtool.errors import AnalysisError


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
    the time axis is never typed in by hand.
    """

    channels: tuple[Channel, ...]
    first_tick: int
    stride: int
    tick_s: float
    data: NDArray[np.float64]
    gaps: tuple[Gap, ...] = field(default=())

    def __post_init__(self) -> None:
        if self.data.ndim != 2 or self.data.shape[1] != len(self.channels):
            raise ValueError(f"data of shape {self.data.shape} for {len(self.channels)} channels")

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
            raise AnalysisError(
                f"{missing} rows are missing in {len(self.gaps)} gaps, a uniformly sampled window is "
                f"needed: choose a window without a gap or record again"
            )
