"""Limits judged on live data: the first row beyond one is remembered."""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block
from benchtool.errors import LimitTrip
from benchtool.profile import Limits

_PHASES = ("i_a", "i_b", "i_c")
_WINDOW_S = 0.4 - 1e-6  # two blocks of the stream
_TURNS_RAD_S = 10.0  # slower, the currents may hardly alternate within the window
_LEAST_A = 0.1


class LiveLimits:
    """The limits of a profile against the stream of a drive.

    `take` takes the blocks, in one thread; `check` raises in the caller's what was found there.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._found = ""
        self._squares: deque[tuple[NDArray[np.float64], float]] = deque()

    @property
    def passed(self) -> bool:
        """Whether a limit was."""
        return bool(self._found)

    def check(self) -> None:
        """Raise the first breach.

        Raises:
            LimitTrip: a limit was passed.
        """
        if self._found:
            raise LimitTrip(self._found)

    def take_temperature(self, winding_degC: float | None) -> None:
        """Judge a reading of the winding's temperature, if there is one."""
        limit = self._limits.temperature_degC
        if limit is not None and winding_degC is not None and not winding_degC <= limit:
            self._found = self._found or _told("the winding's temperature", winding_degC, limit, "degC")

    def take(self, block: Block) -> None:
        """Judge a block; channels that it does not have are not looked at."""
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
        if limits.current_unbalance_percent is not None and {*_PHASES, "omega_m"} <= set(columns):
            self._compare_phases(
                np.column_stack([columns[name] for name in _PHASES]),
                float(np.min(np.abs(columns["omega_m"]))),
                len(block.data) * block.stride * block.tick_s,
                limits.current_unbalance_percent,
            )

    def _compare_phases(
        self, currents: NDArray[np.float64], slowest_rad_s: float, duration_s: float, limit: float
    ) -> None:
        """Compare the rms of the phases over the last 0.4 s in which the shaft turned throughout."""
        if slowest_rad_s < _TURNS_RAD_S:
            self._squares.clear()
            return
        self._squares.append((currents**2, duration_s))
        past_s = sum(duration for _, duration in self._squares)
        if past_s < _WINDOW_S:
            return
        while past_s - self._squares[0][1] >= _WINDOW_S:
            past_s -= self._squares.popleft()[1]
        rms = np.sqrt(np.mean(np.vstack([squares for squares, _ in self._squares]), axis=0))
        if not rms.max() >= _LEAST_A:
            return
        unbalance = float(100.0 * (rms.max() - rms.min()) / rms.max())
        if not unbalance <= limit:
            shown = ", ".join(f"{name} {value:.3g} A" for name, value in zip(_PHASES, rms, strict=True))
            self._found = _told(f"unbalance of the phase currents ({shown})", unbalance, limit, "%")


def _told(name: str, value: float, limit: float, unit: str) -> str:
    return (
        f"{name} is {value:.4g} {unit}, the profile's limit is {limit:g} {unit}: the drive was told to stop; "
        f"find the cause, or correct [limits]"
    )
