"""Values as people type them: every unit of the dictionary, with prefixes, and one line for every mistake."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, strategies as st

from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary.objects import DataType, load_table
from benchtool.protocol.dictionary.quantity import parse_value, spellings
from benchtool.protocol.dictionary.variable import Value, Variable
from benchtool.shipped import shipped


def _variable(unit: str, type_: DataType = DataType.F32) -> Variable:
    return Variable(0x2000, 1, "x", type_, unit=unit)


LAW = Variable(0x2010, 1, "law", DataType.U8, values={"tpc": 0, "5": 1})


@pytest.mark.parametrize(
    ("unit", "text", "value"),
    [
        ("ohm", "0.123", 0.123),
        ("ohm", "0.123ohm", 0.123),
        ("ohm", " 123 mohm ", 0.123),
        ("ohm", "123mΩ", 0.123),
        ("H", "9.52mH", 0.00952),
        ("H", "9520uH", 0.00952),
        ("H", "9520 µH", 0.00952),
        ("Wb", "168.5 mVs", 0.1685),
        ("s", "100us", 1e-4),
        ("s", "-1.5e3ns", -1.5e-6),
        ("A", ".5kA", 500.0),
        ("rad", "5deg", math.radians(5.0)),
        ("rad", "-90°", -math.pi / 2.0),
        ("rad", "0.5 rev", math.pi),
        ("rad", "2mrad", 0.002),
        ("rad/s", "150 rpm", 5.0 * math.pi),
        ("rad/s", "1 rev/s", 2.0 * math.pi),
        ("kgm2", "13.1kgcm2", 13.1e-4),
        ("kgm2", "13.1 kg·cm²", 13.1e-4),
        ("kgm2", "13.1 g m²", 13.1e-3),
        ("Nms/rad", "40 mNms", 0.04),
        ("Nm/rad", "400mNm/rad", 0.4),
        ("T_N", "0.5 T_N", 0.5),
        ("", "0x10", 16),
        ("", "-4", -4),
        ("", "1e3", 1000.0),
    ],
)
def test_a_value_in_the_dictionarys_unit(unit: str, text: str, value: Value) -> None:
    parsed = parse_value(_variable(unit), text)
    assert isinstance(parsed, int | float)
    assert parsed == pytest.approx(value, rel=1e-15, abs=0.0)


def test_decimals_stay_what_they_are() -> None:
    for text, value in (("9.52mH", 0.00952), ("0.3 mH", 0.0003), ("81.65 mH", 0.08165)):
        assert parse_value(_variable("H"), text) == value


def test_names_of_an_enumeration_are_no_numbers() -> None:
    assert parse_value(LAW, " tpc ") == "tpc"
    assert LAW.encode(parse_value(LAW, "5")) == b"\x01"


@pytest.mark.parametrize(
    ("unit", "text", "expected"),
    [
        ("ohm", "5 V", "a value in ohm (or mohm, uohm, ...) is expected"),
        ("ohm", "5 mOhm", "ohm"),
        ("ohm", "5 m", "ohm"),
        ("rad/s", "5 Hz", "rpm"),
        ("kgm2", "5 mkgm2", "a value in kgm2 (or gm2, kgcm2, gcm2, ...)"),
        ("T_N", "5 mT_N", "a value in T_N is expected"),
        ("", "4 A", "a plain number is expected"),
        ("A", "0,5", "a value in A"),
        ("A", "five", "a number in A"),
        ("A", "", "a number in A"),
        ("A", "nan", "a number in A"),
        ("A", "1e99999999999999999999 A", "a finite number in A"),
        ("A", "5" * 80 + "V", "a value in A"),
    ],
)
def test_a_mistake_is_one_line_that_names_what_is_expected(unit: str, text: str, expected: str) -> None:
    with pytest.raises(ValueRefused) as refused:
        parse_value(_variable(unit), text)
    message = str(refused.value)
    assert message.startswith(f"x = {text[:40]!r}: ")
    assert expected in message
    assert "nothing was sent" in message
    assert "\n" not in message


def test_every_unit_of_the_dictionary_can_be_typed() -> None:
    units = {entry.unit for entry in load_table(shipped("firmware_protocol") / "objects.toml") if entry.unit}
    assert {"ohm", "H", "Wb", "Nm", "A", "V", "s", "rad", "rad/s", "kgm2", "Nms/rad"} <= units
    for unit in units:
        assert next(iter(spellings(unit))) == unit
        for spelt, scale in spellings(unit).items():
            parsed = parse_value(_variable(unit), f"2 {spelt}")
            assert isinstance(parsed, float)
            assert parsed == pytest.approx(2.0 * float(scale), rel=1e-15)


@given(st.text(max_size=12), st.sampled_from(["", "A", "rad", "kgm2", "rpm"]))
def test_any_text_is_a_number_or_refused(text: str, unit: str) -> None:
    try:
        parsed = parse_value(_variable(unit), text)
    except ValueRefused:
        return
    assert isinstance(parsed, int | float)


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_the_dictionarys_own_unit_changes_nothing(value: float) -> None:
    assert parse_value(_variable("V"), f"{value!r} V") == value
