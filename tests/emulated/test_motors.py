"""The motors that ship: each holds speed and load on its own law, by one plan over all of them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.emulator.bench import _emulator_of, _truth
from benchtool.emulator.core.core import truth_of
from benchtool.emulator.jit import parts_of
from benchtool.profile import load_profile, shipped_profiles

MOTORS = [name for name in shipped_profiles() if name.startswith("motors/")]


def test_every_motor_holds_speed_and_load_by_its_own_law(tmp_path: Path) -> None:
    ran = CliRunner().invoke(app, ["run", "motors/speed_and_load", "--json", "--out", str(tmp_path / "run")])
    assert ran.exit_code == 0, ran.output
    document = json.loads(ran.stdout)
    assert document["verdict"] == "pass"
    assert list(document["plans"]) == MOTORS
    for name, result in document["plans"].items():
        motor, short = load_profile(name).motor, name.partition("/")[2]
        (case,) = result["cases"].values()
        found = {key: each["value"] for key, each in case["measurements"].items()}
        assert Path(case["bundle"]) == tmp_path / "run" / short
        assert found["omega_m_reached"] == pytest.approx(0.5 * motor.omega_m_N_rad_s, rel=4e-3)
        if motor.L_d_H == motor.L_q_H:  # else reluctance adds torque
            i_q_A = 0.5 * motor.T_N_Nm / (1.5 * motor.pole_pairs * motor.psi_r_Wb)
            assert found["current_fundamental"] == pytest.approx(i_q_A, rel=0.01), name


def test_sixteen_motors_from_milliohms_up_share_one_kernel() -> None:
    profiles = {name: load_profile(name) for name in MOTORS}
    resistances = [profile.motor.R_s_ohm for profile in profiles.values()]
    assert (len(profiles), min(resistances), max(resistances)) == (16, 0.004, 24.0)
    kernels = {frozenset(parts_of(truth_of(*_truth(each, _emulator_of(each))))) for each in profiles.values()}
    assert len(kernels) == 1
    assert {profile.drive.parameters["law"] for profile in profiles.values()} == {"foc", "tpc"}
