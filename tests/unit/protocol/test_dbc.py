"""Messages of a DBC file against bytes that were packed by hand."""

from __future__ import annotations

import math
import struct
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from benchtool.errors import ProfileError
from benchtool.protocol.dbc import DbcMessage

DBC = """VERSION ""
NS_ :
BS_:
BU_: Sensor Host

BO_ 801 Torque: 8 Sensor
 SG_ count : 0|8@1+ (1,0) [0|255] "" Host
 SG_ torque : 8|16@1- (0.002,-1) [-20|20] "Nm" Host
 SG_ speed : 39|16@0+ (0.1,0) [0|0] "rpm" Host

BO_ 802 Real: 4 Sensor
 SG_ torque : 0|32@1- (1,0) [-20|20] "Nm" Host

BO_ 803 Selected: 8 Sensor
 SG_ which M : 0|8@1+ (1,0) [0|1] "" Host
 SG_ torque m0 : 8|16@1- (0.001,0) [0|0] "Nm" Host
 SG_ power m1 : 8|16@1- (1,0) [0|0] "W" Host

SIG_VALTYPE_ 802 torque : 1;
"""


_message = cache(DbcMessage)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("dbc") / "torque.dbc"
    path.write_text(DBC, encoding="utf-8")
    return path


@given(count=st.integers(0, 255), raw=st.integers(-32768, 32767), speed=st.integers(0, 65535))
def test_bytes_that_were_packed_by_hand(path: Path, count: int, raw: int, speed: int) -> None:
    message = _message(path, "Torque", ("torque", "count", "speed"))
    data = struct.pack("<Bhx", count, raw) + struct.pack(">Hxx", speed)
    values = message.decode(data)
    assert values is not None
    assert values["count"] == count
    assert values["torque"] == pytest.approx(0.002 * raw - 1.0, abs=1e-12)
    assert values["speed"] == pytest.approx(0.1 * speed, abs=1e-9)
    assert message.decode(data + b"\0\0") == values, "CAN FD pads"


@given(data=st.binary(max_size=64))
def test_no_bytes_raise(path: Path, data: bytes) -> None:
    for name, signals in (("Torque", ("torque", "speed")), ("Real", ("torque",)), ("Selected", ("torque",))):
        values = _message(path, name, signals).decode(data)
        assert values is None or set(values) == set(signals)
        assert values is None or len(data) >= (4 if name == "Real" else 8)


def test_a_multiplexer_that_selects_another_signal_is_no_such_message(path: Path) -> None:
    message = _message(path, "Selected", ("torque",))
    assert dict(message.decode(bytes([0, 10, 0, 0, 0, 0, 0, 0])) or {}) == {"torque": pytest.approx(0.01)}
    assert message.decode(bytes([1, 10, 0, 0, 0, 0, 0, 0])) is None


@pytest.mark.parametrize(
    ("value", "held"), [(20.0, True), (-20.0, True), (20.1, False), (math.nan, False), (math.inf, False)]
)
def test_the_range_of_a_signal(path: Path, value: float, held: bool) -> None:
    message = _message(path, "Real", ("torque",))
    values = message.decode(struct.pack("<f", value))
    assert values is not None
    assert message.ranges["torque"].holds(values["torque"]) is held


def test_a_signal_without_a_range_holds_every_number(path: Path) -> None:
    speed = _message(path, "Torque", ("speed",)).ranges["speed"]
    assert speed.holds(6553.5)
    assert not speed.holds(math.nan)


def test_what_is_emulated_decodes_to_the_same(path: Path) -> None:
    message = _message(path, "Torque", ("torque", "count"))
    assert message.decode(message.encode({"torque": 1.2345, "count": 7})) == {
        "torque": pytest.approx(1.2345, abs=0.001),
        "count": 7,
    }
    held = message.decode(message.encode({"torque": 99.0, "count": 0}))
    assert held is not None
    assert held["torque"] == pytest.approx(20.0), "an instrument saturates"


@pytest.mark.parametrize(
    ("message", "signal", "said"),
    [
        ("Torqe", "torque", "has no message 'Torqe': did you mean 'Torque'?"),
        ("Torque", "torqe", "message 'Torque' has no signal 'torqe': did you mean 'torque'?"),
    ],
)
def test_names_that_are_not_there(path: Path, message: str, signal: str, said: str) -> None:
    with pytest.raises(ProfileError) as refused:
        _message(path, message, (signal,))
    assert said in str(refused.value)


@pytest.mark.parametrize("content", [b"", b"title = 3", b"\xff\xfe\x00", b"BO_ 1 X: 8 A\n SG_ a : 0|99@1+"])
def test_a_file_that_is_no_dbc_file_is_a_line(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "x.dbc"
    path.write_bytes(content)
    with pytest.raises(ProfileError) as refused:
        _message(path, "Torque", ("torque",))
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)
    with pytest.raises(ProfileError, match="cannot read"):
        DbcMessage(tmp_path / "none.dbc", "Torque", ("torque",))
