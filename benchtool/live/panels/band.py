"""The band that the torque stays in, beside the limits that a plan puts on it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.messages import Message, TimeAxis, lines, scalars

Limits = Mapping[str, tuple[float | None, float | None]]
"""(min, max) by name of a measurement, in its unit."""

_HALF_BAND_S = 0.25
_STEP_S = 0.02
_BREAK = np.array([math.nan])  # in a line, where there is nothing to draw
_SEEN = ((204, 204, 204), 1.0)
_RIPPLE = ((213, 94, 0), 1.0)
_MEAN = ((204, 121, 167), 1.0)

BAND_KEY = {
    "least and greatest": names.in_words(_SEEN[0]),
    "limits of the ripple": names.in_words(_RIPPLE[0]),
}
"""What the lines of the band are called in the key of the plots, and their colours."""


class TorqueBand:
    """Lowest and highest torque, the limit of `torque_ripple_pp` about its mean, those of `torque_mean`."""

    def __init__(self, limits: Limits) -> None:
        self.mean_Nm = 0.0
        """Mean torque of the last window."""
        self._limits = limits
        self._named: set[str] = set()
        self._torque = np.empty(0)
        self._ticks = np.empty(0, dtype=np.int64)

    def running(self, block: Block, axis: TimeAxis, *, broken: bool) -> list[Message]:
        """Return the band of a stream, half a second wide, a quarter of a second behind the block.

        `broken` if rows are missing before it; a gap starts afresh.
        """
        if "torque" not in block.names:
            return []
        begin = block.gaps[-1].row if block.gaps else 0
        windows, ticks = [], np.empty(0, dtype=np.int64)
        if broken or block.gaps:
            self._torque, self._ticks = self._torque[:0], self._ticks[:0]
            windows, ticks = [_BREAK], axis.ticks(block)[[begin]]
        self._torque = np.concatenate((self._torque, block.column("torque")[begin:]))
        self._ticks = np.concatenate((self._ticks, axis.ticks(block)[begin:]))
        half, step = (max(1, round(s * block.sample_rate_Hz)) for s in (_HALF_BAND_S, _STEP_S))
        places = np.arange(half, len(self._torque) - half, step)
        windows += [self._torque[place - half : place + half + 1] for place in places]
        ticks = np.concatenate((ticks, self._ticks[places]))
        done = len(places) * step  # rows that no window needs any more
        self._torque, self._ticks = self._torque[done:], self._ticks[done:]
        return self._messages(names.TORQUE_BAND, axis, ticks, windows) if windows else []

    def whole(self, block: Block, axis: TimeAxis) -> list[Message]:
        """Return the band of a whole capture, from its first to its last row."""
        if "torque" not in block.names:
            return []
        torque = block.column("torque")
        return self._messages(names.CAPTURE_BAND, axis, axis.ticks(block)[[0, -1]], [torque, torque])

    def _messages(
        self,
        entity: str,
        axis: TimeAxis,
        ticks: NDArray[np.int64],
        windows: Sequence[NDArray[np.float64]],
    ) -> list[Message]:
        mean = np.array([window.mean() for window in windows])
        if math.isfinite(mean[-1]):
            self.mean_Nm = float(mean[-1])
        values = {
            "lowest torque (Nm)": (np.array([window.min() for window in windows]), _SEEN),
            "highest torque (Nm)": (np.array([window.max() for window in windows]), _SEEN),
        }
        _, ripple = self._limits.get("torque_ripple_pp", (None, None))
        if ripple is not None:
            values["ripple limit, lower (Nm)"] = (mean - ripple / 2.0, _RIPPLE)
            values["ripple limit, upper (Nm)"] = (mean + ripple / 2.0, _RIPPLE)
        least, most = self._limits.get("torque_mean", (None, None))
        for name, bound in (("least mean torque (Nm)", least), ("most mean torque (Nm)", most)):
            if bound is not None:
                values[name] = (np.full(len(mean), bound), _MEAN)
        rows = np.column_stack([value for value, _ in values.values()])
        messages: list[Message] = [scalars(entity, axis, ticks, rows)]
        if entity not in self._named:
            self._named.add(entity)
            messages.insert(0, lines(entity, {name: style for name, (_, style) in values.items()}))
        return messages
