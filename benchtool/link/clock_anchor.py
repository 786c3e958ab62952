"""Anchors between the ticks of a drive and the clocks of the host."""

from __future__ import annotations

import math
from dataclasses import dataclass

from benchtool.ticks import ticks_between

_ROUNDING = 1e-6
_SLACK_S = 0.5
_CLOCKS = 1e-3  # by which two clocks may differ


@dataclass(frozen=True)
class ClockAnchor:
    """The drive's tick at a wall time, in seconds since 1970, and the length of a tick."""

    tick: int
    tick_s: float
    wall_s: float


@dataclass(frozen=True)
class TickAnchor:
    """The drive's tick, unwrapped past 2**32, at a moment of the host's clock, and the length of a tick."""

    tick: int
    at_s: float
    tick_s: float

    def tick_at(self, at_s: float) -> int:
        """Return the tick at another moment, of a drive that ran on with a clock like the host's."""
        return self.tick + math.floor((at_s - self.at_s) / self.tick_s + _ROUNDING)

    def restarted_since(self, later: TickAnchor) -> bool:
        """Return whether the ticks up to `later` differ from the time that has passed.

        Within half a second of a power-up a restart is not detected.
        """
        past_s = later.at_s - self.at_s
        expected = self.tick + round(past_s / self.tick_s)
        apart_s = ticks_between(later.tick, expected) * self.tick_s
        return apart_s > _SLACK_S + _CLOCKS * past_s
