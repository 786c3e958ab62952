"""Mutants of control: what it reads of the drive's memory is not what was written there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from benchtool.emulator.core.core import Core
from benchtool.emulator.mutants.mutant import Make, Mutant, Substitution


def _with(name: str, change: Callable[[Core, float], float]) -> Make:
    """Return what has control run with another value of an object, which reads back as it was written."""

    def make(original: Any) -> Any:
        def run(self: Core, ticks: int) -> int:
            value = float(self.memory[name][0])
            self.memory[name] = change(self, value)
            try:
                done: int = original(self, ticks)
            finally:
                self.memory[name] = value
            return done

        return run

    return make


def _times(factor: float) -> Callable[[Core, float], float]:
    return lambda _core, value: factor * value


def _one_quadrant(core: Core, value: float) -> float:
    return -value if value > 0.0 and float(core.shaft.omega_m) < 0.0 else value


def _of_core(name: str, change: Callable[[Core, float], float]) -> tuple[Substitution, ...]:
    return (Substitution(Core, "run", _with(name, change)),)


CONTROL: Final = (
    Mutant(
        "i_trip_doubled",
        "an over-current level at twice the one set",
        substitutions=_of_core("i_trip", _times(2.0)),
    ),
    Mutant(
        "omega_m_trip_doubled",
        "an over-speed level at twice the one set",
        substitutions=_of_core("omega_m_trip", _times(2.0)),
    ),
    Mutant(
        "u_dc_max_doubled",
        "an over-voltage level at twice the one set",
        substitutions=_of_core("u_dc_max", _times(2.0)),
    ),
    Mutant(
        "u_dc_min_halved",
        "an under-voltage level at half of the one set",
        substitutions=_of_core("u_dc_min", _times(0.5)),
    ),
    Mutant(
        "i2t_current_doubled",
        "an overload that counts half of the current",
        substitutions=_of_core("i2t_current", _times(2.0)),
    ),
    Mutant(
        "i2t_tau_doubled",
        "an overload that trips after twice the time",
        substitutions=_of_core("i2t_tau", _times(2.0)),
    ),
    Mutant(
        "torque_limit_doubled",
        "a torque limit at twice the one set",
        substitutions=_of_core("torque_limit", _times(2.0)),
    ),
    Mutant(
        "torque_scaled",
        "5 % more torque than is asked for",
        substitutions=_of_core("torque_command", _times(1.05)),
    ),
    Mutant(
        "quadrant_sign",
        "the sign of the torque in one quadrant",
        substitutions=_of_core("torque_command", _one_quadrant),
    ),
    Mutant(
        "switching_count_stuck",
        "a count of switchings that stays where it is",
        substitutions=_of_core("switching_count", lambda _core, value: value),
    ),
)
"""Defects of control, made in the memory that it shares with the firmware."""
