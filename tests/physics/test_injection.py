"""Currents along a stated angle, and sensors and phases that are not as control takes them for granted."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from benchtool.emulator.control.current_sensors import CalibrationState
from benchtool.emulator.control.stimulus import Quantity
from benchtool.emulator.machine.sensor_truth import CurrentTruth
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import FINE, captured, make_core
from tests.physics.test_cycle import signal, stimulated

ASTRAY = {"encoder_offset": 1.3, "encoder_direction": -1, "omega_current": 1000.0}
A_TURN = 2j * math.pi / 3.0


def vector(of: Callable[[str], float]) -> complex:
    """Amplitude-invariant space vector of three phases."""
    turned = [of(phase) * cmath.exp(A_TURN * k) for k, phase in enumerate("abc")]
    return sum(turned, 0j) * 2.0 / 3.0


def injected(core: Any, amplitude: float, *, turn: float = 0.0) -> None:
    core.command.mode, core.command.pwm_enabled = int(Mode.CURRENT), 1
    stimulated(core, Quantity.CURRENT, amplitude)
    core.stimulus.angle, core.stimulus.turn = math.atan2(0.6, 0.8), turn


@pytest.mark.parametrize("belief", [1.0, 0.4, 3.0])
def test_a_current_takes_its_angle_whatever_the_encoder_says(belief: float) -> None:
    """The inductances believed are off by a factor, and R_s as much: what a nameplate may be wrong by."""
    believed = {"L_d": belief * 9.52e-3, "L_q": belief * 9.52e-3, "R_s": belief * 0.123}
    core = make_core(sensors=FINE, parameters={**ASTRAY, **believed})
    core.load.held = 1
    core.turn_rotor(2.2)
    injected(core, 4.0)
    core.run(400)
    made = vector(lambda phase: signal(core, f"i_{phase}"))
    assert made == pytest.approx(4.0 * (0.8 + 0.6j), abs=4e-3)
    true = complex(core.shaft.i_d, core.shaft.i_q) * cmath.exp(1j * core.shaft.theta_e)
    assert true == pytest.approx(made, abs=1e-3)
    core.stimulus.state = 0
    core.run(400)
    assert abs(vector(lambda phase: signal(core, f"i_{phase}"))) < 4e-3, "none plays"


def test_a_turning_current_takes_the_rotor_along() -> None:
    core = make_core(motor={"friction_Nms": 0.02}, parameters=ASTRAY)
    core.turn_rotor(math.atan2(0.6, 0.8))
    omega_e = 20.0
    injected(core, 4.0, turn=omega_e * 1e-4)
    core.run(15_000)
    before = core.shaft.theta_e
    core.run(10_000)
    assert (core.shaft.theta_e - before) / 1.0 == pytest.approx(omega_e, rel=0.02)


def test_phases_that_changed_places_change_back() -> None:
    """Legs and sensors b and c of the drive are on the motor's phases c and b: a voltage upwards makes a
    current upwards in the signals, and one downwards in the machine."""
    core = make_core(sensors=FINE, parameters={"phase_order": 1, **ASTRAY})
    core.load.held = 1
    core.command.mode, core.command.pwm_enabled = int(Mode.VOLTAGE), 1
    stimulated(core, Quantity.VOLTAGE, 2.0)
    core.run(200)
    made = vector(lambda phase: signal(core, f"i_{phase}"))
    true = complex(core.shaft.i_d, core.shaft.i_q) * cmath.exp(1j * core.shaft.theta_e)
    assert made == pytest.approx(true.conjugate(), abs=1e-3)
    assert cmath.phase(made) == pytest.approx(math.atan2(0.6, 0.8), abs=1e-3)


def test_an_encoder_that_counts_down_gives_the_angle_less_its_offset() -> None:
    core = make_core(sensors=FINE, parameters={"encoder_offset": 0.25, "encoder_direction": -1})
    core.load.held, core.load.omega_m_rad_s = 1, 31.0
    held = captured(core, ["theta_m", "omega_m"], 6000)
    assert held["omega_m"][-1000:].mean() == pytest.approx(-31.0, abs=0.01)
    there = core.shaft.theta_e / core.motor.pole_pairs
    expected = (-there - 0.25) % (2.0 * math.pi)
    assert held["theta_m"][-1] == pytest.approx(expected, abs=1e-5)


def calibrate(core: Any, ticks: int) -> CalibrationState:
    """Start a calibration, as the firmware does, and run it."""
    command = core.command
    command.sum_a = command.sum_b = command.sum_c = 0.0
    command.calibration_left = command.calibration_ticks = ticks
    command.calibration = CalibrationState.RUNNING
    core.run(ticks)
    return CalibrationState(command.calibration)


def _offset(offsets_A: tuple[float, float, float]) -> dict[str, CurrentTruth]:
    return {f"i_{phase}": CurrentTruth(offset_A=each) for phase, each in zip("abc", offsets_A, strict=True)}


def test_offsets_are_the_means_and_gains_multiply_what_is_left() -> None:
    offsets = (0.2, -0.11, 0.05)
    sensors = {**_offset(offsets), "current_noise_A_rms": 0.02, "adc_bits": 12}
    core = make_core(sensors=sensors, parameters={"current_gain_b": 1.5, "i_full_scale": 15.0})
    assert calibrate(core, 4000) is CalibrationState.DONE
    found = [signal(core, f"current_offset_{phase}") for phase in "abc"]
    assert found == pytest.approx(offsets, abs=5.0 * 0.02 / math.sqrt(4000.0))
    means = {name: values.mean() for name, values in captured(core, ["i_a", "i_b", "i_c"], 4000).items()}
    assert list(means.values()) == pytest.approx([0.0, 0.0, 0.0], abs=5.0 * 1.5 * 0.02 / math.sqrt(2000.0))
    assert np.std(captured(core, ["i_b"], 4000)["i_b"]) == pytest.approx(1.5 * 0.02, rel=0.1)


def test_an_offset_beyond_a_tenth_of_the_range_is_none() -> None:
    core = make_core(sensors=_offset((0.1, 1.6, 0.0)), parameters={"i_full_scale": 15.0})
    assert calibrate(core, 10) is CalibrationState.FAILED
    assert [signal(core, f"current_offset_{phase}") for phase in "abc"] == [0.0, 0.0, 0.0]
    core.command.pwm_enabled = 1
    assert calibrate(core, 10) is CalibrationState.IDLE
