"""Whatever a profile can hold is computed to finite numbers in a bounded time, or refused by its key."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from pydantic import ValidationError

from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.bounds import require_computable
from benchtool.emulator.machine.saturation import SaturationTruth
from benchtool.emulator.machine.train_truth import (
    FlangeTruth,
    LoadMachineTruth,
    LoadTruth,
    ShaftTruth,
    TrainTruth,
)
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.errors import EmulationError, ValueRefused
from benchtool.profile import (
    DrivenLoad,
    EmulatedLoadMachine,
    Inverter,
    Saturation,
    Sensors,
    Shaft,
    TrueMotor,
)
from tests.physics.paper_machine import MOTOR, make_core


def decades(lowest: int, highest: int) -> st.SearchStrategy[float]:
    return st.floats(lowest, highest).map(lambda exponent: 10.0**exponent)


@settings(max_examples=60, deadline=None)
@given(
    motor=st.fixed_dictionaries(
        {
            "R_s_ohm": decades(-5, 4),
            "L_d_H": decades(-7, 1),
            "L_q_H": decades(-7, 1),
            "psi_r_Wb": decades(-5, 2),
            "J_kgm2": decades(-9, 4),
            "friction_Nms": decades(-9, 3),
            "coulomb_Nm": decades(-5, 4),
            "breakaway_Nm": st.floats(1.01e4, 1e5),
            "stribeck_rad_s": decades(-3, 4),
            "cogging_Nm": decades(-9, 5),
            "cogging_order": st.integers(1, 1000),
        }
    ),
    inverter=st.fixed_dictionaries(
        {
            "u_dc_V": decades(-1, 5),
            "dc_link_R_ohm": decades(-6, 3),
            "dc_link_C_F": decades(-5, 2),
            "dead_time_s": decades(-9, -5),
            "device_drop_V": decades(-3, 2),
            "timer_Hz": decades(0, 10),
        }
    ),
    load_Nm=st.floats(-1e6, 1e6),
    current_A=st.floats(-1e4, 1e4),
    omega_m=st.floats(-1e3, 1e3),
    held=st.booleans(),
    on=st.booleans(),
)
def test_every_run_is_finite_or_refused(
    motor: dict[str, Any],
    inverter: dict[str, float],
    load_Nm: float,
    current_A: float,
    omega_m: float,
    held: bool,
    on: bool,
) -> None:
    TrueMotor(**motor)  # a profile can hold it
    Inverter(**inverter)
    try:
        core = make_core(motor=motor, inverter=inverter)
        core.load.torque_Nm, core.load.held, core.load.omega_m_rad_s = load_Nm, held, omega_m
        core.shaft.i_d, core.shaft.omega_m = current_A, omega_m
        core.command.pwm_enabled = on
        core.memory["torque_command"] = 5.0
        core.run_with(run_ticks, 4)
    except (ValueRefused, EmulationError):
        return
    shaft = core.shaft
    assert math.isfinite(shaft.i_d + shaft.i_q + shaft.omega_m + shaft.theta_e + shaft.u_dc)


@settings(max_examples=10, deadline=None)
@given(
    motor=st.fixed_dictionaries(
        {
            "psi_r_Wb": decades(-5, 2),
            "psi_5_Wb": st.floats(-100.0, 100.0) | st.just(1e-3),
            "psi_13_Wb": decades(-6, 2),
            "psi_of_phase": st.tuples(st.floats(0.0, 2.0), st.just(1.0), st.just(0.5)),
            "series_R_ohm": st.tuples(decades(-5, 4), st.just(0.0), st.just(1e-3)),
            "R_fe_ohm": decades(-3, 9),
            "series_L_H": st.tuples(decades(-7, 1), decades(-7, 1), st.just(0.0)),
        }
    ),
    saturation=st.fixed_dictionaries(
        {
            **dict.fromkeys(("a_dd", "a_qq", "a_dq"), st.just(0.0) | decades(-3, 40)),
            **dict.fromkeys(("S", "T"), st.integers(1, 12)),
            **dict.fromkeys(("U", "V"), st.integers(0, 12)),
        }
    ),
    current_A=st.floats(-1e4, 1e4),
    omega_m=st.floats(-1e3, 1e3),
    on=st.booleans(),
)
def test_every_machine_that_saturates_is_finite_or_refused(
    motor: dict[str, Any], saturation: dict[str, Any], current_A: float, omega_m: float, on: bool
) -> None:
    TrueMotor(**motor, saturation=Saturation(**saturation))
    try:
        core = make_core(motor={**motor, "saturation": SaturationTruth(**saturation)})
        core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m = current_A, 1.0, omega_m
        core.command.pwm_enabled = on
        core.run_with(run_ticks, 1)
    except (ValueRefused, EmulationError):
        return
    shaft = core.shaft
    assert math.isfinite(shaft.i_d + shaft.i_q + shaft.omega_m + shaft.theta_e + shaft.u_dc)


@settings(max_examples=30, deadline=None)
@given(
    shaft=st.fixed_dictionaries(
        {
            "J_load_kgm2": decades(-9, 4),
            "coupling_Nm_rad": decades(-6, 9),
            "coupling_Nms": st.just(0.0) | decades(-9, 4),
            "backlash_rad": st.just(0.0) | decades(-9, 3),
            "unbalance_kgm": decades(-9, 3),
        }
    ),
    load=st.fixed_dictionaries(
        {
            "linear_Nms": decades(-9, 3),
            "quadratic_Nms2": decades(-9, 3),
            "over_angle_Nm": st.lists(st.floats(-1e5, 1e5), max_size=5).map(tuple),
        }
    ),
    load_machine=st.fixed_dictionaries(
        {"bandwidth_Hz": decades(-3, 5), "stiffness_Nms": decades(-9, 6), "torque_limit_Nm": decades(-3, 6)}
    ),
    torque_Nm=st.floats(-1e6, 1e6),
    omega_m=st.floats(-1e3, 1e3),
    held=st.booleans(),
)
def test_every_drive_train_is_computed_or_refused(
    shaft: dict[str, float],
    load: dict[str, Any],
    load_machine: dict[str, float],
    torque_Nm: float,
    omega_m: float,
    held: bool,
) -> None:
    Shaft(**shaft), DrivenLoad(**load), EmulatedLoadMachine(**load_machine)  # a profile can hold it
    train = TrainTruth(
        shaft=ShaftTruth(**shaft),
        load=LoadTruth(**load),
        load_machine=LoadMachineTruth(**load_machine),
        flange=FlangeTruth(),
    )
    try:
        core = make_core(train=train)
        core.load.torque_Nm, core.load.held, core.load.omega_m_rad_s = torque_Nm, held, omega_m
        core.shaft.omega_m, core.shaft.omega_load = omega_m, -omega_m
        core.transducer.start(2)
        core.run_with(run_ticks, 2)
    except (ValueRefused, EmulationError):
        return
    assert np.isfinite(core.transducer.block().data).all()
    assert math.isfinite(core.shaft.omega_m + core.shaft.omega_load + core.shaft.twist)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"L_d_H": 1e-7, "L_q_H": 1e-7, "R_s_ohm": 1.0}, "R_s_ohm"),
        ({"J_kgm2": 1e-12}, "J_kgm2"),
        ({"cogging_Nm": 1e3, "cogging_order": 1000, "J_kgm2": 1e-6}, "cogging_Nm"),
        ({"friction_Nms": 1e3, "J_kgm2": 1e-5}, "friction_Nms"),
    ],
)
def test_a_machine_too_fast_to_be_computed_is_refused_by_its_key(change: dict[str, Any], named: str) -> None:
    with pytest.raises(ValueRefused, match=named):
        require_computable(MotorTruth(**{**MOTOR, **change}), 1e-4)


def test_currents_of_a_tiny_time_constant_run_out_with_the_stage_off() -> None:
    """2 us, a fiftieth of a PWM period, and none of it left after one."""
    core = make_core(motor={"L_d_H": 1e-6, "L_q_H": 1e-6, "R_s_ohm": 0.5})
    core.shaft.i_d = 5.0
    core.run(3)
    assert (core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("load", "remedy"),
    [
        ({"torque_Nm": 1e6}, "J_kgm2"),
        ({"torque_Nm": math.nan}, "load"),
        ({"held": 1, "omega_m_rad_s": 1e9}, "hold it at a lower speed"),
    ],
)
def test_a_machine_that_runs_away_ends_the_run_and_says_why(load: dict[str, float], remedy: str) -> None:
    core = make_core(motor={"J_kgm2": 1e-6})
    for name, value in load.items():
        core.load[name] = value
    with pytest.raises(EmulationError, match=remedy):
        core.run(10_000)


@pytest.mark.parametrize(
    ("section", "values", "key"),
    [
        (TrueMotor, {"L_d_H": 1e-9}, "L_d_H"),
        (TrueMotor, {"J_kgm2": 1e-15}, "J_kgm2"),
        (TrueMotor, {"cogging_order": 10**9}, "cogging_order"),
        (Inverter, {"u_dc_V": 1e9}, "u_dc_V"),
        (Inverter, {"u_dc_V": 100.0, "dead_time_s": 1.0}, "dead_time_s"),
        (Sensors, {"i_full_scale_A": 1e-300, "u_full_scale_V": 100.0}, "i_full_scale_A"),
        (
            Sensors,
            {"i_full_scale_A": 1.0, "u_full_scale_V": 1.0, "encoder_offset_rad": 1e300},
            "encoder_offset_rad",
        ),
    ],
)
def test_the_profile_bounds_every_number(section: Any, values: dict[str, float], key: str) -> None:
    with pytest.raises(ValidationError, match=key):
        section(**values)
