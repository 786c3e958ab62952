"""SI values by whichever object a drive has for them, against the definitions of the standard."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, strategies as st

from benchtool.drive.quantities import (
    CURRENT,
    DC_LINK_VOLTAGE,
    RATED_CURRENT,
    RATED_TORQUE,
    SPEED,
    SPEED_SETPOINT,
    TORQUE,
    TORQUE_SETPOINT,
    Quantity,
    in_si,
    is_own,
)
from benchtool.errors import CapabilityMissing
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.roles import Role
from benchtool.protocol.dictionary.variable import Variable
from benchtool.shipped import shipped
from tests.third_party_drives import stripped_eds, third_party_eds

OWN = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
FOREIGN = Dictionary.from_bytes(stripped_eds(), 1, "vendor.eds")


def node(dictionary: Dictionary, raw: Mapping[tuple[int, int], int] | None = None) -> Any:
    """A drive whose objects hold these raw numbers."""

    def number(variable: Variable) -> float:
        value = variable.decode((raw or {})[variable.key].to_bytes(variable.type.bits // 8, "little"))
        assert isinstance(value, int | float)
        return value

    return SimpleNamespace(dictionary=dictionary, number=number)


RATED_MNM, RATED_MA = 9550, 6700
HOLDING = {(0x6076, 0): RATED_MNM, (0x6075, 0): RATED_MA}


@pytest.mark.parametrize(
    ("quantity", "step"),
    [
        (TORQUE_SETPOINT, RATED_MNM * 1e-6),
        (TORQUE, RATED_MNM * 1e-6),
        (CURRENT, RATED_MA * 1e-6),
        (DC_LINK_VOLTAGE, 1e-3),
        (RATED_TORQUE, 1e-3),
        (RATED_CURRENT, 1e-3),
    ],
)
@pytest.mark.parametrize("stated", [False, True])
def test_a_raw_step_of_the_standards_objects(quantity: Quantity, step: float, stated: bool) -> None:
    """As the standard has them, and as an EDS with units and factors says the same."""
    variables = {key: each for key, each in OWN.variables.items() if each.index >= 0x6000}
    dictionary = replace(OWN, variables=variables) if stated else FOREIGN
    variable = in_si(node(dictionary, HOLDING), quantity)
    assert variable.unit == quantity.unit
    assert variable.key == quantity.role.key
    assert variable.factor == pytest.approx(step, rel=1e-12)


@given(torque_Nm=st.floats(-25.0, 25.0), rated_mNm=st.integers(1000, 100_000))
def test_a_setpoint_comes_back_to_half_a_step(torque_Nm: float, rated_mNm: int) -> None:
    setpoint = in_si(node(FOREIGN, {(0x6076, 0): rated_mNm}), TORQUE_SETPOINT)
    kept = setpoint.decode(setpoint.encode(torque_Nm))
    assert isinstance(kept, float)
    assert math.isclose(kept, torque_Nm, rel_tol=1e-9, abs_tol=0.5e-6 * rated_mNm * (1 + 1e-9))


@pytest.mark.parametrize("quantity", [TORQUE_SETPOINT, SPEED_SETPOINT, TORQUE, SPEED, DC_LINK_VOLTAGE])
def test_benchtools_own_object_goes_before_the_standards_and_takes_no_reading(quantity: Quantity) -> None:
    assert is_own(OWN, quantity)
    assert in_si(node(OWN), quantity) is OWN[quantity.own]
    assert not is_own(FOREIGN, quantity)
    redirected = replace(OWN, redirected={quantity.role: OWN[quantity.own]})
    assert not is_own(redirected, quantity)
    of_another_unit = {**OWN.variables, quantity.own: replace(OWN[quantity.own], unit="furlong")}
    assert not is_own(replace(OWN, variables=of_another_unit), quantity)


@pytest.mark.parametrize(
    ("unit", "factor", "step"),
    [
        ("rad/s", 0.5, 0.5),
        ("rpm", 1.0, math.pi / 30),
        ("rpm", 0.1, math.pi / 300),
        ("deg/s", 1.0, math.pi / 180),
    ],
)
def test_a_profile_states_the_unit_of_a_speed(unit: str, factor: float, step: float) -> None:
    stated = replace(FOREIGN[Role.TARGET_VELOCITY], unit=unit, factor=factor)
    variable = in_si(node(replace(FOREIGN, redirected={Role.TARGET_VELOCITY: stated})), SPEED_SETPOINT)
    assert variable.unit == "rad/s"
    assert variable.factor == pytest.approx(step)


@pytest.mark.parametrize(
    ("eds", "quantity", "raw", "said"),
    [
        (stripped_eds(), SPEED_SETPOINT, {}, r"\(0x60FF:0\) in units of its own"),
        (
            stripped_eds(),
            TORQUE,
            {(0x6076, 0): 0},
            r"per mille of 0x6076:0 motor_rated_torque, which reads 0;",
        ),
        (stripped_eds(without=["6076"]), TORQUE, {}, "per mille, and no 0x6076:0 motor_rated_torque"),
        (stripped_eds(without=["6077"]), TORQUE, {}, "has no 0x6077:0 torque_actual"),
        (third_party_eds(), CURRENT, {}, "has no 0x6078:0 current_actual"),
        (third_party_eds(changed={"606C": {"Unit": "inc/s"}}), SPEED, {}, r"\(0x606C:0\) in 'inc/s'"),
        (
            third_party_eds(changed={"6077": {"Unit": "inc"}}),
            TORQUE,
            {(0x6076, 0): 1},
            r"\(0x6077:0\) in 'inc'",
        ),
    ],
)
def test_what_nothing_says_is_not_guessed(
    eds: bytes, quantity: Quantity, raw: dict[tuple[int, int], int], said: str
) -> None:
    dictionary = Dictionary.from_bytes(eds, 1, "vendor.eds")
    with pytest.raises(CapabilityMissing, match=said) as refused:
        in_si(node(dictionary, raw), quantity)
    assert f"[roles] {quantity.role.title} = " in str(refused.value)
    assert quantity.unit in str(refused.value)
