"""Values to bytes and back: units, factors, enumerations, limits."""

from __future__ import annotations

import math
import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.errors import DictionaryMismatch, ValueRefused
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.variable import Value, Variable

RESISTANCE = Variable(
    0x2000, 2, "R_s", DataType.F32, unit="ohm", raw_minimum=0.0, raw_maximum=100.0, raw_default=0.1
)
INDUCTANCE = Variable(0x2000, 3, "L_d", DataType.F32, unit="H", raw_minimum=1e-6, raw_maximum=1.0)
PERIOD = Variable(
    0x1017, 0, "heartbeat", DataType.U16, unit="s", factor=0.001, raw_minimum=0, raw_maximum=60000
)
MODE = Variable(
    0x6060, 0, "mode", DataType.I8, raw_default=4, values={"velocity": 3, "torque": 4, "homing": -1}
)
COUNT = Variable(0x2040, 3, "rows", DataType.U32)
NAME = Variable(0x1008, 0, "device_name", DataType.STRING, raw_default="drive")
BLOB = Variable(0x2042, 0, "capture_data", DataType.DOMAIN)


@pytest.mark.parametrize(
    ("variable", "value", "data"),
    [
        (RESISTANCE, 0.123, struct.pack("<f", 0.123)),
        (RESISTANCE, "0.123", struct.pack("<f", 0.123)),
        (RESISTANCE, 100, struct.pack("<f", 100.0)),
        (INDUCTANCE, 1e-6, struct.pack("<f", 1e-6)),
        (PERIOD, 0.1, b"\x64\x00"),
        (PERIOD, 0.1004, b"\x64\x00"),
        (PERIOD, 60.0, b"\x60\xea"),
        (MODE, "torque", b"\x04"),
        (MODE, 3, b"\x03"),
        (MODE, "3", b"\x03"),
        (MODE, "homing", b"\xff"),
        (COUNT, 0xFFFFFFFF, b"\xff\xff\xff\xff"),
        (COUNT, "0x10", b"\x10\x00\x00\x00"),
        (COUNT, 3.0, b"\x03\x00\x00\x00"),
        (NAME, "Prüfstand", "Prüfstand".encode()),
        (BLOB, b"\x00\x01", b"\x00\x01"),
    ],
)
def test_encode(variable: Variable, value: Value, data: bytes) -> None:
    assert variable.encode(value) == data


@pytest.mark.parametrize(
    ("variable", "data", "value"),
    [
        (RESISTANCE, struct.pack("<f", 0.123), 0.123),
        (PERIOD, b"\x64\x00", 0.1),
        (MODE, b"\x04", "torque"),
        (MODE, b"\xff", "homing"),
        (MODE, b"\x09", 9),
        (COUNT, b"\xff\xff\xff\xff", 0xFFFFFFFF),
        (NAME, b"drive\0\0", "drive"),
        (NAME, b"\xff", "\N{REPLACEMENT CHARACTER}"),
        (BLOB, b"\x00\x01", b"\x00\x01"),
    ],
)
def test_decode(variable: Variable, data: bytes, value: Value) -> None:
    assert variable.decode(data) == value


@pytest.mark.parametrize(
    ("variable", "value", "message"),
    [
        (RESISTANCE, -0.1, "R_s = -0.1 ohm: its limits are 0 to 100 ohm"),
        (RESISTANCE, 100.001, "R_s = 100.001 ohm: its limits are 0 to 100 ohm"),
        (INDUCTANCE, 9.9e-7, "L_d = 9.9e-07 H: its limits are 1e-06 to 1 H"),
        (PERIOD, 60.001, "heartbeat = 60.001 s: its limits are 0 to 60 s"),
        (PERIOD, -1, "heartbeat = -1: its limits are 0 to 60 s"),
        (COUNT, -1, "rows = -1: its limits are 0 to 4294967295"),
        (COUNT, 1.5, "rows = 1.5: a whole number is expected"),
        (COUNT, "many", "rows = 'many': a number is expected"),
        (COUNT, b"\x01", "a number is expected"),
        (MODE, "torq", "mode = 'torq': one of velocity, torque, homing is expected"),
        (MODE, 7, "mode = 7: the values are velocity, torque, homing"),
        (RESISTANCE, math.nan, "R_s = nan ohm: a finite number is expected"),
        (RESISTANCE, math.inf, "a finite number is expected"),
        (RESISTANCE, 10**400, "a finite number is expected"),
        (replace(RESISTANCE, raw_maximum=None), 1e39, "a 32-bit float does not reach that far"),
        (NAME, 3, "text or bytes are expected"),
    ],
)
def test_refusals_name_variable_value_limits_and_unit(variable: Variable, value: Value, message: str) -> None:
    with pytest.raises(ValueRefused) as refused:
        variable.encode(value)
    text = str(refused.value)
    assert message in text
    assert "nothing was sent" in text
    assert "\n" not in text
    assert len(text) < 200


@pytest.mark.parametrize("type_", [type_ for type_ in DataType if type_.bits])
def test_a_wrong_length_is_named(type_: DataType) -> None:
    variable = replace(COUNT, type=type_)
    for length in set(range(10)) - {type_.bits // 8}:
        with pytest.raises(DictionaryMismatch, match=rf"rows \(0x2040:3\) came with {length} bytes"):
            variable.decode(bytes(length))


@given(st.sampled_from([type_ for type_ in DataType if type_.bits]), st.binary(min_size=8, max_size=8))
def test_every_raw_value_comes_back_as_the_same_bytes(type_: DataType, noise: bytes) -> None:
    variable = replace(COUNT, type=type_)
    data = noise[: type_.bits // 8]
    value = variable.decode(data)
    assert isinstance(value, int | float)
    if abs(value) < 1e300:
        assert variable.encode(value) == data


@given(st.integers(0, 60000))
def test_a_factor_loses_no_step(raw: int) -> None:
    assert PERIOD.encode(PERIOD.decode(struct.pack("<H", raw))) == struct.pack("<H", raw)


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_a_float_reads_as_the_shortest_decimal_of_the_same_float(value: float) -> None:
    variable = replace(RESISTANCE, raw_minimum=None, raw_maximum=None)
    read = variable.decode(variable.encode(value))
    assert isinstance(read, float)
    assert np.float32(read) == np.float32(value)
    assert len(repr(read)) <= len(repr(value))


def test_physical_limits_defaults_and_labels() -> None:
    assert (PERIOD.minimum, PERIOD.maximum) == (0, 60.0)
    assert (RESISTANCE.minimum, RESISTANCE.maximum, RESISTANCE.default) == (0.0, 100.0, 0.1)
    assert (COUNT.minimum, COUNT.maximum, COUNT.default) == (None, None, None)
    assert MODE.default == "torque"
    assert NAME.default == "drive"
    assert (RESISTANCE.key, RESISTANCE.label, RESISTANCE.mapping) == ((0x2000, 2), "0x2000:2", 0x20000220)


@pytest.mark.parametrize(
    ("access", "readable", "writable"),
    [("ro", True, False), ("rw", True, True), ("wo", False, True), ("const", True, False)],
)
def test_access(access: str, readable: bool, writable: bool) -> None:
    variable = replace(COUNT, access=access)
    assert (variable.readable, variable.writable) == (readable, writable)
