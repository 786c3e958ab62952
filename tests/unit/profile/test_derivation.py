"""Parameters that are derived from a motor: within what a drive takes, and by the rules that they name."""

from __future__ import annotations

import math
import tomllib

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from pydantic import BaseModel

from benchtool.profile import Bench, Drive, Inverter, Motor, Profile, Sensors, TrueMotor, load_profile
from benchtool.profile.derivation import LAWS, Given, derived_parameters
from benchtool.profile.template import profile_text
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.keys import setting_of
from benchtool.protocol.dictionary.relations import first_breach
from benchtool.shipped import shipped

DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
ZHU = load_profile("zhu2011")
GIVEN = Given(122.5, 2500)


@st.composite
def _motors(draw: st.DrawFn) -> Motor:
    """Motors whose rated current has 0.01 to 2 times the flux of the magnets, as of all that are built."""
    p, psi_r, I_N = draw(st.integers(1, 21)), draw(st.floats(1e-3, 1.0)), draw(st.floats(0.5, 100.0))
    L_d, L_q = (draw(st.floats(0.01, 2.0)) * psi_r / (math.sqrt(2.0) * I_N) for _ in range(2))
    T_N = 1.5 * p * psi_r * math.sqrt(2.0) * I_N
    return Motor(
        pole_pairs=p,
        R_s_ohm=draw(st.floats(1e-3, 30.0)),
        L_d_H=min(max(L_d, 2e-6), 1.0),
        L_q_H=min(max(L_q, 2e-6), 1.0),
        psi_r_Wb=psi_r,
        J_kgm2=T_N / draw(st.floats(100.0, 3e4)),
        T_N_Nm=T_N,
        omega_m_N_rad_s=draw(st.floats(5.0, 5000.0)),
        I_N_A_rms=I_N,
    )


motors = _motors()


def values(motor: Motor, given: Given = GIVEN, law: str = "") -> dict[str, float]:
    return {each.key: each.value for each in derived_parameters(motor, given, law) if each.key != "law"}  # type: ignore[misc]


@settings(max_examples=25)
@given(motors, st.floats(10.0, 600.0), st.sampled_from(("", *LAWS)))
def test_what_is_derived_is_a_profile_that_a_drive_takes(motor: Motor, u_dc_V: float, law: str) -> None:
    known = Given(u_dc_V, 2500, dead_time_s=1e-6)
    derived = derived_parameters(motor, known, law)
    text = profile_text('a "quoted" motor\\', motor, known, derived)
    profile = Profile.model_validate(tomllib.loads(text))
    assert profile.title == 'a "quoted" motor\\'
    assert profile.emulator is not None
    for key, value in profile.stated_parameters.items():
        setting_of(DICTIONARY, key, value)
    assert first_breach(DICTIONARY, profile.stated_parameters, profile.emulator.sensors.full_scales()) == ""
    assert profile.motor.psi_r_Wb == pytest.approx(motor.psi_r_Wb, rel=1e-5)
    assert set(profile.drive.parameters) == {each.key for each in derived}
    assert all(each.rule for each in derived)


@given(motors)
def test_the_speed_loop_is_critically_damped_and_slower_than_what_it_stands_on(motor: Motor) -> None:
    found = values(motor)
    poles = np.roots([motor.J_kgm2, found["K_p_speed_Nms_rad"], found["K_i_speed_Nm_rad"]])
    bandwidth = found["K_p_speed_Nms_rad"] / motor.J_kgm2
    np.testing.assert_allclose(poles, -bandwidth / 2.0, rtol=1e-3)
    assert bandwidth <= found["omega_current_rad_s"] / 10.0 * (1.0 + 1e-9)
    # one encoder count through the observer and the gain
    count_rad = 2.0 * math.pi / 1e4
    assert found["K_p_speed_Nms_rad"] * 5.0 * bandwidth * count_rad <= 0.00201 * motor.T_N_Nm


