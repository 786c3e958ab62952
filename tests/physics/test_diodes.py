"""Dead time and diodes, against an inverter of another formulation: see `alpha_beta`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from tests.physics.alpha_beta import OFF, Reference, centred, gates
from tests.physics.paper_machine import FINE, captured, make_core

T_S = 1e-4
SALIENT: dict[str, Any] = {"pole_pairs": 3, "R_s_ohm": 0.3, "L_d_H": 4e-3, "L_q_H": 9e-3, "psi_r_Wb": 0.12}
WIDE: dict[str, Any] = {**FINE, "i_full_scale_A": 1000.0, "u_full_scale_V": 2000.0}
NO_TRIP: dict[str, Any] = {"i_trip": 900.0, "omega_m_trip": 1e5, "u_dc_min": 0.0, "u_dc_max": 2000.0}


# Parts that are there, and have no effect unless a test gives them one. The few periods here are run by the
# plain functions, which need no kernel.
IDLE: dict[str, Any] = {"dead_time_s": 1e-15, "device_drop_V": 1e-9, "timer_Hz": 1e13}


def core_with(motor: dict[str, Any], inverter: dict[str, Any], i_d: float, i_q: float, omega: float) -> Core:
    core = make_core(motor=motor, inverter={**IDLE, **inverter}, sensors=WIDE, parameters=NO_TRIP)
    core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m = i_d, i_q, omega
    core.command.pwm_enabled = 1
    return core


def reference_of(motor: dict[str, Any], **given: Any) -> Reference:
    return Reference(
        p=motor["pole_pairs"],
        R=motor["R_s_ohm"],
        L_d=motor["L_d_H"],
        L_q=motor["L_q_H"],
        harmonics={1: motor["psi_r_Wb"]},
        J=motor["J_kgm2"],
        **given,
    )


def run_period(core: Core, duties: np.ndarray[Any, Any]) -> None:
    core._controls["gated"] = 1
    for name, duty in zip(("duty_a", "duty_b", "duty_c"), duties, strict=True):
        core._controls[name] = duty
    assert core.run_with(run_ticks, 1) == 1


@pytest.mark.parametrize("seed", range(3))
def test_dead_time_agrees_with_another_inverter_over_any_duties(seed: int) -> None:
    """Duties of 0 and 1 among them, pulses shorter than the dead time, and currents about zero."""
    rng = np.random.default_rng(seed)
    duties = rng.choice([0.0, 1.0, 0.004, 0.5, 0.985, 0.997, 0.3], (8, 3))
    motor = {**SALIENT, "J_kgm2": 8e-4}
    i_d, i_q, omega = rng.uniform(-0.3, 0.3), rng.uniform(-0.3, 0.3), 40.0
    dead_time, u_dc, drop = 2e-6, 60.0, 1.2
    core = core_with(
        motor, {"u_dc_V": u_dc, "dead_time_s": dead_time, "device_drop_V": drop}, i_d, i_q, omega
    )
    for row in duties:
        run_period(core, row)
    reference = reference_of(motor, u_dc=u_dc, drop=drop)
    end = len(duties) * T_S
    legs = [gates(centred(list(duties[:, k]), T_S), end, dead_time) for k in range(3)]
    y = reference.follow(reference.state(i_d, i_q, omega, 0.0), legs, end)
    expected = (*reference.dq(y), y[2], y[3])
    found = (core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m, core.shaft.theta_e)
    assert found == pytest.approx(expected, abs=1e-5)


def test_rectification_agrees_with_another_inverter() -> None:
    motor = {**SALIENT, "J_kgm2": 8e-4}
    core = core_with(motor, {"u_dc_V": 60.0, "device_drop_V": 0.8}, 0.0, 0.0, 300.0)
    core.command.pwm_enabled = 0
    core.load.held, core.load.omega_m_rad_s = 1, 300.0
    reference = reference_of(motor, u_dc=60.0, drop=0.8, held=True)
    y = reference.state(0.0, 0.0, 300.0, 0.0)
    for k in range(15):
        core.run_with(run_ticks, 1)
        y = reference.run(y, (k * T_S, (k + 1) * T_S), (OFF, OFF, OFF))
        assert (core.shaft.i_d, core.shaft.i_q) == pytest.approx(reference.dq(y), abs=5e-3)
    assert abs(core.shaft.i_d) > 2.0


def test_a_machine_held_at_rated_speed_with_the_stage_off_brakes() -> None:
    """183 V of line EMF on 122.5 V: 10.2 A peak and -7.7 Nm, where nothing that conducts would say 0."""
    core = make_core(sensors=WIDE, parameters=NO_TRIP)
    core.load.held, core.load.omega_m_rad_s = 1, 157.1
    core.run(3000)
    core.transducer.start(1000)
    currents = captured(core, ["i_a", "i_b", "i_c"], 1000)
    assert max(np.abs(each).max() for each in currents.values()) == pytest.approx(10.2, abs=0.05)
    torque = core.transducer.block().data[:, 0]
    assert torque.mean() == pytest.approx(-7.7, abs=0.05)


@pytest.mark.parametrize("omega_m", [100.0, -100.0])
def test_below_the_dc_link_nothing_flows(omega_m: float) -> None:
    core = make_core(sensors=WIDE, parameters=NO_TRIP)
    core.load.held, core.load.omega_m_rad_s = 1, omega_m
    core.run(500)
    assert (core.shaft.i_d, core.shaft.i_q) == (0.0, 0.0)


def test_dead_time_acts_where_one_period_meets_the_next() -> None:
    """A leg that changes with every period, as dtc and fcs_mpc have it, loses a dead time at each rise."""
    lost = {}
    for dead_time in (1e-15, 2e-6):
        core = core_with(
            {"L_d_H": 1.0, "L_q_H": 1.0, "R_s_ohm": 0.0, "psi_r_Wb": 0.0},
            {"u_dc_V": 100.0, "dead_time_s": dead_time},
            5.0,
            0.0,
            0.0,
        )
        for k in range(100):
            run_period(core, np.array([k % 2, 0.0, 0.0]))
        lost[dead_time] = (core.shaft.i_d - 5.0) / (2.0 / 3.0 * 100.0)
    assert lost[1e-15] == pytest.approx(50 * T_S)
    assert lost[2e-6] == pytest.approx(50 * (T_S - 2e-6))


def test_current_that_reaches_zero_in_a_dead_time_stays_there() -> None:
    motor = {"L_d_H": 1e-4, "L_q_H": 1e-4, "psi_r_Wb": 0.0}
    core = core_with(motor, {"u_dc_V": 100.0, "dead_time_s": 9e-6}, 0.5, 0.0, 0.0)
    run_period(core, np.array([0.0, 1.0, 1.0]))  # b and c are told to rise: 9 us of diodes, 0.5 A for 1 us
    peak = core.shaft.i_d
    assert peak == pytest.approx(-2.0 / 3.0 * 100.0 * (T_S - 9e-6) / 1e-4, rel=0.1)


def test_duties_are_of_the_timers_steps() -> None:
    """10 MHz up and down in 100 us are 500 steps; 0.7013 becomes 351 / 500."""
    core = core_with(
        {"L_d_H": 1.0, "L_q_H": 1.0, "R_s_ohm": 0.0, "psi_r_Wb": 0.0},
        {"u_dc_V": 100.0, "timer_Hz": 10e6},
        0.0,
        0.0,
        0.0,
    )
    run_period(core, np.array([0.7013, 0.0, 0.0]))
    assert core.shaft.i_d == pytest.approx(2.0 / 3.0 * 100.0 * T_S * 351 / 500, rel=1e-9)


def test_devices_resist_in_every_phase() -> None:
    core = core_with(
        {"L_d_H": 1e-3, "L_q_H": 1e-3, "R_s_ohm": 0.1}, {"on_resistance_ohm": 0.05}, 4.0, 0.0, 0.0
    )
    for _ in range(10):
        run_period(core, np.array([0.5, 0.5, 0.5]))
    assert core.shaft.i_d == pytest.approx(4.0 * math.exp(-0.15 / 1e-3 * 1e-3), rel=1e-6)
