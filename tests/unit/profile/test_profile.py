"""Profiles: the shipped one is valid, and every fault is reported in one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchtool.errors import ProfileError
from benchtool.profile import altered, load_profile, shipped_profiles
from benchtool.shipped import shipped

TEXT = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")


def _refusal(tmp_path: Path, text: str) -> str:
    path = tmp_path / "mine.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ProfileError) as refused:
        load_profile(str(path))
    message = str(refused.value)
    assert "\n" not in message
    return message


def test_the_papers_machine() -> None:
    motor = load_profile("zhu2011").motor
    assert motor.pole_pairs == 4
    # 1.43 Nm per A rms of Table I as peak flux linkage: T = 3/2 p psi_r sqrt(2) I_rms
    assert 1.5 * motor.pole_pairs * motor.psi_r_Wb * 2**0.5 == pytest.approx(1.43, rel=2e-4)


def test_every_choice_is_recorded_in_full() -> None:
    choices = load_profile("zhu2011").choices
    assert choices
    assert all(each.choice and each.reason and each.effect for each in choices)


@pytest.mark.parametrize("name", shipped_profiles())
def test_the_step_of_the_dc_link_is_stated_as_the_emulated_converter_has_it(name: str) -> None:
    """A link at rest does not show it, and without it its mean had no uncertainty with any motor but one."""
    profile = load_profile(name)
    assert profile.emulator is not None
    sensors = profile.emulator.sensors
    step_V = sensors.u_full_scale_V / 2**sensors.adc_bits
    assert profile.bench.channels["u_dc"].resolution == pytest.approx(step_V, rel=1e-5)


def test_unknown_name_lists_the_known() -> None:
    with pytest.raises(
        ProfileError, match=r"no profile 'zhu2012': did you mean 'zhu2011'\? the names are .*, zhu2011"
    ):
        load_profile("zhu2012")


def test_name_cannot_leave_the_folder() -> None:
    with pytest.raises(ProfileError):
        load_profile("../../etc")


def test_missing_file() -> None:
    with pytest.raises(ProfileError, match=r"no profile file nowhere\.toml"):
        load_profile("nowhere.toml")


def test_misspelt_key_names_line_and_remedy(tmp_path: Path) -> None:
    message = _refusal(tmp_path, TEXT.replace("R_s_ohm =", "R_s_ohms ="))
    line = 1 + TEXT[: TEXT.index("R_s_ohm =")].count("\n")
    assert f"line {line}" in message
    assert "unknown key 'motor.R_s_ohms': did you mean 'R_s_ohm'?" in message


def test_value_out_of_range_names_key_and_value(tmp_path: Path) -> None:
    message = _refusal(tmp_path, TEXT.replace("pole_pairs = 4", "pole_pairs = 0"))
    assert "key 'motor.pole_pairs' is 0" in message
    assert "greater than 0" in message


def test_missing_key(tmp_path: Path) -> None:
    assert "'motor.psi_r_Wb' is missing" in _refusal(tmp_path, TEXT.replace("psi_r_Wb = 0.1685\n", ""))


def test_not_toml(tmp_path: Path) -> None:
    assert "not TOML" in _refusal(tmp_path, "[motor\n")


def test_not_utf8(tmp_path: Path) -> None:
    path = tmp_path / "latin.toml"
    path.write_bytes(b'title = "M\xfcller"\n')
    with pytest.raises(ProfileError, match="not UTF-8"):
        load_profile(str(path))


def test_an_altered_bench_differs_in_what_is_named_and_in_nothing_else() -> None:
    profile = load_profile("zhu2011")
    other = altered(profile, {"inverter.u_dc_V": 311.0, "motor.R_s_ohm": 0.246})
    assert other.emulator is not None
    assert profile.emulator is not None
    assert other.emulator.inverter.u_dc_V == 311.0
    assert other.emulator.motor.R_s_ohm == 0.246
    assert other.emulator.sensors == profile.emulator.sensors
    assert other.motor == profile.motor
    assert profile.emulator.inverter.u_dc_V == 122.5


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        ("inverter.u_dc", 311.0, "unknown key 'inverter.u_dc': did you mean 'u_dc_V'?"),
        ("inverter.u_dc_V", -1.0, "key 'inverter.u_dc_V' is -1.0"),
        ("u_dc_V", 311.0, "unknown key 'u_dc_V'"),
    ],
)
def test_mistakes_in_an_alteration(key: str, value: float, complaint: str) -> None:
    with pytest.raises(ProfileError) as refused:
        altered(load_profile("zhu2011"), {key: value})
    assert complaint in str(refused.value)
