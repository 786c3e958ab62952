"""Which rows of a recording without a plan were measured."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from benchtool.analysis import raw
from benchtool.block import Block
from benchtool.results.regimes import Regime


@dataclass(frozen=True)
class Recorded:
    """Which rows of a recording without a plan were measured.

    Attributes:
        stream: its name in the bundle.
        block: all of its rows.
        sha256: of its file, which is that of the whole stream whatever was measured of it; None of a
            recording that was cut short.
        regimes: those that were found; empty where a window was chosen.
        rows: the regime or the window; of these, the longest stretch without a missing row was measured.
    """

    stream: str
    block: Block
    sha256: str | None
    regimes: tuple[Regime, ...] = ()
    rows: Block | None = None

    def source(self, measured: Block) -> dict[str, Any]:
        """Of which rows the numbers are, such that another program can take the same ones."""
        rows = measured if self.rows is None else self.rows
        first = self.block.first_tick
        ticks = measured.ticks()
        return {
            "stream": self.stream,
            "sha256": self.sha256,
            "rate_Hz": self.block.sample_rate_Hz,
            "stride": self.block.stride,
            "first_tick": int(ticks[0]),
            "last_tick": int(ticks[-1]),
            "from_s": (int(ticks[0]) - first) * self.block.tick_s,
            "to_s": (int(ticks[-1]) - first + self.block.stride) * self.block.tick_s,
            "rows": len(measured.data),
            "rows_of_window": len(rows.data),
            "missing_rows": sum(gap.missing_rows for gap in rows.gaps),
            "gaps": len(rows.gaps),
            "regimes": [each.to_json() for each in self.regimes],
        }

    def remarks(self, measured: Block) -> Iterator[str]:
        """Yield which rows were measured, and what was left out."""
        source = self.source(measured)
        if len(self.regimes) > 1 or not self.regimes or source["gaps"]:
            yield (
                f"measured is {raw(source['from_s'], 6)} s to {raw(source['to_s'], 6)} s of stream "
                f"{self.stream}, {source['rows']} rows at {raw(source['rate_Hz'], 6)} Hz"
            )
        if source["gaps"]:
            yield (
                f"{source['missing_rows']} rows are missing in {source['gaps']} gaps there: the longest "
                f"stretch without one was taken, {source['rows']} of {source['rows_of_window']} rows"
            )
