"""Shunts in the lower legs: a current is seen only while the lower switch of its leg is on.

A shunt's amplifier settles for some time after its lower switch has turned on. What a drive with three such
shunts does is emulated with them: a phase that cannot be read is reconstructed from the other two, as the
three add up to zero; where more than one cannot be read, each of them keeps the value that it read last.
With the power stage off a shunt sees what its lower diode carries, which is current out of the leg alone, and
no phase is reconstructed.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.carrier import falling_edge, rising_edge
from benchtool.emulator.machine.inverter import PowerStage, quantised


class Shunts(NamedTuple):
    """`settling` in s from the command that turns a lower switch on, dead time included; `moment` in s of
    the PWM period at which they are read."""

    settling: float
    moment: float


@njit
def through_shunts(
    shunts: Shunts | None, switching: bool, i_a: float, i_b: float, i_c: float
) -> tuple[float, float, float]:
    """Return the currents of the shunts of which those that are settled are read."""
    if shunts is None or switching:
        return i_a, i_b, i_c
    return max(i_a, 0.0), max(i_b, 0.0), max(i_c, 0.0)


@njit
def readable(
    shunts: Shunts | None, switching: bool, control: Any, stage: PowerStage, sensor: Any
) -> tuple[bool, bool, bool]:
    """Return which phases can be read in this period; to be called once in each.

    `sensor` keeps how long each lower switch was told to be on when the period ends.
    """
    if shunts is None:
        return True, True, True
    if not switching:
        sensor.low_a, sensor.low_b, sensor.low_c = 0.0, 0.0, 0.0
        return True, True, True
    duty_a = quantised(stage.timer, control.duty_a)
    duty_b = quantised(stage.timer, control.duty_b)
    duty_c = quantised(stage.timer, control.duty_c)
    low_a = _low_for(duty_a, shunts.moment, stage.T_s, sensor.low_a)
    low_b = _low_for(duty_b, shunts.moment, stage.T_s, sensor.low_b)
    low_c = _low_for(duty_c, shunts.moment, stage.T_s, sensor.low_c)
    sensor.low_a = _low_for(duty_a, stage.T_s, stage.T_s, sensor.low_a)
    sensor.low_b = _low_for(duty_b, stage.T_s, stage.T_s, sensor.low_b)
    sensor.low_c = _low_for(duty_c, stage.T_s, stage.T_s, sensor.low_c)
    return low_a >= shunts.settling, low_b >= shunts.settling, low_c >= shunts.settling


@njit
def _low_for(duty: float, time: float, T_s: float, at_start: float) -> float:
    """Return how long a lower switch has been told to be on at `time`; `at_start` is that at time 0."""
    rise, fall = rising_edge(duty, T_s), falling_edge(duty, T_s)
    if time <= rise:
        return at_start + time
    return max(time - fall, 0.0)


@njit
def reconstructed(
    shunts: Shunts | None,
    seen: tuple[bool, bool, bool],
    reading: tuple[float, float, float],
    last: tuple[float, float, float],
) -> tuple[float, float, float]:
    """Return the three readings that the drive goes on with, where `last` are those of the tick before."""
    if shunts is None:
        return reading
    see_a, see_b, see_c = seen
    i_a, i_b, i_c = reading
    if see_b and see_c:
        return i_a if see_a else -i_b - i_c, i_b, i_c
    if see_a and see_c:
        return i_a, -i_a - i_c, i_c
    if see_a and see_b:
        return i_a, i_b, -i_a - i_b
    return i_a if see_a else last[0], i_b if see_b else last[1], i_c if see_c else last[2]
