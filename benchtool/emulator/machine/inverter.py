"""The two-level inverter: leg voltages from switch states.

From each change of what a leg is told (`carrier`), be it within a period or where one meets the next, neither
of its switches is on for the dead time, and the current holds the leg: out of the leg (i > 0) through the
lower diode, so that it goes high late; into the leg through the upper diode, so that it goes low late. A
conducting device takes a constant voltage against its current; what it takes in proportion to the current is
part of the machine's resistance.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.carrier import DoubleUpdate
from benchtool.emulator.machine.dc_link import DcLink
from benchtool.emulator.machine.energies import Accounts
from benchtool.emulator.machine.heat import Heat
from benchtool.emulator.machine.sampling import Sampling
from benchtool.emulator.machine.state import State, stationary_currents

SQRT3 = math.sqrt(3.0)


class DeadTime(NamedTuple):
    """Time after each change of a leg in which neither of its switches is on, in s."""

    duration: float


class Timer(NamedTuple):
    """Steps of the PWM timer in the whole range of a duty."""

    steps: float


class Devices(NamedTuple):
    """Forward voltage of a conducting switch or diode, in V."""

    drop: float


class PowerStage(NamedTuple):
    """True coefficients; `u_dc` is the voltage behind the dc link's resistance `R_dc`.

    `T_s` is the control period, and the PWM period unless there is a double update. `metered` says that what
    the dc link is drawn matters. `sampling` is there where the timer triggers the converter of the currents
    within the period, or their sensors lag.
    """

    T_s: float
    u_dc: float
    R_dc: float
    metered: bool
    accounts: Accounts | None
    heat: Heat | None
    double_update: DoubleUpdate | None
    dead_time: DeadTime | None
    timer: Timer | None
    devices: Devices | None
    link: DcLink | None
    sampling: Sampling | None


@njit
def phase_currents(x: State) -> tuple[float, float, float]:
    """Return the currents of the three phases, out of the legs into the motor."""
    i_alpha, i_beta = stationary_currents(x)
    return inverse_clarke(i_alpha, i_beta)


@njit
def clarke(a: float, b: float, c: float) -> tuple[float, float]:
    """Return the amplitude-invariant alpha and beta of three phase quantities."""
    return (2.0 * a - b - c) * (1.0 / 3.0), (b - c) * (1.0 / SQRT3)


@njit
def inverse_clarke(alpha: float, beta: float) -> tuple[float, float, float]:
    """Return the three phases of a vector."""
    along, across = -0.5 * alpha, (0.5 * SQRT3) * beta
    return alpha, along + across, along - across


@njit
def quantised(timer: Timer | None, duty: float) -> float:
    """Return the duty that the timer makes of one that is asked for."""
    if timer is None:
        return duty
    return math.floor(duty * timer.steps + 0.5) / timer.steps


@njit
def forward_voltage(devices: Devices | None) -> float:
    """Return the voltage that a conducting device takes."""
    return 0.0 if devices is None else devices.drop


@njit
def leg_voltages(
    high_a: bool, high_b: bool, high_c: bool, x: State, u_dc: float, stage: PowerStage
) -> tuple[float, float]:
    """Return the stator voltage (alpha, beta) of a switch state, less the drop of the conducting devices."""
    v_a = u_dc if high_a else 0.0
    v_b = u_dc if high_b else 0.0
    v_c = u_dc if high_c else 0.0
    return _less_drops(stage.devices, v_a, v_b, v_c, x)


@njit
def _less_drops(devices: Devices | None, v_a: float, v_b: float, v_c: float, x: State) -> tuple[float, float]:
    if devices is None:
        return clarke(v_a, v_b, v_c)
    i_a, i_b, i_c = phase_currents(x)
    v_a -= math.copysign(devices.drop, i_a)
    v_b -= math.copysign(devices.drop, i_b)
    v_c -= math.copysign(devices.drop, i_c)
    return clarke(v_a, v_b, v_c)
