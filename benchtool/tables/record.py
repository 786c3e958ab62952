"""The rows of a table in SI units, and what their time stamps allow to be made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Basis
from benchtool.analysis.validity import require_signal
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError
from benchtool.tables.columns import TableQuestion
from benchtool.tables.time_base import TimeBase


@dataclass(frozen=True)
class Record:
    """Rows in SI units, the time first; `channels` are the other columns, by what they are."""

    data: NDArray[np.float64]
    base: TimeBase
    channels: Mapping[str, Channel]
    question: TableQuestion

    @property
    def block(self) -> Block | None:
        """The rows as a block, perhaps with gaps, if their time stamps are even."""
        if self.base.refusal:
            return None
        channels = tuple(self.channels.values())
        return Block(channels, 0, 1, self.base.step_s, self.data[:, 1:], self.base.gaps)

    @property
    def uniform(self) -> Block | None:
        """The block, if no rows are missing."""
        return None if self.base.gaps else self.block

    @property
    def basis(self) -> Basis:
        """What the rows are, whatever is made of them."""
        duration_s = float(np.ptp(self.data[:, 0]))
        rate_Hz = None if self.base.refusal else self.base.rate_Hz
        gaps = None if self.base.refusal or not self.base.gaps_known else len(self.base.gaps)
        return Basis(len(self.data), rate_Hz, duration_s, gaps=gaps)

    @property
    def rate_relative(self) -> float | None:
        """Standard uncertainty of the rate, relative to it, by the stamps; None of a rate that was stated."""
        return self.base.rate_relative if self.question.rate_Hz is None else None

    @property
    def uneven(self) -> str:
        """Why nothing that needs even steps can be said."""
        return self.base.refusal or (
            f"{self.base.missing_rows} rows are missing in {len(self.base.gaps)} gaps, the first before row "
            f"{self.base.gaps[0].row + 1}"
        )

    def column(self, what: str) -> NDArray[np.float64]:
        """Values of what is one of `channels`, shape (n,)."""
        return self.data[:, 1 + list(self.channels).index(what)]

    def dead(self, what: str) -> str:
        """Why a column says nothing at all, or nothing."""
        try:
            require_signal(self.column(what), self.channels[what].name)
        except AnalysisError as refused:
            return str(refused)
        return ""
