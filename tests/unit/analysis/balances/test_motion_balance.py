"""Inertia and friction by the balance of torque."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.coverage.channels import MOTOR
from benchmarks.coverage.excited import Excitation as Swing, Sensors, machine, record
from benchtool.analysis import Window
from benchtool.analysis.balances.flux_balance import flux_balance
from benchtool.analysis.balances.motion_balance import MOTION_BALANCE, MotionBalanceSettings, motion_balance
from benchtool.errors import AnalysisError
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR
from tests.unit.analysis.excited_machine import Excitation, Truth, capture, motor_with

FREE = Excitation(i_q_A=1.5, i_q_Hz=3.0, i_d_A=0.5)


def test_inertia_and_friction_of_a_free_shaft_are_found() -> None:
    truth = Truth(motor_with(J_kgm2=2e-3), friction_Nms=4e-3, coulomb_Nm=0.04)
    block = capture(truth, FREE, 6000)
    found = motion_balance(block, EXAMPLE_MOTOR, flux_balance(block, EXAMPLE_MOTOR)).solution
    assert found.value("J") == pytest.approx(2e-3, rel=0.01)
    for name, true in (("friction", 4e-3), ("coulomb", 0.04)):
        assert abs(found.value(name) - true) < 3.0 * found.standard(name) + 0.02 * true


def test_cogging_of_a_known_order_is_told_from_the_inertia() -> None:
    """Taken for none, the inertia comes out some ten percent off, with much less for its uncertainty."""
    truth = Truth(motor_with(J_kgm2=2e-3), coulomb_Nm=0.04, cogging_Nm=0.5, cogging_order=8)
    block = capture(truth, FREE, 6000)
    flux = flux_balance(block, EXAMPLE_MOTOR)
    without = motion_balance(block, EXAMPLE_MOTOR, flux).solution
    found = motion_balance(block, EXAMPLE_MOTOR, flux, (8,)).solution
    assert abs(without.value("J") / 2e-3 - 1.0) > 0.05
    assert found.value("J") == pytest.approx(2e-3, rel=0.01)
    waves = [found.value(f"cogging_8_{wave}") for wave in ("cos", "sin")]
    assert math.hypot(*waves) == pytest.approx(0.5, rel=0.03)


def test_a_shaft_whose_speed_is_held_tells_no_inertia() -> None:
    block = capture(Truth(), Excitation(speed_rad_s=60.0), 3000)
    window = Window.of(block, EXAMPLE_MOTOR)
    inertia, *_ = MOTION_BALANCE.measure(window, MotionBalanceSettings()).measurements
    assert math.isnan(inertia.value)
    assert "turns freely" in inertia.reason


def test_a_shaft_that_another_machine_swings_tells_no_inertia() -> None:
    """The torque of the other machine accelerates it: by that of the motor the inertia came out as a tenth or
    less of itself, with a small U."""
    block = capture(Truth(), Excitation(i_q_A=0.3, i_q_Hz=3.0, speed_rad_s=60.0, swing_rad_s=2.0), 3000)
    found = motion_balance(block, EXAMPLE_MOTOR, flux_balance(block, EXAMPLE_MOTOR)).solution
    assert found.hidden == {"J"}


def test_an_even_speed_by_the_counts_of_an_encoder_tells_no_inertia() -> None:
    """The counts alone accelerate then, by no torque: the inertia came out as zero, with a small U."""
    block = capture(Truth(counts=2500), Excitation(speed_rad_s=60.0), 3000)
    found = motion_balance(block, EXAMPLE_MOTOR, flux_balance(block, EXAMPLE_MOTOR)).solution
    assert found.hidden == {"J"}
    assert "noise hides" in found.why_not("J")
    swing = capture(Truth(counts=2500), FREE, 3000)
    swung = motion_balance(swing, EXAMPLE_MOTOR, flux_balance(swing, EXAMPLE_MOTOR)).solution
    assert not swung.hidden


def test_a_shaft_that_hardly_turns_is_refused() -> None:
    block = capture(Truth(), Excitation(i_q_A=2.0, i_q_Hz=150.0), 1500)
    with pytest.raises(AnalysisError, match="turn it faster"):
        motion_balance(block, EXAMPLE_MOTOR, flux_balance(block, EXAMPLE_MOTOR))


def test_uncertainties_do_not_depend_on_how_far_off_the_belief_is() -> None:
    truth = Truth(motor_with(J_kgm2=2e-3), friction_Nms=4e-3, coulomb_Nm=0.04)
    block = capture(truth, FREE, 6000)
    flux = flux_balance(block, EXAMPLE_MOTOR)
    near, far = (
        motion_balance(block, EXAMPLE_MOTOR.model_copy(update={"J_kgm2": each}), flux).solution
        for each in (2e-3, 4e-3)
    )
    for name in ("J", "friction", "coulomb"):
        assert far.value(name) == pytest.approx(near.value(name), abs=0.1 * near.standard(name))
        assert far.standard(name) == pytest.approx(near.standard(name), rel=0.02)


def test_dead_time_moves_the_current_between_the_ticks() -> None:
    """All of the voltage is by dead time here, so that the friction is off by what is stated for that."""
    random = np.random.default_rng(4)
    what = replace(machine(random), dead_time_V=2.0)
    read = Sensors(noise_A=1e-4, step_A=0.0, counts=0)
    block = record(what, read, Swing(), 4000, random).block
    found = motion_balance(block, MOTOR, flux_balance(block, MOTOR))
    place = found.solution.names.index("friction")
    moved = found.between_ticks[place]
    assert moved > 10.0 * found.solution.standard("friction")
    assert found.solution.value("friction") - what.friction == pytest.approx(moved, rel=0.3)
