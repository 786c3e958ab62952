"""Shunts in the lower legs: which can be read, by a walk along the commands of the legs."""

from __future__ import annotations

import cmath
import math

import numpy as np
import pytest

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.shunts import Shunts, readable, reconstructed
from benchtool.emulator.machine.truth import InverterTruth
from benchtool.emulator.memory import CONTROL, SENSOR
from tests.physics.alpha_beta import LOW, centred, gates
from tests.physics.paper_machine import make_core

T_S = 1e-4
STEP_A = 30.0 / 2**24


def currents(core: Core) -> list[float]:
    i = complex(core.shaft.i_d, core.shaft.i_q) * cmath.exp(1j * core.shaft.theta_e)
    return [(i * cmath.exp(-2j * math.pi / 3 * k)).real for k in range(3)]


def readings(core: Core) -> list[float]:
    return [float(core._measurements[0][f"i_{phase}"]) for phase in "abc"]


def low_for(duties: list[float], at: float) -> float:
    """How long the lower switch of a leg was told to be on at a time, over all periods so far."""
    since, mode = max(
        (start, mode) for start, mode in gates(centred(duties, T_S), len(duties) * T_S, 0.0) if start < at
    )
    return at - since if mode == LOW else 0.0


def test_a_phase_is_read_reconstructed_or_held() -> None:
    """At high modulation two of the three lower switches are on for too short a time, one after the other."""
    settling, dead_time = 10e-6, 1e-6
    core = make_core(
        sensors={"adc_bits": 24, "shunt_settling_s": settling},
        inverter={"dead_time_s": dead_time},
        parameters={"u_s": 0.0, "law": 5, "omega_current": 2000.0},
    )
    core.load.held, core.load.omega_m_rad_s = 1, 92.0
    core.command.pwm_enabled = 1
    core.memory["torque_command"] = 2.0
    duties: list[list[float]] = [[], [], []]
    before, kinds = [0.0] * 3, []
    for _ in range(150):
        control = core._controls[0]
        now = [float(control[f"duty_{phase}"]) for phase in "abc"] if control.gated else None
        assert core.run_with(run_ticks, 1) == 1
        true, read = currents(core), readings(core)
        if now is None:
            expected = [max(each, 0.0) for each in true]
        else:
            for leg, duty in zip(duties, now, strict=True):
                leg.append(duty)
            until = len(duties[0]) * T_S
            seen = [low_for(leg, until) >= settling + dead_time - 1e-12 for leg in duties]
            expected = [value if see else old for value, see, old in zip(true, seen, before, strict=True)]
            if seen.count(False) == 1:
                expected[seen.index(False)] = -sum(v for v, see in zip(true, seen, strict=True) if see)
            kinds.append(seen.count(False))
        assert read == pytest.approx(expected, abs=3 * STEP_A)
        before = read
    assert {0, 1, 2} <= set(kinds)
    assert core.command.trip == 0


@pytest.mark.parametrize("point", [0.0, 0.1, 0.5, 0.93, 1.0])
def test_readable_phases_are_those_of_a_walk_whatever_the_duties_and_the_moment(point: float) -> None:
    generator = np.random.default_rng(3)
    shunts, stage = Shunts(8e-6, point * T_S), InverterTruth(u_dc_V=100.0).power_stage(T_S)
    sensor, control = np.zeros(1, SENSOR)[0], np.zeros(1, CONTROL)[0]
    sensor.low_a = sensor.low_b = sensor.low_c = 1.0  # s, before the first period
    legs: list[list[float]] = [[], [], []]
    kinds = set()
    for k in range(60):
        for leg, phase in zip(legs, "abc", strict=True):
            leg.append(float(np.clip(generator.uniform(-0.3, 1.3), 0.0, 1.0)))
            control[f"duty_{phase}"] = leg[-1]
        walked = tuple(low_for(leg, (k + point) * T_S) >= 8e-6 for leg in legs)
        assert readable(shunts, True, control, stage, sensor) == walked
        kinds.add(walked)
    assert point == 0.5 or len(kinds) == 8


def test_with_the_power_stage_off_a_shunt_sees_its_lower_diode() -> None:
    core = make_core(sensors={"adc_bits": 24, "shunt_settling_s": 2e-6})
    core.shaft.i_d = 6.0  # i_a = 6, i_b = i_c = -3
    core.run_with(run_ticks, 1)
    i_a, *others = currents(core)
    assert i_a > 3.0
    assert readings(core) == pytest.approx([i_a, 0.0, 0.0], abs=STEP_A)
    assert others == pytest.approx([-0.5 * i_a] * 2)


def test_two_readings_make_the_third_with_their_errors() -> None:
    shunts = Shunts(1e-6, T_S)
    reading, last = (1.0, 2.5, 9.0), (0.1, 0.2, 0.3)
    assert reconstructed(None, (False,) * 3, reading, last) == reading
    assert reconstructed(shunts, (True, True, True), reading, last) == reading
    assert reconstructed(shunts, (True, True, False), reading, last) == (1.0, 2.5, -3.5)
    assert reconstructed(shunts, (True, False, True), reading, last) == (1.0, -10.0, 9.0)
    assert reconstructed(shunts, (False, True, True), reading, last) == (-11.5, 2.5, 9.0)
    assert reconstructed(shunts, (False, True, False), reading, last) == (0.1, 2.5, 0.3)
    assert reconstructed(shunts, (False, False, False), reading, last) == last


def test_a_blind_reading_at_the_end_of_the_range_is_no_saturation() -> None:
    """What is not read cannot trip the drive."""
    core = make_core(sensors={"shunt_settling_s": 60e-6}, parameters={"i_trip": 14.9})
    core.load.held, core.command.pwm_enabled = 1, 1
    core.run_with(run_ticks, 2)
    core.shaft.i_d = 20.0
    core.run_with(run_ticks, 1)
    assert core._measurements[0].saturated == 0
    assert np.abs(readings(core)).max() < 1.0
