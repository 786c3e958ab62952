"""The rows of a table in SI units, and their time base."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis import Basis, continued, count_of, require_signal
from benchtool.analysis.orders import held_angle, unwrapped_angle
from benchtool.block import Block, Channel, Gap
from benchtool.errors import AnalysisError
from benchtool.tables.columns import TableQuestion
from benchtool.tables.lost import Lost
from benchtool.tables.stale_rows import repeating_rows, stale_rows, too_stale
from benchtool.tables.time_base import TimeBase, time_base

_AT_REST = 0.1  # of the speed in the other rows
_LEAST_STRETCH = 0.25  # of the rows: mean and ripple of a shorter one do not stand for the record


@dataclass(frozen=True)
class Cut:
    """The rows of which the longest stretch without a missing one was taken, and what was missing."""

    rows: int
    gaps: tuple[Gap, ...]

    @property
    def missing_rows(self) -> int:
        return sum(gap.missing_rows for gap in self.gaps)


@dataclass(frozen=True)
class Record:
    """Rows in SI units, the time first; `channels` are the other columns, by kind, `lost` what is missing.

    `analyses` are those that are asked for, with their settings. `cut` is set where the rows are the longest
    stretch of more rows, `unbroken`; `restored_rows` of them were stale, `restored`.
    """

    data: NDArray[np.float64]
    base: TimeBase
    channels: Mapping[str, Channel]
    question: TableQuestion
    lost: Lost = field(default_factory=Lost)
    cut: Cut | None = None
    restored_rows: int = 0
    analyses: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    @property
    def unbroken(self) -> Record:
        """The longest stretch without a missing row, where it is a quarter of the rows or more: what was
        missing elsewhere moves none of its numbers. Else the record as it is, and where an angle gives the
        scatter of what has no spectrum."""
        if "angle" in self.channels and "current" not in self.channels and not self.lost.within:
            return self
        longest = self.even
        is_enough = longest is not None and len(longest.data) >= _LEAST_STRETCH * len(self.data)
        return longest if longest is not None and is_enough else self

    @cached_property
    def even(self) -> Record | None:
        """The rows with even steps, of which a spectrum can be made: all, else the longest stretch without a
        missing one; None where there are none."""
        gaps, count = self.base.gaps, len(self.data)
        if self.base.refusal:
            return None
        if not gaps:
            return self
        edges = [0, *(gap.row for gap in gaps), count]
        first, last = max(itertools.pairwise(edges), key=lambda ends: ends[1] - ends[0])
        begin = int(np.searchsorted(self.data[first:last, 0], self.data[last - 1, 0]))
        if (
            last < count and begin < last - first - 1
        ):  # under which of equal stamps a row is missing is unknown
            last = first + begin
        rows = self.data[first:last]
        base = time_base(rows[:, 0], rows[:, 1:])
        if not self.base.gaps_known or base.refusal or base.gaps:
            return None
        return replace(self, data=rows, base=base, lost=replace(self.lost, within=0), cut=Cut(count, gaps))

    @cached_property
    def repeating(self) -> NDArray[np.bool_]:
        """Which of the rows repeat the one before, though not by chance, shape (n,)."""
        return repeating_rows(self.data[:, 1:])

    @cached_property
    def stale(self) -> NDArray[np.bool_]:
        """Which of the rows repeat the one before because nothing new was read, shape (n,)."""
        return stale_rows(self.repeating)

    @cached_property
    def lost_angle(self) -> NDArray[np.bool_]:
        """Which of the rows have an angle that stood still of a sudden, shape (n,)."""
        if "angle" in self.channels:
            try:
                return held_angle(unwrapped_angle(self.column("angle"), self.channels["angle"].name))
            except AnalysisError:  # in another unit, or dead
                pass
        return np.zeros(len(self.data), dtype=np.bool_)

    @property
    def angle_refusal(self) -> str:
        """Why the angle tells neither periods nor a course; empty if it does, or there is none."""
        if not np.any(self.lost_angle):
            return ""
        first, count = int(np.argmax(self.lost_angle)), int(np.count_nonzero(self.lost_angle))
        return (
            f"'{self.channels['angle'].name}' stands still from row {first} (from 0) on, in "
            f"{count_of(count, 'row')} in all, {self._rotor_there}"
        )

    @property
    def _rotor_there(self) -> str:
        """What the rotor did while the angle stood still: a speed may say that it stood as well, which
        without one is told by how abruptly the angle stops."""
        if "speed" in self.channels:
            speed_rad_s = np.abs(self.column("speed"))
            there = float(np.median(speed_rad_s[self.lost_angle]))
            if not np.all(self.lost_angle) and there < _AT_REST * np.median(speed_rad_s[~self.lost_angle]):
                mean_rad_s = float(np.mean(self.column("speed")[self.lost_angle]))
                return (
                    f"and by '{self.channels['speed'].name}', whose mean there is {mean_rad_s:.3g} rad/s, so "
                    f"did the rotor"
                )
        return "while the rotor turned (its sensor or its link was lost)"

    @cached_property
    def restored(self) -> Record:
        """The rows, of even steps, those that are stale as the others have it: a line is smaller in values
        that are late.

        Raises:
            AnalysisError: the others do not tell.
        """
        if not np.any(self.stale):
            return self
        if reason := too_stale(self.stale):
            raise AnalysisError(reason)
        data = self.data.copy()
        for column, (what, channel) in enumerate(self.channels.items(), 1):
            if what == "angle":
                data[:, column] = _restored_angle(unwrapped_angle(data[:, column], channel.name), self.stale)
            else:
                data[:, column] = continued(data[:, column], self.stale)
        return replace(self, data=data, restored_rows=int(np.count_nonzero(self.stale)))

    @property
    def read(self) -> Block | None:
        """The block, in which rows are missing that are stale, or of which the angle was lost."""
        block = self.block
        late = self.stale | self.lost_angle
        return block if block is None or not np.any(late) else block.without(late)

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
        """Basis of the rows."""
        duration_s = float(np.ptp(self.data[:, 0]))
        rate_Hz = None if self.base.refusal else self.base.rate_Hz
        gaps = None if self.base.refusal or not self.base.gaps_known else len(self.base.gaps)
        return Basis(len(self.data), rate_Hz, duration_s, gaps=gaps)

    @property
    def rate_relative(self) -> float | None:
        """Standard uncertainty of the rate, relative to it, by the stamps; None for a stated rate."""
        return self.base.rate_relative if self.question.rate_Hz is None else None

    @property
    def uneven(self) -> str:
        """Reason why analyses with even steps are impossible."""
        return self.base.refusal or (
            f"{count_of(self.base.missing_rows, 'row is', 'rows are')} missing in "
            f"{count_of(len(self.base.gaps), 'gap')}, the first before row {self.base.gaps[0].row + 1}"
        )

    def column(self, what: str) -> NDArray[np.float64]:
        """Return the values of one of `channels`, shape (n,)."""
        return self.data[:, 1 + list(self.channels).index(what)]

    def dead(self, what: str) -> str:
        """Return why a column is dead, or what is left of it stands for nothing; empty if neither."""
        if reason := self.lost.reason(what):
            return f"'{self.channels[what].name}': {reason}"
        try:
            require_signal(self.column(what), self.channels[what].name, self.channels[what].unit)
        except AnalysisError as refused:
            return str(refused)
        return ""


def time_base_of(data: NDArray[np.float64], joined: str) -> TimeBase:
    """Return the time base of rows, shape (n, 1 + columns), the time first; refused where they are `joined`
    of several tables."""
    base = time_base(data[:, 0], data[:, 1:])
    return replace(base, gaps=(), refusal=joined) if joined else base


def _restored_angle(angle_rad: NDArray[np.float64], stale: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return an angle without jumps, shape (n,), that goes on where rows are stale."""
    rows = np.arange(len(angle_rad), dtype=np.float64)
    course = Polynomial.fit(rows[~stale], angle_rad[~stale], 2)(rows)
    return np.asarray(course + continued(angle_rad - course, stale))