def test_the_papers_motor_is_given_about_what_its_profile_states() -> None:
    """The values of the profile were found by hand, before there were rules."""
    stated, found = ZHU.drive.parameters, values(ZHU.motor)
    for key in ("u_s_V", "T_k_ratio", "torque_limit_Nm", "i_trip_A", "omega_m_trip_rad_s"):
        assert found[key] == pytest.approx(stated[key], rel=0.05), key
    for key in (
        "K_p_delta_rad_Nm",
        "K_i_delta_rad_Nms",
        "torque_band_Nm",
        "flux_band_Wb",
        "omega_current_rad_s",
    ):
        assert 0.5 < found[key] / float(stated[key]) < 2.0, key


def test_the_deadbeat_gain_is_the_slope_of_the_torque_over_the_load_angle() -> None:
    motor = ZHU.motor

    def torque(delta: float) -> float:
        return 1.5 * motor.pole_pairs * motor.psi_r_Wb**2 / motor.L_q_H * math.sin(delta)

    slope = (torque(1e-4) - torque(-1e-4)) / 2e-4
    assert values(motor)["K_p_delta_rad_Nm"] == pytest.approx(0.5 / slope, rel=1e-6)


def test_a_fixed_voltage_is_left_to_machines_with_enough_inductance() -> None:
    small = ZHU.motor.model_copy(update={"L_d_H": 1e-4, "L_q_H": 1e-4})
    chosen = [derived_parameters(motor, GIVEN)[0].value for motor in (ZHU.motor, small)]
    assert chosen == ["tpc", "foc"]
    assert values(small, law="tpc")["i_trip_A"] > 5.0 * values(small)["i_trip_A"], "room for its ripple"


def test_the_laws_are_those_of_the_dictionary() -> None:
    assert tuple(DICTIONARY["law"].values or ()) == LAWS


@pytest.mark.parametrize("section", [Motor, Drive, Inverter, Sensors, TrueMotor])
def test_the_template_has_every_key(section: type[BaseModel]) -> None:
    text = profile_text("t", ZHU.motor, GIVEN, derived_parameters(ZHU.motor, GIVEN))
    # a true motor's circuit is that of [motor], by the same keys
    for key, field in section.model_fields.items():
        if key not in ("parameters", "i_b", "i_c"):  # the other phases are as i_a
            is_table = isinstance(field.annotation, type) and issubclass(field.annotation, BaseModel)
            assert (f".{key}]" if is_table else f"{key} = ") in text


def test_the_sensors_behind_comments_are_those_of_an_emulated_bench() -> None:
    text = profile_text("t", ZHU.motor, GIVEN, derived_parameters(ZHU.motor, GIVEN))
    behind = text[text.index("# [emulator.sensors.i_a]") : text.index("# What stands beside the drive")]
    found = tomllib.loads(behind.replace("\n#\n", "\n").replace("# [", "[").replace("\n# ", "\n"))
    stated = {"i_full_scale_A": 1.0, "u_full_scale_V": 1.0, **found["emulator"]["sensors"]}
    assert Sensors.model_validate(stated).encoder.index


def test_the_bench_behind_comments_is_one() -> None:
    text = profile_text("t", ZHU.motor, GIVEN, derived_parameters(ZHU.motor, GIVEN))
    behind = (
        text[text.index("# [bench.load]") :].replace("\n#\n", "\n").replace("# [", "[").replace("\n# ", "\n")
    )
    bench = Bench.model_validate(tomllib.loads(behind)["bench"])
    assert set(bench.channels) == {"i_a", "u_dc"}
    sensors = tomllib.loads(text)["emulator"]["sensors"]
    step_V = sensors["u_full_scale_V"] / 2 ** sensors["adc_bits"]
    assert bench.channels["u_dc"].resolution == pytest.approx(step_V, rel=1e-5)


def test_every_line_has_a_comment_in_the_same_column() -> None:
    text = profile_text("t", ZHU.motor, GIVEN, derived_parameters(ZHU.motor, GIVEN))
    table = text[text.index("[motor]") : text.index("[drive]")].splitlines()[1:]
    assert len({line.index("  # ") for line in table if line and not line.startswith("#")}) == 1
