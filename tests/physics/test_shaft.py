"""Dry friction without stiffness: closed forms, and scipy with logic of its own for sticking and sliding."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.coefficients import fastest_rate, holding
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.steps import advance
from benchtool.emulator.machine.truth import MotorTruth
from tests.physics.paper_machine import make_core

RUBBING = MotorTruth(
    pole_pairs=4,
    R_s_ohm=0.5,
    L_d_H=2e-3,
    L_q_H=2e-3,
    psi_r_Wb=0.05,
    J_kgm2=2e-4,
    friction_Nms=1e-4,
    coulomb_Nm=0.03,
    breakaway_Nm=0.05,
    stribeck_rad_s=2.0,
    cogging_Nm=0.08,
    cogging_order=24,
)


def coasting(omega_m: float, theta_m: float, T_load: float, duration: float) -> tuple[float, float]:
    """Speed and angle of the shaft with open terminals, by events where it stops and begins to slide."""
    m = RUBBING

    def others(theta: float) -> float:
        return -T_load - 0.08 * math.sin(24 * theta)

    def rates(_: float, y: NDArray[np.float64]) -> list[float]:
        rubbing = m.coulomb_Nm + (m.breakaway_Nm - m.coulomb_Nm) * math.exp(-((y[0] / m.stribeck_rad_s) ** 2))
        return [(others(y[1]) - m.friction_Nms * y[0] - sign * rubbing) / m.J_kgm2, y[0]]

    def stops(_: float, y: NDArray[np.float64]) -> float:
        return float(y[0]) + sign * 1e-12

    stops.terminal = True  # type: ignore[attr-defined]
    time, y, sign = 0.0, np.array([omega_m, theta_m]), 0.0
    while time < duration:
        if y[0] == 0.0 and abs(others(y[1])) <= m.breakaway_Nm:
            break
        sign = math.copysign(1.0, y[0] if y[0] != 0.0 else others(y[1]))
        way = solve_ivp(rates, (time, duration), y, "DOP853", events=stops, rtol=1e-12, atol=1e-13)
        time, y = way.t[-1], way.y[:, -1]
        if way.status == 1:
            y[0] = 0.0
    return float(y[0]), float(y[1])


@pytest.mark.parametrize(
    ("omega_m", "theta_m", "T_load"),
    [
        (20.0, 0.0, 0.0),
        (5.0, 0.1, 0.06),
        (0.0, 0.03, 0.0),
        (0.0, 0.0, 0.045),
        (0.0, 0.0, 0.3),
        (-8.0, 0.02, 0.02),
    ],
    ids=["coasts to rest", "turned back", "cogs to rest", "sticks", "breaks away", "backwards"],
)
@pytest.mark.parametrize("duration", [0.004, 0.05])
def test_sticking_and_sliding_agree_with_scipy(
    omega_m: float, theta_m: float, T_load: float, duration: float
) -> None:
    free = holding(RUBBING.machine(), False, True)
    x = advance(place(0.0, 0.0, 4 * omega_m, 4 * theta_m), 0.0, 0.0, duration, 0.01, free, T_load)
    expected = coasting(omega_m, theta_m, T_load, duration)
    assert (x.omega_e / 4, x.theta_e / 4) == pytest.approx(expected, abs=2e-6)


@pytest.mark.parametrize(
    ("torque", "moves"), [(0.0499, False), (-0.0499, False), (0.0501, True), (-0.0501, True)]
)
def test_a_shaft_sticks_up_to_its_breakaway_torque_and_not_beyond(torque: float, moves: bool) -> None:
    free = holding(RUBBING.machine(), False, True)
    x = advance(place(0.0, 0.0, 0.0, 0.0), 0.0, 0.0, 1e-3, 0.01, free, torque)
    assert (x.theta_e != 0.0) == moves
    assert x.omega_e * torque < 0.0 or not moves


def test_dry_friction_needs_no_finer_steps() -> None:
    """A small servo: smoothed around standstill, its friction alone made a process of 2e5 1/s."""
    smooth = MotorTruth(pole_pairs=4, R_s_ohm=1.0, L_d_H=1e-3, L_q_H=1e-3, psi_r_Wb=0.01, J_kgm2=1e-6)
    dry = MotorTruth(
        pole_pairs=4, R_s_ohm=1.0, L_d_H=1e-3, L_q_H=1e-3, psi_r_Wb=0.01, J_kgm2=1e-6, coulomb_Nm=0.01
    )
    rest = place(0.0, 0.0, 0.0, 0.0)
    assert fastest_rate(dry.machine(), rest) == fastest_rate(smooth.machine(), rest)


@pytest.mark.parametrize("load", [0.05, -0.05, 0.05 + 1e-6, -0.05 - 1e-6])
def test_a_shaft_at_its_breakaway_torque_does_not_stop_time(load: float) -> None:
    """A current that is zero and a shaft that comes to rest in the same step once waited for each other."""
    core = make_core(
        motor={"coulomb_Nm": 0.05, "breakaway_Nm": 0.05},
        inverter={"dead_time_s": 1e-6, "device_drop_V": 0.7},
    )
    core.command.pwm_enabled = 1
    for omega_e in (1e-3, -1e-3, 1.8e-17, -1.8e-17):
        core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m = 0.0, 0.0, omega_e / 4.0
        core.load.torque_Nm = load
        assert core.run_with(run_ticks, 4) == 4
