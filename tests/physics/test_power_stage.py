"""Inverter and free-wheeling: edges, dead time, device drop, dc-link sag, currents running out."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.emulator.machine.carrier import NEVER, falling_edge, rising_edge
from benchtool.emulator.machine.diodes import freewheel
from benchtool.emulator.machine.inverter import leg_voltages, phase_currents
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.transducer import TRANSDUCER
from benchtool.emulator.machine.truth import InverterTruth, MotorTruth
from tests.physics.paper_machine import FINE, captured, make_core

STAGE = InverterTruth(u_dc_V=100.0, device_drop_V=1.5).power_stage(1e-4)
MOTOR = MotorTruth(pole_pairs=2, R_s_ohm=0.5, L_d_H=2e-3, L_q_H=3e-3, psi_r_Wb=0.05, J_kgm2=1e-3)


def high_time(duty: float, current: float) -> float:
    """How long leg a is high, from what a large inductance makes of a period with b and c low."""
    core = make_core(
        motor={"L_d_H": 10.0, "L_q_H": 10.0, "R_s_ohm": 0.0, "psi_r_Wb": 0.0},
        inverter={"u_dc_V": 100.0, "dead_time_s": 2e-6},
    )
    core.shaft.i_d, core.command.pwm_enabled = current, 1
    core.memory["omega_m_trip"] = 1e9
    for duty_a in (duty, 0.0):  # the second has what reaches beyond the first
        core._controls["gated"], core._controls["duty_a"] = 1, duty_a
        core._controls["duty_b"] = core._controls["duty_c"] = 0.0
        core.run(1)
    return float(core.shaft.i_d - current) * 10.0 / (2.0 / 3.0 * 100.0)


def test_edges_are_centred_in_the_period() -> None:
    assert rising_edge(0.3, 1e-4) == pytest.approx(35e-6)
    assert falling_edge(0.3, 1e-4) == pytest.approx(65e-6)


@pytest.mark.parametrize(("current", "change"), [(3.0, -2e-6), (-3.0, 2e-6)])
def test_dead_time_shifts_the_mean_voltage_against_the_current(current: float, change: float) -> None:
    """The known error of a leg: -sign(i) u_dc t_dead / T_s; near duty 1 it reaches into the next period."""
    for duty in (0.1, 0.5, 0.9, 0.97, 0.99):
        assert high_time(duty, current) == pytest.approx(duty * 1e-4 + change, rel=1e-6)


def test_no_pulse_for_duty_zero_and_no_edge_for_duty_one() -> None:
    assert rising_edge(0.0, 1e-4) == NEVER
    assert rising_edge(1.0, 1e-4) == 0.0
    assert falling_edge(1.0, 1e-4) == NEVER
    assert high_time(0.0, 5.0) == pytest.approx(0.0, abs=1e-12)
    assert high_time(0.01, 5.0) == pytest.approx(0.0, abs=1e-12)  # shorter than the dead time


def test_devices_drop_against_their_currents() -> None:
    x = place(6.0, 0.0, 0.0, 0.0)  # i_a = 6, i_b = i_c = -3
    u_alpha, u_beta = leg_voltages(True, False, False, x, 100.0, STAGE)
    assert u_alpha == pytest.approx(2 / 3 * 100.0 - 4 / 3 * 1.5)
    assert u_beta == pytest.approx(0.0, abs=1e-12)


def test_dead_time_in_the_loop_costs_current_and_its_compensation_restores_it() -> None:
    """At held standstill the d current settles where the resistance takes the mean voltage that is left."""
    means = []
    for dead_time, compensation in ((0.0, 0.0), (3e-6, 0.0), (3e-6, 3e-6)):
        core = make_core(
            inverter={"dead_time_s": dead_time},
            sensors=FINE,
            parameters={"dead_time_compensation": compensation, "psi_s_command": 0.2},
        )
        core.load.held = 1
        core.memory["torque_command"] = 3.0
        core.command.pwm_enabled = 1
        core.run(2000)
        means.append(captured(core, ["torque"], 2000)["torque"].mean())
    ideal, spoiled, restored = (abs(mean - 3.0) for mean in means)
    assert ideal < 0.005
    assert spoiled > 5 * ideal
    assert restored < 0.3 * spoiled


def test_dc_link_sags_by_resistance_times_mean_current() -> None:
    core = make_core(inverter={"dc_link_R_ohm": 0.5}, sensors=FINE)
    core.load.held, core.load.omega_m_rad_s = 1, 50.0
    core.memory["torque_command"] = 4.0
    core.command.pwm_enabled = 1
    core.run(3000)
    signals = captured(core, ["u_dc", "i_d", "i_q"], 3000)
    copper = 1.5 * 0.123 * np.mean(signals["i_d"] ** 2 + signals["i_q"] ** 2)
    u_dc = signals["u_dc"].mean()
    power = u_dc * (122.5 - u_dc) / 0.5
    assert power == pytest.approx(4.0 * 50.0 + copper, rel=0.01)


@pytest.mark.parametrize("direction", np.linspace(0.1, 6.2, 9))
def test_currents_run_out_through_the_diodes_and_stay_out(direction: float) -> None:
    x = place(8.0 * math.cos(direction), 8.0 * math.sin(direction), 200.0, 0.3)
    silent = np.zeros(1, TRANSDUCER)[0]
    largest = 8.0
    for _ in range(20):
        x, _ = freewheel(x, 100.0, STAGE, MOTOR.machine(), 0.0, silent, np.zeros((0, 1)))
        now = max(map(abs, phase_currents(x)))
        assert now <= largest
        largest = now
    assert (x.i_d, x.i_q) == (0.0, 0.0)
    assert x.omega_e > 100.0


def test_free_wheeling_time_is_flux_over_diode_voltage() -> None:
    """One phase against two: 2/3 (u_dc + 2 drop) against L di/dt at standstill."""
    motor = MotorTruth(pole_pairs=2, R_s_ohm=0.0, L_d_H=2e-3, L_q_H=2e-3, psi_r_Wb=0.0, J_kgm2=1.0)
    x = place(3.0, 0.0, 0.0, 0.0)
    silent = np.zeros(1, TRANSDUCER)[0]
    stage = STAGE._replace(T_s=5e-5)
    x, _ = freewheel(x, 100.0, stage, motor.machine(), 0.0, silent, np.zeros((0, 1)))
    assert x.i_d == pytest.approx(3.0 - 2 / 3 * 103.0 / 2e-3 * 5e-5, rel=1e-9)
