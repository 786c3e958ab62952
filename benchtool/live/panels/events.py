"""States, faults, triggers and other events: a log on the timeline, with markers for the important ones."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import Final, NamedTuple

import numpy as np
import rerun as rr

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.messages import Message, StaticContent, TimeAxis, at, scalars
from benchtool.protocol import COUNTING_SIGNALS
from benchtool.recording import Event, Level

_MOST = 1000
_MARKERS: Final = {
    names.ERROR: ("error", (213, 94, 0), rr.components.MarkerShape.Cross, 8.0),
    names.WARNING: ("warning", (230, 159, 0), rr.components.MarkerShape.Circle, 4.0),
    names.TRIGGER: ("trigger", (0, 158, 115), rr.components.MarkerShape.Up, 8.0),
}
_MARKED: Final = {Level.INFO: None, Level.WARN: names.WARNING, Level.ERROR: names.ERROR}


class _Waiting(NamedTuple):
    event: Event
    marker: str | None


class EventLog:
    """Events from any thread, kept until they are sent; of more than a thousand the oldest go."""

    def __init__(self) -> None:
        self.stateful = False
        """Whether a state of the drive has been noted."""
        self._waiting: deque[_Waiting] = deque(maxlen=_MOST)
        self._counted: dict[str, float] = {}

    @property
    def waiting(self) -> bool:
        return bool(self._waiting)

    def add(self, event: Event) -> None:
        """Note an event, at its drive tick or at that of the last row."""
        self.stateful = self.stateful or event.state is not None
        self._waiting.append(_Waiting(event, _MARKED[event.level]))

    def trigger(self, tick: int) -> None:
        """Note where a capture was triggered."""
        self._waiting.append(_Waiting(Event(text="trigger", tick=tick), names.TRIGGER))

    def notice(self, block: Block) -> None:
        """Note where a counter of the drive has gone up."""
        for name in COUNTING_SIGNALS:
            if name in block.names:
                last = float(block.column(name)[-1])
                before = self._counted.get(name, float(block.column(name)[0]))
                if last > before:
                    text = f"{name}: {last - before:.0f} more"
                    self.add(Event(text=text, level=Level.WARN, tick=int(block.ticks()[-1])))
                self._counted[name] = last

    def messages(self, axis: TimeAxis, last_tick: int, marker_Nm: float) -> list[Message]:
        """Return what waits, as of `last_tick` if it has no tick; its markers at `marker_Nm`."""
        messages: list[Message] = []
        with suppress(IndexError):
            while True:
                event, marker = self._waiting.popleft()
                tick = last_tick if event.tick is None else event.tick
                line = rr.TextLog.columns(text=[event.text], level=[event.level.value])
                messages.append(at(names.EVENTS, axis, tick, line))
                if event.state is not None:
                    band = rr.StateChange.columns(state=[event.state])
                    messages.append(at(names.STATE, axis, tick, band))
                if marker is not None:
                    place, value = np.array([tick], dtype=np.int64), np.array([[marker_Nm]])
                    messages.append(scalars(marker, axis, place, value))
        return messages


def markers() -> list[StaticContent]:
    """Return the names and shapes of the markers."""
    return [
        StaticContent(
            entity, rr.SeriesPoints(names=[name], colors=[colour], markers=[shape], marker_sizes=[size])
        )
        for entity, (name, colour, shape, size) in _MARKERS.items()
    ]
