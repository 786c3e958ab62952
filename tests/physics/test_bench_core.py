"""The whole core: the paper's operating point, determinism, transducer, counters, power-up."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.emulator.core import Core
from benchtool.emulator.machine.plant import airgap_torque, step
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.transducer import TRANSDUCER, sample
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.errors import ValueRefused
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import captured, make_core

SIGNALS = ["i_a", "i_b", "torque", "psi_s", "omega_m", "theta_m"]


def at_operating_point(**given: Any) -> Core:
    """0.1 of rated speed against 0.65 Nm, settled."""
    core = make_core(**given)
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 15.71
    core.load.torque_Nm = 0.65
    core.run(15_000)
    return core


def test_torque_ripple_at_the_papers_operating_point() -> None:
    core = at_operating_point(sensors={"i_full_scale_A": 12.5})
    signals = captured(core, SIGNALS, 5000)
    assert np.ptp(signals["torque"]) <= 0.06
    assert signals["torque"].mean() == pytest.approx(0.65, abs=0.002)
    assert signals["omega_m"].mean() == pytest.approx(15.71, abs=0.02)
    assert core.command.trip == 0


def noisy_run(parts: list[int]) -> tuple[NDArray[np.uint32], bytes]:
    core = make_core(sensors={"current_noise_A_rms": 0.015}, seed=7)
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 40.0
    core.capture.arm(names=SIGNALS, rows=6000)
    for ticks in parts:
        assert core.run(ticks) == ticks
    return core.capture.rows(), core.memory.tobytes()


def test_same_seed_is_bit_identical_however_the_ticks_are_run() -> None:
    rows, memory = noisy_run([6000])
    again, memory_again = noisy_run([1, 2, 3, 94, 3900, 96, 1, 1903])
    assert np.array_equal(rows, again)
    assert memory == memory_again


def test_another_seed_is_another_run() -> None:
    cores = [at_operating_point(sensors={"current_noise_A_rms": 0.015}, seed=seed) for seed in (1, 2)]
    assert cores[0].memory.tobytes() != cores[1].memory.tobytes()


def test_transducer_agrees_with_dense_integration() -> None:
    machine = MotorTruth(
        pole_pairs=4,
        R_s_ohm=0.123,
        L_d_H=5e-3,
        L_q_H=9e-3,
        psi_r_Wb=0.1685,
        J_kgm2=13e-4,
        psi_5_Wb=2e-3,
    ).machine()
    h, T_load = 4e-5, 0.5
    start = place(-3.0, 8.0, 628.0, 0.2)
    record, torque = np.zeros(1, TRANSDUCER), np.zeros((20, 1))
    record[0].recording, record[0].samples_per_tick, record[0].spacing = 1, 20, h / 20
    end = step(start, 60.0, -40.0, h, machine, T_load)
    sample(0.0, h, start, end, 60.0, -40.0, machine, T_load, record[0], torque)
    x, dense = start, []
    for _ in range(20):
        dense.append(airgap_torque(x.i_d, x.i_q, x.theta_e, machine))
        for _ in range(10):
            x = step(x, 60.0, -40.0, h / 200, machine, T_load)
    assert record[0].filled == 20
    assert np.abs(torque[:, 0] - dense).max() < 1e-6


def test_transducer_block_is_on_the_drives_time_base() -> None:
    core = at_operating_point()
    core.transducer.start(100)
    core.run(150)
    block = core.transducer.block()
    assert block.names == ("torque_transducer",)
    assert block.data.shape == (2000, 1)
    assert block.first_tick == 15_000 * 20
    assert block.sample_rate_Hz == pytest.approx(200e3)
    assert block.first_tick * block.tick_s == pytest.approx(1.5)
    assert block.data.mean() == pytest.approx(0.65, abs=0.02)


def test_transducer_meets_the_estimate_at_the_ticks() -> None:
    core = at_operating_point(sensors={"adc_bits": 24})
    core.transducer.start(201)
    estimate = captured(core, ["torque"], 200)["torque"]
    core.run(1)
    true = core.transducer.block().data[20::20, 0]  # the first estimate is of the tick after the start
    assert estimate == pytest.approx(true, abs=2e-3)  # the encoder's step


def test_transducer_stops_and_refuses() -> None:
    core = make_core()
    core.transducer.start(50)
    core.run(10)
    core.transducer.stop()
    core.run(10)
    assert len(core.transducer.block().data) == 200
    with pytest.raises(ValueRefused, match="0 ticks"):
        core.transducer.start(0)


def test_power_up_is_at_rest() -> None:
    core = make_core()
    assert int(core.memory["tick"][0]) == 0
    assert core.run(10) == 10
    assert int(core.memory["tick"][0]) == 10
    assert float(core.memory["torque"][0]) == pytest.approx(0.0, abs=1e-9)
    assert (core.shaft.i_d, core.shaft.omega_m, core.shaft.theta_e) == (0.0, 0.0, 0.0)


def test_every_leg_turns_on_once_a_period() -> None:
    core = at_operating_point()
    before = int(core.memory["switching_count"][0])
    core.run(1000)
    assert int(core.memory["switching_count"][0]) - before == 3000


def test_load_pulls_an_idle_shaft_backwards_and_a_held_one_turns_as_told() -> None:
    core = make_core()
    core.load.torque_Nm = 0.131
    core.run(100)
    assert core.shaft.omega_m == pytest.approx(-0.131 / 13.1e-4 * 0.01)
    core.load.held, core.load.omega_m_rad_s = 1, 20.0
    core.run(1000)
    assert core.shaft.omega_m == 20.0
    assert float(core.memory["omega_m"][0]) == pytest.approx(20.0, abs=0.1)


def test_turned_rotor_is_where_it_was_put() -> None:
    core = make_core(sensors={"encoder_offset_rad": 0.3}, parameters={"encoder_offset": 0.3})
    core.turn_rotor(2.0)
    core.run(1)
    assert float(core.memory["theta_m"][0]) == pytest.approx(0.5, abs=3.2e-4)


@pytest.mark.parametrize("change", [{"J_kgm2": 0.0}, {"R_s_ohm": -1.0}, {"psi_5_Wb": float("nan")}])
def test_impossible_motors_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(ValueRefused, match=next(iter(change))):
        make_core(motor=change)


def test_impossible_inverters_are_refused() -> None:
    with pytest.raises(ValueRefused, match="u_dc_V"):
        make_core(inverter={"u_dc_V": 0.0})


def test_a_machine_much_faster_than_a_pwm_period_is_integrated_to_rounding() -> None:
    """R_s T_s / L = 2: one step per period would be off by a quarter. Leg a high for a whole period."""
    core = make_core(motor={"R_s_ohm": 1.0, "L_d_H": 50e-6, "L_q_H": 50e-6}, inverter={"u_dc_V": 12.0})
    core.load.held = 1
    core.command.pwm_enabled = 1
    core._controls["gated"], core._controls["duty_a"] = 1, 1.0
    core.run(1)
    assert core.shaft.i_d == pytest.approx(2.0 / 3.0 * 12.0 * -math.expm1(-2.0), rel=1e-6)
