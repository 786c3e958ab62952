"""Roles: the standard's objects by index, and what a profile redirects."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchtool.errors import ProfileError, ValueRefused
from benchtool.profile import load_profile
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.profiled import profiled_dictionary
from benchtool.protocol.dictionary.roles import Role
from benchtool.shipped import shipped
from tests.third_party_drives import third_party_eds

PROFILE = """title = "A third-party drive"
[motor]
pole_pairs = 4
R_s_ohm = 0.1
L_d_H = 1e-3
L_q_H = 1e-3
psi_r_Wb = 0.1
J_kgm2 = 1e-3
T_N_Nm = 2.0
omega_m_N_rad_s = 100.0
I_N_A_rms = 5.0
[drive]
eds = "any.eds"
[roles]
"""
FIRST_LINE = PROFILE.count("\n") + 1


def dictionary_with(folder: Path, roles: str, eds: bytes | None = None) -> Dictionary:
    (folder / "any.eds").write_bytes(third_party_eds() if eds is None else eds)
    source = folder / "profile.toml"
    source.write_text(PROFILE + roles, encoding="utf-8")
    return profiled_dictionary(load_profile(str(source)), source, 1)


def test_each_object_of_the_reference_drive_with_a_roles_name_is_that_role() -> None:
    own = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
    named = {role: own[role.title] for role in Role if role.title in own}
    assert len(named) >= 30
    assert {role: variable.key for role, variable in named.items()} == {role: role.key for role in named}


def test_another_makers_objects_are_found_whatever_they_are_called() -> None:
    dictionary = Dictionary.from_bytes(third_party_eds(), 1, "any.eds")
    assert dictionary[Role.STATUSWORD].name == "Statusword 1"
    assert dictionary[Role.CONSUMER_HEARTBEAT].label == "0x1016:1"
    assert Role.MAX_TORQUE not in dictionary
    with pytest.raises(ValueRefused, match=r"no object 0x6072:0 max_torque in any.eds: .* \[roles\]"):
        dictionary[Role.MAX_TORQUE]


@pytest.mark.parametrize(
    "stated", ['"0x607A:00"', '"0x607A"', '"Target Position"', '{ object = "0x607A:0" }']
)
def test_a_profile_redirects_a_role_by_address_or_by_name(tmp_path: Path, stated: str) -> None:
    dictionary = dictionary_with(tmp_path, f"target_velocity = {stated}\n")
    assert dictionary[Role.TARGET_VELOCITY].key == (0x607A, 0)
    assert dictionary[Role.TARGET_POSITION].key == (0x607A, 0)
    assert dictionary[Role.TARGET_TORQUE].key == (0x6071, 0)


def test_a_profile_adds_an_object_that_the_standard_has_elsewhere(tmp_path: Path) -> None:
    eds = third_party_eds(without=["6077"]) + (
        b"[3001]\r\nParameterName=Torque\r\nObjectType=9\r\nSubNumber=3\r\n"
        b"[3001sub2]\r\nParameterName=T\r\nObjectType=7\r\nDataType=8\r\nAccessType=ro\r\n"
    )
    assert Role.TORQUE_ACTUAL not in Dictionary.from_bytes(eds, 1, "any.eds")
    dictionary = dictionary_with(
        tmp_path, 'torque_actual = { object = "0x3001:02", unit = "Nm", factor = 0.5 }\n', eds
    )
    variable = dictionary[Role.TORQUE_ACTUAL]
    assert (variable.key, variable.unit, variable.factor) == ((0x3001, 2), "Nm", 0.5)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('torque_actul = "0x6077"', r"no role 'torque_actul': did you mean 'torque_actual'\?"),
        ('torque_actual = "0x3001:2"', r"no object '0x3001:2' in .*any\.eds"),
        ('torque_actual = "Torque actual"', r"did you mean 'Torque actual value'\?"),
        ('device_name = "0x6077"', "is of type i16, text is expected"),
        ("torque_actual = 0x6077", "key 'roles.torque_actual"),
        ('torque_actual = { object = "0x6077", factor = 0.5 }', "a factor is of a unit"),
        ('torque_actual = { object = "0x6077", unit = "Nm", factor = 0.0 }', "makes every value 0"),
        (
            'torque_actual = { object = "0x6077", unit = "rpm" }',
            "unit is 'rpm', and one of Nm, .* is expected",
        ),
        ("torque_actual = 24695", "'0x3001:2' or its name, or a table with 'object' is expected"),
        ('torque_actual = { objct = "0x6077" }', r"unknown key 'roles.torque_actual.objct': did you mean"),
    ],
)
def test_what_is_wrong_is_refused_with_file_line_and_key(tmp_path: Path, line: str, said: str) -> None:
    with pytest.raises(ProfileError, match=said) as refused:
        dictionary_with(tmp_path, f'controlword = "0x6040"\n{line}\n')
    assert str(refused.value).startswith(f"{tmp_path / 'profile.toml'}, line {FIRST_LINE + 1}: ")
    assert "roles.torque_act" in str(refused.value) or "roles.device_name" in str(refused.value)


@pytest.mark.parametrize("role", [role for role in Role if not role.unit and not role.is_text])
def test_what_is_no_quantity_is_not_scaled(tmp_path: Path, role: Role) -> None:
    """A factor on a code would have the host write another one: 0x6007 of 1 as 0, which is to do nothing."""
    eds = third_party_eds()
    address = role.address if role in Dictionary.from_bytes(eds, 1, "any.eds") else "0x1001"
    stated = f'{role.title} = {{ object = "{address}", unit = "rad/s", factor = 2.0 }}\n'
    with pytest.raises(ProfileError, match=f"'roles.{role.title}': unit is 'rad/s', and a .* is no quantity"):
        dictionary_with(tmp_path, stated, eds)


@pytest.mark.parametrize("unit", ["Nm", "mNm", "T_N"])
def test_a_torque_may_be_of_the_rated_one(tmp_path: Path, unit: str) -> None:
    stated = f'torque_actual = {{ object = "0x6077", unit = "{unit}", factor = 0.01 }}\n'
    assert dictionary_with(tmp_path, stated)[Role.TORQUE_ACTUAL].unit == unit


def test_a_host_is_watched_by_no_object_but_the_standards(tmp_path: Path) -> None:
    """What is written there reads back from any object that holds 32 bits, such as the rated torque."""
    with pytest.raises(ProfileError, match=r"'0x6076' is 0x6076, an entry of 0x1016 is expected"):
        dictionary_with(tmp_path, 'consumer_heartbeat = "0x6076"\n')
    second = dictionary_with(tmp_path, 'consumer_heartbeat = "0x1016:2"\n')
    assert second[Role.CONSUMER_HEARTBEAT].key == (0x1016, 2)
