"""Mean of a signal whose course another channel tells too: what both have in common is no error of it."""

from __future__ import annotations

from dataclasses import dataclass

from benchtool.analysis.statistics.scatter import MeanError
from benchtool.analysis.uncertainty import Contribution


@dataclass(frozen=True)
class MeanBeside:
    """Mean over the time of a record, from its first row to its last, with its error by what the signal reads
    beside the course that `channel` tells; `between_records` is how much the mean of another record
    differs."""

    value: float
    error: MeanError
    between_records: Contribution | None
    channel: str

    @property
    def line(self) -> Contribution:
        """The line of a budget."""
        return self.error.line(f"scatter beside the course of {self.channel}")
