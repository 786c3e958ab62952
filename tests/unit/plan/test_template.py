"""The template of a plan: it has what a newcomer needs, and runs as it stands."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from benchtool.plan.model import OF_RATED, OperatingPoint, Plan, Record, load_plan, profiles_of
from benchtool.plan.template import plan_text
from benchtool.plan.validation import require_known
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped

PROFILE = load_profile("zhu2011")
DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)


@settings(max_examples=20)
@given(st.floats(5.0, 3000.0), st.integers(1, 21), st.floats(0.01, 50.0))
def test_it_is_a_plan_that_a_run_takes_whatever_the_motor(omega_m: float, p: int, T_N: float) -> None:
    rated = {"omega_m_N_rad_s": omega_m, "pole_pairs": p, "T_N_Nm": T_N}
    motor = PROFILE.motor.model_copy(update=rated)
    profile = PROFILE.model_copy(update={"motor": motor})
    plan = Plan.model_validate(tomllib.loads(plan_text("t", "zhu2011", profile)))
    if p * omega_m < 20.0:
        return  # two periods at half speed last longer than a capture
    point = plan.operating_point
    assert 0.45 < point.omega_m_rad_s / omega_m < 0.55
    assert 0.45 < point.load_torque_Nm / T_N < 0.55


def test_it_is_known_to_profile_and_dictionary(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(plan_text("t", "zhu2011", PROFILE), encoding="utf-8")
    require_known(load_plan(str(path)), path, PROFILE, DICTIONARY, transducer=True)


def test_every_key_of_its_sections_is_in_it_and_what_is_behind_comments_is_right() -> None:
    text = plan_text("t", "zhu2011", PROFILE)
    for key in (*OperatingPoint.model_fields, *Record.model_fields):
        assert f"{key} = " in text or key == "u_dc_V" or key in OF_RATED
    for key in (
        "repetitions",
        "judge",
        "[case_limits",
        "[[variants]]",
        "[sweep.",
        "[stimulus]",
        "[analyses]",
    ):
        assert key in text
    behind = text[text.index("# [case_limits.foc]") :].replace("\n#\n", "\n").replace("\n# ", "\n")[2:]
    own = tomllib.loads(text)
    own["operating_point"] = {"mode": "torque", "torque_Nm": 0.1, "hold_speed_rad_s": 15.0}
    assert Plan.model_validate({**own, **tomllib.loads(behind), "sweep": {}}).stimulus is not None


def test_a_profile_is_named_relative_to_the_plan(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "plans").mkdir()
    path = tmp_path / "plans" / "mine.toml"
    path.write_text(plan_text("t", "../motors/own.toml", PROFILE), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    (place,) = profiles_of("plans/mine.toml", load_plan("plans/mine.toml"))
    assert Path(place).resolve() == tmp_path / "motors" / "own.toml"
    assert profiles_of("zhu2011/ripple", load_plan("zhu2011/ripple")) == ("zhu2011",)
