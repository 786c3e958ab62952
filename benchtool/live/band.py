"""The band that the torque stays in, beside the limits that a plan puts on it."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping

import numpy as np

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.columns import Message, TimeAxis, lines, scalars

Limits = Mapping[str, tuple[float | None, float | None]]
"""(min, max) by name of a measurement, in its unit."""

_BAND_S = 1.0
_SEEN = ((150, 150, 150), 1.0)
_RIPPLE = ((213, 94, 0), 1.0)
_MEAN = ((204, 121, 167), 1.0)


class TorqueBand:
    """Lowest and highest torque, the limit of `torque_ripple_pp` about its mean, those of `torque_mean`."""

    def __init__(self, limits: Limits) -> None:
        self.mean_Nm = 0.0
        """Mean torque of what was seen last."""
        self._limits = limits
        self._named: set[str] = set()
        self._parts: deque[tuple[float, float, float, int]] = deque()

    def running(self, block: Block, axis: TimeAxis) -> list[Message]:
        """Band of the last second of a stream, from the first to the last row of its newest block."""
        if "torque" not in block.names:
            return []
        torque = block.column("torque")
        self._parts.append((float(torque.min()), float(torque.max()), float(torque.sum()), len(torque)))
        while len(self._parts) > 1 and sum(part[3] for part in self._parts) > _BAND_S * block.sample_rate_Hz:
            self._parts.popleft()
        rows = sum(part[3] for part in self._parts)
        self.mean_Nm = sum(part[2] for part in self._parts) / rows
        return self._messages(
            names.TORQUE_BAND,
            block,
            axis,
            min(part[0] for part in self._parts),
            max(part[1] for part in self._parts),
        )

    def whole(self, block: Block, axis: TimeAxis) -> list[Message]:
        """Band of a whole capture, from its first to its last row."""
        if "torque" not in block.names:
            return []
        torque = block.column("torque")
        self.mean_Nm = float(torque.mean())
        return self._messages(names.CAPTURE_BAND, block, axis, float(torque.min()), float(torque.max()))

    def _messages(
        self, entity: str, block: Block, axis: TimeAxis, lowest: float, highest: float
    ) -> list[Message]:
        values = {"lowest torque (Nm)": (lowest, _SEEN), "highest torque (Nm)": (highest, _SEEN)}
        _, ripple = self._limits.get("torque_ripple_pp", (None, None))
        if ripple is not None:
            values["ripple limit, lower (Nm)"] = (self.mean_Nm - ripple / 2.0, _RIPPLE)
            values["ripple limit, upper (Nm)"] = (self.mean_Nm + ripple / 2.0, _RIPPLE)
        least, most = self._limits.get("torque_mean", (None, None))
        for name, bound in (("least mean torque (Nm)", least), ("most mean torque (Nm)", most)):
            if bound is not None:
                values[name] = (bound, _MEAN)
        ends = np.array([axis.tick(block, 0), axis.tick(block, -1)], dtype=np.int64)
        rows = np.tile(np.array([value for value, _ in values.values()]), (2, 1))
        messages: list[Message] = [scalars(entity, axis, ends, rows)]
        if entity not in self._named:
            self._named.add(entity)
            messages.insert(0, lines(entity, {name: style for name, (_, style) in values.items()}))
        return messages
