"""States, faults, triggers and what else happened: a log on the timeline, with a marker where it matters."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import Final, NamedTuple

import numpy as np
import rerun as rr

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.columns import Message, Still, TimeAxis, at, scalars
from benchtool.protocol.cia402 import State

INFO: Final = "INFO"
WARN: Final = "WARN"
ERROR: Final = "ERROR"

_MOST = 1000
_COUNTING = ("law_clipped", "adc_saturated")
_FAULTS = (State.FAULT, State.FAULT_REACTION_ACTIVE)
_MARKERS: Final = {
    names.FAULT: ("fault", (213, 94, 0), rr.components.MarkerShape.Cross, 8.0),
    names.WARNING: ("warning", (230, 159, 0), rr.components.MarkerShape.Circle, 4.0),
    names.TRIGGER: ("trigger", (0, 158, 115), rr.components.MarkerShape.Up, 8.0),
}
_MARKED: Final = {INFO: None, WARN: names.WARNING, ERROR: names.FAULT}


class _Event(NamedTuple):
    text: str
    level: str
    tick: int | None
    marker: str | None
    state: State | None = None


class Journal:
    """Events from any thread, kept until they are sent; of more than a thousand the oldest go."""

    def __init__(self) -> None:
        self._waiting: deque[_Event] = deque(maxlen=_MOST)
        self._counted: dict[str, float] = {}
        self._state: State | None = None

    @property
    def waiting(self) -> bool:
        return bool(self._waiting)

    @property
    def stateful(self) -> bool:
        """Whether a state of the drive has been noted."""
        return self._state is not None

    def event(self, text: str, level: str = INFO, tick: int | None = None) -> None:
        """Note a line, at a drive tick or at that of the last row."""
        self._waiting.append(_Event(text, level, tick, _MARKED[level]))

    def trigger(self, text: str, tick: int) -> None:
        """Note what a capture was triggered by."""
        self._waiting.append(_Event(text, INFO, tick, names.TRIGGER))

    def state(self, state: State, tick: int | None = None) -> None:
        """Note the drive's state, if it is another than before."""
        if state is not self._state:
            self._state = state
            level = ERROR if state in _FAULTS else INFO
            self._waiting.append(_Event(f"state: {state.value}", level, tick, _MARKED[level], state))

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
        """What waits, as of `last_tick` if it has no tick; its markers at `marker_Nm`."""
        messages: list[Message] = []
        with suppress(IndexError):
            while True:
                event = self._waiting.popleft()
                tick = last_tick if event.tick is None else event.tick
                line = rr.TextLog.columns(text=[event.text], level=[event.level])
                messages.append(at(names.EVENTS, axis, tick, line))
                if event.state is not None:
                    band = rr.StateChange.columns(state=[event.state.value])
                    messages.append(at(names.STATE, axis, tick, band))
                if event.marker is not None:
                    place, value = np.array([tick], dtype=np.int64), np.array([[marker_Nm]])
                    messages.append(scalars(event.marker, axis, place, value))
        return messages


def markers() -> list[Still]:
    """Names and shapes of the markers."""
    return [
        Still(entity, rr.SeriesPoints(names=[name], colors=[colour], markers=[shape], marker_sizes=[size]))
        for entity, (name, colour, shape, size) in _MARKERS.items()
    ]
