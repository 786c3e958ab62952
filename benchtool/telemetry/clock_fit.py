"""Fit of the host's clock against the drive's: a straight line through (drive time, arrival)."""

from __future__ import annotations

import math
import threading
from array import array
from dataclasses import dataclass

import numpy as np

_MOST = 1 << 15
_ROUNDING = 4.0 * math.ulp(1.0)  # relative: of the host's times, and of the drive's as tick x tick_s


@dataclass(frozen=True)
class ClockFit:
    """arrival_s = offset_s + (1 + drift_ppm / 1e6) * tick * tick_s, by least squares.

    The residuals contain the variation of transmission: they bound the error of a moment of the drive on the
    host's clock.
    """

    records: int
    offset_s: float
    drift_ppm: float
    residual_rms_s: float
    residual_max_s: float

    def drive_s(self, arrival_s: float) -> float:
        """Drive time, tick x tick_s, at a moment of the host's clock."""
        return (arrival_s - self.offset_s) / (1.0 + self.drift_ppm * 1e-6)


class ArrivalStatistics:
    """Collects the arrivals of a stream's records.

    Up to 32768 pairs are kept, of a longer stream evenly fewer, so that a day's recording needs no more. One
    thread adds; any may ask.
    """

    def __init__(self, tick_s: float) -> None:
        self._tick_s = tick_s
        self._every = 1
        self._count = 0
        self._ticks = array("q")
        self._arrivals = array("d")
        self._growing = threading.Lock()  # an array that is being read cannot grow
        self._last: tuple[int, float] | None = None
        self._intervals = 0
        self._squares = 0.0
        self.jitter_max_s = 0.0

    def add(self, tick: int, arrival_s: float) -> None:
        """Note a record."""
        if self._last is not None:
            last_tick, last_s = self._last
            deviation = (arrival_s - last_s) - (tick - last_tick) * self._tick_s
            if abs(deviation) <= _ROUNDING * abs(arrival_s):
                deviation = 0.0
            self._intervals += 1
            self._squares += deviation * deviation
            self.jitter_max_s = max(self.jitter_max_s, abs(deviation))
        self._last = (tick, arrival_s)
        if self._count % self._every == 0:
            with self._growing:
                self._ticks.append(tick)
                self._arrivals.append(arrival_s)
                if len(self._ticks) == _MOST:
                    self._ticks, self._arrivals = self._ticks[::2], self._arrivals[::2]
                    self._every *= 2
        self._count += 1

    @property
    def jitter_rms_s(self) -> float:
        """Deviation of the time between two arrivals from the drive time between them, rms."""
        return math.sqrt(self._squares / self._intervals) if self._intervals else 0.0

    def fit(self) -> ClockFit | None:
        """Return the line; None for fewer than three records."""
        with self._growing:
            ticks, arrivals = np.array(self._ticks), np.array(self._arrivals)
        if len(ticks) < 3:
            return None
        drive_s = (ticks - ticks[0]) * self._tick_s
        # Centred, and as the deviation from drive time, so that a day's seconds do not cost microseconds.
        deviation = (arrivals - arrivals[0]) - drive_s
        deviation[np.abs(deviation) <= _ROUNDING * np.max(np.abs(arrivals))] = 0.0
        centred = drive_s - drive_s.mean()
        slope = float(centred @ (deviation - deviation.mean()) / (centred @ centred))
        residual = deviation - deviation.mean() - slope * centred
        at_first = float(arrivals[0] + deviation.mean() - slope * drive_s.mean())
        return ClockFit(
            records=self._count,
            offset_s=at_first - (1.0 + slope) * float(ticks[0]) * self._tick_s,
            drift_ppm=slope * 1e6,
            residual_rms_s=float(np.sqrt(np.mean(residual**2))),
            residual_max_s=float(np.max(np.abs(residual))),
        )
