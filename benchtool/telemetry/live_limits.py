"""Limits supervised on live data: a sink that remembers the first row beyond one."""

from __future__ import annotations

import numpy as np

from benchtool.block import Block
from benchtool.errors import LimitTrip
from benchtool.profile import Limits
from benchtool.telemetry.fanout import Sink

_PHASES = ("i_a", "i_b", "i_c")


class LiveLimits:
    """The limits of a profile against the stream of a drive.

    `sinks` take the blocks in a thread of their own, and are none where the stream has no limit; `check`
    raises in the caller's what was found there.
    Channels that the stream does not have are not looked at.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._found = ""
        self.sinks = (Sink("limits", self._take, lossless=True),) if limits.channels else ()

    def check(self) -> None:
        """Raise the first breach.

        Raises:
            LimitTrip: a limit was passed.
        """
        if self._found:
            raise LimitTrip(self._found)

    def check_temperature(self, winding_degC: float | None) -> None:
        """Judge a reading of the winding's temperature, if there is one.

        Raises:
            LimitTrip: it is above its limit, or no number.
        """
        limit = self._limits.temperature_degC
        if limit is not None and winding_degC is not None and not winding_degC <= limit:
            raise LimitTrip(_told("the winding's temperature", winding_degC, limit, "degC"))

    def _take(self, block: Block) -> None:
        if self._found:
            return
        limits, columns = self._limits, {name: block.data[:, n] for n, name in enumerate(block.names)}
        judged = [("torque", limits.torque_Nm, "Nm"), ("omega_m", limits.omega_m_rad_s, "rad/s")]
        judged += [(name, limits.current_A, "A") for name in _PHASES]
        if all(name in columns for name in _PHASES):
            columns["i_a + i_b + i_c"] = columns["i_a"] + columns["i_b"] + columns["i_c"]
            judged.append(("i_a + i_b + i_c", limits.current_sum_A, "A"))
        for name, limit, unit in judged:
            if limit is None or name not in columns:
                continue
            beyond = ~(np.abs(columns[name]) <= limit)  # also what is no number
            if beyond.any():
                row = int(np.argmax(beyond))
                tick = int(block.ticks()[row])
                self._found = f"{_told(name, float(columns[name][row]), limit, unit)}, at tick {tick}"
                return


def _told(name: str, value: float, limit: float, unit: str) -> str:
    return (
        f"{name} is {value:.4g} {unit}, the profile's limit is {limit:g} {unit}: the drive was told to stop; "
        f"find the cause, or correct [limits]"
    )
