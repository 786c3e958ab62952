"""Timestamps of a CAN adapter on the host's clock."""

from __future__ import annotations

import can

from benchtool.clock import Clock

_CLOCKS = 2e-4  # by which an adapter's clock and the host's may differ
_JUMP_S = 1.0


class AdapterTimestamps:
    """Converts the timestamps of an adapter to arrival times on `clock`.

    An adapter counts from an origin of its own. The two clocks are tied together by the frame that took the
    shortest way through driver and host so far: no later than now, and even where the host was late. For an
    adapter without timestamps, or whose clock jumps by a second, the host's time is used.

    Args:
        clock: the host's.
    """

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._offset_s: float | None = None
        self._last_s = 0.0

    def __call__(self, frame: can.Message) -> float:
        now_s = self._clock.now_s()
        if not frame.timestamp > 0.0:
            return now_s
        offset_s = now_s - frame.timestamp
        if self._offset_s is None or abs(offset_s - self._offset_s) > _JUMP_S:
            self._offset_s = offset_s
        else:
            followed_s = self._offset_s + _CLOCKS * (now_s - self._last_s)
            self._offset_s = min(followed_s, offset_s)
        self._last_s = now_s
        return frame.timestamp + self._offset_s


def timestamp(frame: can.Message) -> float:
    """Return when a frame arrived, on a bus whose stamps are of the host's clock already."""
    return frame.timestamp
