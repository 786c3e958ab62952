"""A profile as a commissioning leaves it."""

from __future__ import annotations

import tomllib

import pytest
from hypothesis import given, settings, strategies as st

from benchtool.analysis import Measurement, Uncertainty
from benchtool.commission import commissioned_profile
from benchtool.errors import ProfileError
from benchtool.profile import Profile, shipped_profiles
from benchtool.protocol.dictionary import Value
from benchtool.shipped import shipped

ESTIMATE = {"R_s": Measurement("R_s", 0.5, "ohm", "slope", uncertainty=Uncertainty(0.002, "scatter"))}
TEXT = """
title = "a motor"  # as on its label
[motor]   # of the label
pole_pairs = 4
R_s_ohm = 0.16   # ohm: per phase
L_d_H = 7e-3
L_q_H = 7e-3
psi_r_Wb = 0.1685
J_kgm2 = 13.1e-4
T_N_Nm = 9.55
omega_m_N_rad_s = 157.1
I_N_A_rms = 6.7

[drive]
[drive.parameters]
law = "foc"        # not tpc

# the bench
[emulator]
commissioned = false
[emulator.motor]
R_s_ohm = 0.123
"""


def test_values_are_replaced_and_all_else_stays() -> None:
    found: dict[str, Value] = {"encoder_offset_rad": 0.25, "encoder_direction": "reverse"}
    values: dict[str, Value] = {"R_s_ohm": 0.5, "law": "foc", **found}
    text = commissioned_profile(TEXT, values, ESTIMATE, saved=True)
    before, after = tomllib.loads(TEXT), tomllib.loads(text)
    assert after["motor"] == {**before["motor"], "R_s_ohm": 0.5}
    assert after["nameplate"] == before["motor"]
    assert after["drive"]["parameters"] == {"law": "foc", **found}
    assert after["emulator"] == {"commissioned": True, "motor": {"R_s_ohm": 0.123}}
    assert "ohm: per phase; commissioned: 0.5000 ± 0.0039 ohm, nameplate 0.16" in text
    for kept in ("# as on its label", "# of the label", "# not tpc", "# the bench"):
        assert kept in text
    again = commissioned_profile(text, {"R_s_ohm": 0.7}, {}, saved=False)
    assert tomllib.loads(again)["nameplate"] == before["motor"]


def test_a_drive_that_stores_nothing_is_not_commissioned() -> None:
    after = tomllib.loads(commissioned_profile(TEXT, {"R_s_ohm": 0.5}, {}, saved=False))
    assert after["emulator"]["commissioned"] is False


@settings(max_examples=25)
@given(
    name=st.sampled_from(shipped_profiles()),
    R_s=st.floats(1e-3, 50.0),
    offset=st.floats(-3.0, 3.0),
)
def test_every_profile_that_ships_can_be_written(name: str, R_s: float, offset: float) -> None:
    text = (shipped("profiles") / name / "profile.toml").read_text(encoding="utf-8")
    before = Profile.model_validate(tomllib.loads(text))
    values = {**before.stated_parameters, "R_s_ohm": R_s, "encoder_offset_rad": offset}
    after = Profile.model_validate(tomllib.loads(commissioned_profile(text, values, {}, saved=True)))
    assert after.motor.R_s_ohm == pytest.approx(R_s, rel=1e-6)
    assert after.drive.parameters["encoder_offset_rad"] == pytest.approx(offset, rel=1e-6, abs=1e-9)
    assert after.nameplate == before.motor
    assert after.motor.model_copy(update={"R_s_ohm": before.motor.R_s_ohm}) == before.motor
    assert after.bench == before.bench


def test_a_text_that_cannot_be_edited_by_lines_is_refused() -> None:
    inline = TEXT.replace('[drive.parameters]\nlaw = "foc"        # not tpc', 'parameters = { law = "foc" }')
    with pytest.raises(ProfileError, match="one key a line"):
        commissioned_profile(inline, {"R_s_ohm": 0.5, "law": "tpc"}, {}, saved=False)
