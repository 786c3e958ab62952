"""States, faults, triggers and what else happened: a log on the timeline, with a marker where it matters."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import Final, NamedTuple

import numpy as np
import rerun as rr

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.columns import Message, TimeAxis, at, scalars

INFO: Final = "INFO"
WARN: Final = "WARN"
ERROR: Final = "ERROR"

_MOST = 1000
_COUNTING = ("law_clipped", "adc_saturated")


class _Event(NamedTuple):
    text: str
    level: str
    tick: int | None
    state: str | None = None


class Journal:
    """Events from any thread, kept until they are sent; of more than a thousand the oldest go."""

    def __init__(self) -> None:
        self._waiting: deque[_Event] = deque(maxlen=_MOST)
        self._counted: dict[str, float] = {}
        self._state: str | None = None

    @property
    def waiting(self) -> bool:
        return bool(self._waiting)

    def event(self, text: str, level: str = INFO, tick: int | None = None) -> None:
        """Note a line, at a drive tick or at that of the last row."""
        self._waiting.append(_Event(text, level, tick))

    def state(self, state: str) -> None:
        """Note the drive's state, if it is another than before."""
        if state != self._state:
            self._state = state
            level = ERROR if state.startswith("fault") else INFO
            self._waiting.append(_Event(f"state: {state}", level, None, state))

    def notice(self, block: Block) -> None:
        """Note where a counter of the drive has gone up."""
        for name in _COUNTING:
            if name in block.names:
                last = float(block.column(name)[-1])
                before = self._counted.get(name, float(block.column(name)[0]))
                if last > before:
                    self.event(f"{name}: {last - before:.0f} more", WARN, int(block.ticks()[-1]))
                self._counted[name] = last

    def messages(self, axis: TimeAxis, last_tick: int, marker_Nm: float) -> list[Message]:
        """What waits, as of `last_tick` if it has no tick; all but INFO with a marker at `marker_Nm`."""
        messages: list[Message] = []
        with suppress(IndexError):
            while True:
                event = self._waiting.popleft()
                tick = last_tick if event.tick is None else event.tick
                line = rr.TextLog.columns(text=[event.text], level=[event.level])
                messages.append(at(names.EVENTS, axis, tick, line))
                if event.state is not None:
                    messages.append(at(names.STATE, axis, tick, rr.StateChange.columns(state=[event.state])))
                if event.level != INFO:
                    place, value = np.array([tick], dtype=np.int64), np.array([[marker_Nm]])
                    messages.append(scalars(names.MARKERS, axis, place, value))
        return messages
