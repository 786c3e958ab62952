"""The input of an analysis: a capture or a part of it, the machine, and shared intermediate results."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from threading import Lock
from typing import Any, Final, Self, TypeVar

import numpy as np

from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.block import Block
from benchtool.profile import Motor

PLAYED: Final = "stimulus"
"""Channel of what the drive plays, which it adds to the setpoint."""

Shared = TypeVar("Shared")


@dataclass(frozen=True)
class Excitation:
    """The rows in which a stimulus plays, its first repetition left out; `period_rows` where it repeats.

    `setpoint` is what the drive adds the stimulus to, in the unit of its channel.
    """

    begin_row: int = 0
    end_row: int | None = None
    period_rows: int | None = None
    setpoint: float = 0.0


class _Shared:
    """Values computed once, by the first thread that requests them."""

    def __init__(self) -> None:
        self._lock = Lock()
        self._locks: dict[object, Lock] = {}
        self._values: dict[object, Any] = {}

    def get(self, key: object, compute: Callable[[], Any]) -> Any:
        with self._lock:
            lock = self._locks.setdefault(key, Lock())
        with lock:
            if key not in self._values:
                self._values[key] = compute()
            return self._values[key]


@dataclass(frozen=True)
class Window:
    """A capture, or the part of it in steady state.

    `torque_rated_Nm` and `current_rated_A_rms` are the bases of numbers "of rated"; without the second there
    is no `current_tdd`. `transducer` has channel torque_transducer and covers the block's time. `motor` is
    needed by analyses that test its parameters; its `slots` name orders. `excitation` says where a stimulus
    plays. `at_drive_ticks` is set of rows that the drive took at its own ticks, at which its references
    change; another recorder, of which a table is, does not run with them.
    """

    block: Block
    pole_pairs: int
    torque_rated_Nm: float
    current_rated_A_rms: float | None = None
    transducer: Block | None = None
    motor: Motor | None = None
    excitation: Excitation = Excitation()
    at_drive_ticks: bool = True
    _shared: _Shared = field(default_factory=_Shared, init=False, repr=False, compare=False)

    @classmethod
    def of(
        cls, block: Block, motor: Motor, transducer: Block | None = None, excitation: Excitation | None = None
    ) -> Self:
        """Return the window of a machine whose rating and parameters are known."""
        rated = motor.T_N_Nm, motor.I_N_A_rms
        return cls(block, motor.pole_pairs, *rated, transducer, motor, excitation or Excitation())

    def cached(self, compute: Callable[[Window], Shared]) -> Shared:
        """Return `compute(self)`, computed once and cached for all analyses."""
        value: Shared = self._shared.get(compute, lambda: compute(self))
        return value

    def block_of_reference(self, channel: str) -> Block:
        """Return the block in which a channel is a reference that the drive follows: what it plays counts
        from the setpoint."""
        if channel != PLAYED or not self.excitation.setpoint:
            return self.block
        data = np.array(self.block.data)
        data[:, self.block.names.index(PLAYED)] += self.excitation.setpoint
        return replace(self.block, data=data)

    @property
    def track(self) -> PhaseTrack | None:
        """Electrical phase by theta_m, without that by i_a; None without both.

        Raises:
            AnalysisError: fewer than two electrical periods, or a speed that is not steady.
        """
        return self.cached(_track)


def _track(window: Window) -> PhaseTrack | None:
    names = window.block.names
    if "theta_m" in names:
        return track_angle(np.ascontiguousarray(window.block.column("theta_m")), window.pole_pairs)
    if "i_a" in names:
        return track_tone(np.ascontiguousarray(window.block.column("i_a")), "i_a")
    return None
