"""The band that the torque stays in, beside the limits that a plan puts on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block
from benchtool.live import names
from benchtool.live.columns import Message, TimeAxis, lines, scalars

Limits = Mapping[str, tuple[float | None, float | None]]
"""(min, max) by name of a measurement, in its unit."""

_BAND_S = 0.5
_POINTS = 10  # of the band in a block
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
        self._recent = np.empty(0)

    def running(self, block: Block, axis: TimeAxis) -> list[Message]:
        """Band of the half second before each of some rows of a stream's newest block."""
        if "torque" not in block.names:
            return []
        rows = max(1, round(_BAND_S * block.sample_rate_Hz))
        before = len(self._recent)
        torque = np.concatenate((self._recent, block.column("torque")))
        self._recent = torque[-rows:]
        # the last row is among them, so that the band ends where the torque does
        ends = np.unique(np.ceil(np.linspace(0, len(block.data), _POINTS + 1)[1:]).astype(np.int64))
        windows = [torque[max(0, before + end - rows) : before + end] for end in ends]
        return self._messages(names.TORQUE_BAND, axis, axis.ticks(block)[ends - 1], windows)

    def whole(self, block: Block, axis: TimeAxis) -> list[Message]:
        """Band of a whole capture, from its first to its last row."""
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
