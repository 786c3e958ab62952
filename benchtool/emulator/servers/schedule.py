"""Actions at ticks of the drive."""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Callable

NEVER = 1 << 62


class Schedule:
    """Actions by the drive tick in which they are due, each called once."""

    def __init__(self) -> None:
        self._order = itertools.count()
        self._due: list[tuple[int, int, Callable[[], None]]] = []

    def add(self, tick: int, action: Callable[[], None]) -> None:
        """Call `action` once the drive has come to `tick`."""
        heapq.heappush(self._due, (tick, next(self._order), action))

    @property
    def next_tick(self) -> int:
        """The tick of the next action."""
        return self._due[0][0] if self._due else NEVER

    def run(self, tick: int) -> None:
        """Call what is due."""
        while self._due and self._due[0][0] <= tick:
            heapq.heappop(self._due)[2]()

    def clear(self) -> None:
        """Forget all actions."""
        self._due.clear()
