"""A PWM period of real legs by its mean and the moments of its ripple: dead time and forward voltages.

`averaging` takes a period's pulses for centred and its mean voltage for known. Those of real legs are
neither: a dead time moves an edge by the sign of the current, a forward voltage turns with it, and a current
that comes to zero rests there where no device carries it on. So one step under the mean voltage of currents
that keep their signs gives a smooth course of the currents (`course`), along which the legs are followed from
one change to the next (`changes`).

The course decides only when a current is zero, where little hangs on it: an error of the current makes one of
the voltage by the share that two forward voltages have in what drives it.
"""

from __future__ import annotations

from typing import Any

from benchtool.emulator.jit import called, njit
from benchtool.emulator.machine.changes import followed, sign_of
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.course import course_of
from benchtool.emulator.machine.inverter import PowerStage, clarke, forward_voltage, phase_currents
from benchtool.emulator.machine.legs import duration_of
from benchtool.emulator.machine.plant import step_through
from benchtool.emulator.machine.state import State


@called
def pulsed(
    x: State,
    duties: tuple[float, float, float],
    rise: tuple[float, float, float],
    fall: tuple[float, float, float],
    shaft: Any,
    stage: PowerStage,
    machine: Machine,
    T_load: float,
) -> tuple[State, float, bool]:
    """Integrate one PWM period, with what dead time and devices make of pulses with these edges.

    Returns the charge drawn from the dc link as well, in As, and whether the period could be computed so:
    where two currents rest at zero at once it is to be integrated from edge to edge, and nothing has changed.
    """
    T_s, u_dc = stage.T_s, shaft.u_dc
    dead_time, drop = duration_of(stage.dead_time), forward_voltage(stage.devices)
    i_a, i_b, i_c = phase_currents(x)
    lost = dead_time / T_s
    mean_alpha, mean_beta = clarke(
        _mean(duties[0], i_a, u_dc, drop, lost),
        _mean(duties[1], i_b, u_dc, drop, lost),
        _mean(duties[2], i_c, u_dc, drop, lost),
    )
    middle, end = step_through(x, mean_alpha, mean_beta, T_s, machine, T_load)
    course = course_of(x, middle, end, T_s, machine)
    return followed(x, middle, end, course, mean_alpha, mean_beta, rise, fall, shaft, stage, machine, T_load)


@njit
def _mean(duty: float, current: float, u_dc: float, drop: float, lost: float) -> float:
    """Return the mean potential of a leg whose current keeps its sign; `lost` is the dead time's share."""
    sign = sign_of(current)
    if duty <= 0.0 or duty >= 1.0:
        return u_dc * duty - sign * drop
    return u_dc * (duty - sign * lost) - sign * drop
