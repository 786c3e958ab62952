"""The carrier of the PWM: when a leg is told to be high within a control period.

With single update a control period is a PWM period, and its pulse lies in the middle. With double update
control runs at both ends of a PWM period, at the valley and at the peak of a triangular carrier: in the first
half a leg goes high and stays so, in the second it goes low, and each half has a duty of its own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit

NEVER = math.inf


class DoubleUpdate(NamedTuple):
    """The PWM period, in s, where it is two control periods; it begins with an even tick."""

    T_pwm: float


@njit
def rising_edge(duty: float, T_s: float) -> float:
    """Return when a leg is told to go high, in s from the start of the period; never for duty 0."""
    if duty <= 0.0:
        return NEVER
    return 0.5 * (1.0 - duty) * T_s if duty < 1.0 else 0.0


@njit
def falling_edge(duty: float, T_s: float) -> float:
    """Return when a leg that has gone high is told to go low, in s from the start of the period."""
    return 0.5 * (1.0 + duty) * T_s if duty < 1.0 else NEVER


@njit
def pulse(update: DoubleUpdate | None, duty: float, T_s: float, tick: int) -> tuple[float, float]:
    """Return the rising and the falling edge of a leg in the control period that begins at `tick`."""
    if update is None:
        return rising_edge(duty, T_s), falling_edge(duty, T_s)
    if duty <= 0.0:
        return NEVER, NEVER
    if tick % 2 == 0:
        return (1.0 - duty) * T_s, NEVER
    return 0.0, duty * T_s if duty < 1.0 else NEVER


@njit
def turns_on(update: DoubleUpdate | None, duty: float, tick: int, was_high: int) -> int:
    """Return 1 if the leg's upper switch turns on in a control period of this duty, else 0."""
    if update is None:
        return 1 if duty > 0.0 and (duty < 1.0 or was_high == 0) else 0
    stays_high = was_high != 0 and (duty >= 1.0 or tick % 2 != 0)
    return 1 if duty > 0.0 and not stays_high else 0


@njit
def ends_high(update: DoubleUpdate | None, duty: float, tick: int) -> bool:
    """Return whether the leg is told to be high at the end of a control period of this duty."""
    if update is None:
        return duty >= 1.0
    return duty > 0.0 if tick % 2 == 0 else duty >= 1.0
