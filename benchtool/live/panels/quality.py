"""How good the data are so far: losses as series, and every counter as a line of text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import cycle
from typing import Final

import numpy as np
import rerun as rr

from benchtool.live import names
from benchtool.live.messages import Message, TimeAxis, at, lines, scalars

Counters = Callable[[], Mapping[str, int]]
"""Counts by name, from any thread."""

_TOLD_S = 1.0
_COLOURS: Final = (
    *((213, 94, 0), (230, 159, 0), (204, 121, 167)),
    *((86, 180, 233), (0, 158, 115), (240, 228, 66)),
)


class Quality:
    """Rows received and missing, rows not shown, and what else is counted.

    Args:
        not_shown: rows that did not get there, by place.
    """

    def __init__(self, not_shown: Counters) -> None:
        self._not_shown = not_shown
        self._others: Counters | None = None
        self._received = self._missing = 0
        self._named = False
        self._told_tick: int | None = None

    def count(self, others: Counters) -> None:
        """Show these counters too; their names stay the same from the first call on."""
        self._others = others

    def add(self, received: int, missing: int) -> None:
        """Count rows of the stream."""
        self._received += received
        self._missing += missing

    def messages(self, axis: TimeAxis, tick: int, *, last: bool = False) -> list[Message]:
        """Return the counters now; as text once a second of drive time, and at the end."""
        counts = {"telemetry_rows_received": self._received, "telemetry_rows_missing": self._missing}
        counts |= {f"rows_not_shown ({place})": count for place, count in self._not_shown().items()}
        counts |= {} if self._others is None else self._others()
        messages: list[Message] = []
        for entity, names_of in _entities(counts).items():
            if not self._named:
                colours = dict(zip(names_of, cycle(_COLOURS), strict=False))
                messages.append(lines(entity, {name: (colour, 1.5) for name, colour in colours.items()}))
            values = np.array([[counts[name] for name in names_of]], dtype=np.float64)
            messages.append(scalars(entity, axis, np.array([tick], dtype=np.int64), values))
        self._named = True
        due = self._told_tick is None or tick >= self._told_tick + round(_TOLD_S / axis.tick_s)
        if due or last:
            self._told_tick = tick
            line = rr.TextDocument.columns(text=[_text(counts)], media_type=[rr.MediaType.MARKDOWN])
            messages.append(at(names.COUNTERS, axis, tick, line))
        return messages


def _entities(counts: Mapping[str, int]) -> dict[str, tuple[str, ...]]:
    """Return the names of counters by the entity that they are a series of."""
    arrived = tuple(name for name in counts if name.endswith("_received"))
    return {names.RECEPTION: arrived, names.QUALITY: tuple(name for name in counts if name not in arrived)}


def _text(counts: Mapping[str, int]) -> str:
    """Return every counter, those that are not zero in bold."""
    told = {name.replace("_", " "): count for name, count in counts.items()}
    return " · ".join(f"**{name} {count}**" if count else f"{name} {count}" for name, count in told.items())
