"""A leg of the inverter with dead time: which of its switches is on, and when that changes.

While neither switch is on the current holds the leg at a rail, through a diode; only where it is so small
that it may reach zero within the dead time is the leg off.
"""

from __future__ import annotations

from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.carrier import NEVER
from benchtool.emulator.machine.inverter import DeadTime

LOW, HIGH, OFF = 0, 1, 2  # modes of a leg: lower or upper switch on, or neither


class Leg(NamedTuple):
    """A leg with dead time: what its switches are told, and until when neither is on."""

    rise: float
    fall: float
    high: bool
    blank: float


@njit
def duration_of(dead_time: DeadTime | None) -> float:
    """Return the dead time in s."""
    return 0.0 if dead_time is None else dead_time.duration


@njit
def told(leg: Leg, time: float, dead_time: float) -> Leg:
    """Return the leg as its switches are told at `time`: a change of it begins a dead time."""
    high = leg.rise <= time < leg.fall
    if high == leg.high:
        return leg
    return Leg(leg.rise, leg.fall, high, time + dead_time)


@njit
def mode_of(leg: Leg, time: float, current: float, small: float) -> int:
    """Return the leg's mode; `small` is the current beyond which none ends within a dead time."""
    if time >= leg.blank:
        return HIGH if leg.high else LOW
    if abs(current) <= small:
        return OFF
    return LOW if current > 0.0 else HIGH


@njit
def next_change(leg: Leg, time: float, mode: int) -> float:
    """Return when the leg's mode may change next: at an edge, or where a dead time ends that has an
    effect."""
    change = next_edge(time, leg.rise, leg.fall)
    if time < leg.blank and mode != (HIGH if leg.high else LOW):
        change = min(change, leg.blank)
    return change


@njit
def next_edge(time: float, rise: float, fall: float) -> float:
    """Return the edge of a leg that comes next after `time`, or never.

    Chosen without a branch, as are the legs' states, because their order is unpredictable to a processor.
    """
    second = fall if fall > time else NEVER
    return rise if rise > time else second
