"""Quick stop and halt on the true shaft: to rest, without turning back, with any load."""

from __future__ import annotations

import itertools

import pytest

from benchtool.emulator.core import Core
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import MOTOR, make_core

FOC = 5
CASES = list(itertools.product([0.1, 1.0, 20.0], [-4.0, 0.0, 4.0], [100.0, -40.0]))


def turning(*, J: float, load_Nm: float, omega_m: float, mode: Mode = Mode.VELOCITY, law: int = FOC) -> Core:
    """A machine of `J` times the inertia that its drive believes, on its way under load."""
    parameters = {"u_s": 207.3, "law": law}
    core = make_core(motor={"J_kgm2": J * MOTOR["J_kgm2"]}, inverter={"u_dc_V": 311.0}, parameters=parameters)
    core.shaft.omega_m = omega_m
    core.load.torque_Nm = load_Nm
    core.memory["torque_command"], core.memory["omega_m_command"] = load_Nm, omega_m
    core.command.mode, core.command.pwm_enabled = int(mode), 1
    core.run(1500)
    return core


def lowest_speed(core: Core, *, until_standstill: bool = True) -> float:
    """Lowest speed of the shaft, in the direction in which it turned before, over two seconds at most."""
    sign, lowest = (1.0 if core.shaft.omega_m > 0 else -1.0), float("inf")
    for _ in range(2000):
        core.run(10)
        lowest = min(lowest, sign * float(core.shaft.omega_m))
        if until_standstill and core.command.standstill:
            break
    return lowest


@pytest.mark.parametrize(("J", "load_Nm", "omega_m"), CASES)
def test_a_quick_stop_ends_at_rest_and_does_not_turn_back(J: float, load_Nm: float, omega_m: float) -> None:
    core = turning(J=J, load_Nm=load_Nm, omega_m=omega_m)
    core.command.quick_stop = core.command.off_at_standstill = 1
    lowest = lowest_speed(core)
    assert core.command.standstill == 1
    assert core.command.trip == 0
    # Up to 9 ticks ran without torque until the loop above looked again.
    coasted = abs(load_Nm) / (J * MOTOR["J_kgm2"]) * 9e-4
    assert lowest > -0.4 - coasted
    assert abs(core.shaft.omega_m) < 0.7 + coasted
    assert core.command.pwm_enabled == 0


@pytest.mark.parametrize("law", [0, 6])
@pytest.mark.parametrize("mode", [Mode.TORQUE, Mode.VELOCITY])
def test_a_quick_stop_in_either_mode_and_of_other_laws(law: int, mode: Mode) -> None:
    core = turning(J=1.0, load_Nm=1.0, omega_m=50.0, mode=mode, law=law)
    core.command.quick_stop = core.command.off_at_standstill = 1
    assert lowest_speed(core) > -1.0
    assert abs(core.shaft.omega_m) < 1.0
    assert core.command.standstill == 1


def test_the_power_stage_goes_off_in_the_tick_that_finds_standstill() -> None:
    core = turning(J=1.0, load_Nm=0.0, omega_m=20.0)
    core.command.quick_stop = core.command.off_at_standstill = 1
    while not core.command.standstill:
        assert core.command.pwm_enabled == 1
        core.run(1)
    assert core.command.pwm_enabled == 0
    core.run(20)
    assert core.command.standstill == 1  # for the firmware, which looks once a millisecond
    assert core.memory["torque_reference"][0] == 0.0


@pytest.mark.parametrize("load_Nm", [-5.0, 5.0])
def test_a_quick_stop_that_holds_and_a_halt_hold_the_load(load_Nm: float) -> None:
    for field in ("quick_stop", "halt"):
        core = turning(J=1.0, load_Nm=0.0, omega_m=50.0)
        core.command[field] = 1
        lowest = lowest_speed(core, until_standstill=False)
        assert lowest > -0.5
        core.load.torque_Nm = load_Nm
        core.run(5000)
        assert abs(core.shaft.omega_m) < 0.5
        assert core.memory["torque"][0] == pytest.approx(load_Nm, abs=0.3)
        assert core.command.standstill == 1
        assert core.command.pwm_enabled == 1


def test_after_a_halt_the_speed_controller_takes_the_load_over_without_a_bump() -> None:
    core = turning(J=1.0, load_Nm=3.0, omega_m=20.0)
    core.command.halt = 1
    core.run(5000)
    core.command.halt = 0
    core.memory["omega_m_command"] = 0.0
    core.run(200)
    assert abs(core.shaft.omega_m) < 1.0
    core.memory["omega_m_command"] = 20.0
    core.run(10_000)
    assert core.shaft.omega_m == pytest.approx(20.0, abs=0.5)


def test_a_halt_in_torque_mode_makes_no_torque() -> None:
    core = turning(J=1.0, load_Nm=2.0, omega_m=20.0, mode=Mode.TORQUE)
    core.load.held, core.load.omega_m_rad_s = 1, 20.0
    core.command.halt = 1
    core.run(2000)
    assert core.memory["torque_reference"][0] == 0.0
    assert core.memory["torque"][0] == pytest.approx(0.0, abs=0.1)
    assert core.command.standstill == 1
    core.command.halt = 0
    core.run(1000)
    assert core.memory["torque"][0] == pytest.approx(2.0, abs=0.2)


def test_a_shaft_that_is_held_is_never_at_rest() -> None:
    core = turning(J=1.0, load_Nm=0.0, omega_m=20.0)
    core.load.held, core.load.omega_m_rad_s = 1, 20.0
    core.command.quick_stop = core.command.off_at_standstill = 1
    core.run(5000)
    assert core.command.standstill == 0
    assert core.memory["torque"][0] < -5.0
