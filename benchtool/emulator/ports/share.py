"""Limit of the processor time of one wire, so that a flood on it does not delay the other wires."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Final

SHARE: Final = 0.25
"""Of one processor, for what a wire's client sends; hundreds of requests a second need a tenth of that."""

MOST_B: Final = 4096
"""Most bytes read from a wire at a time: handling them delays the drive."""

_BURST_S: Final = 0.05


class Share:
    """A budget of processor time, which fills up as time passes and is spent by handling what was read.

    A wire whose budget is spent is not read until there is some again. What its client sends meanwhile waits
    in the operating system, which holds the client back as a slower line would.

    Args:
        share: of a processor.
        now_s: time as the budget fills up by it.
        spent_s: processor time of the calling thread.
    """

    def __init__(
        self,
        share: float = SHARE,
        now_s: Callable[[], float] = time.monotonic,
        spent_s: Callable[[], float] = time.thread_time,
    ) -> None:
        self._share = share
        self._now_s, self._spent_s = now_s, spent_s
        self._budget_s = _BURST_S
        self._filled_s = now_s()
        self._handling_since_s: float | None = None

    def handed_over(self) -> None:
        """Something was read: the thread handles it until it asks for `pause_s`."""
        self._handling_since_s = self._spent_s()

    def pause_s(self) -> float:
        """Return how long to wait before more is read; 0 within the budget. For the thread that reads."""
        now_s = self._now_s()
        self._budget_s = min(_BURST_S, self._budget_s + self._share * (now_s - self._filled_s))
        self._filled_s = now_s
        if self._handling_since_s is not None:
            self._budget_s -= self._spent_s() - self._handling_since_s
            self._handling_since_s = None
        return max(0.0, -self._budget_s / self._share)
