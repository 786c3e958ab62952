"""Emergencies, SDO abort codes and network management messages."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from benchtool.protocol.canopen.abort import Abort, abort_text
from benchtool.protocol.canopen.emcy import Emergency, ErrorCode, error_register, error_text
from benchtool.protocol.canopen.nmt import NmtState, heartbeat_state


def test_emergency_on_the_wire() -> None:
    emergency = Emergency(ErrorCode.OVERCURRENT, 0x03, b"\x01\x02\x03\x04\x05")
    assert emergency.encode() == bytes.fromhex("1023 03 0102030405")
    assert Emergency.decode(emergency.encode()) == emergency
    assert emergency.text == "0x2310 continuous overcurrent at the output"
    assert Emergency(ErrorCode.NO_ERROR, 0, b"\x07").encode() == bytes.fromhex("0000 00 0700000000")


@given(st.binary(max_size=12))
def test_any_bytes_are_an_emergency_or_none(data: bytes) -> None:
    emergency = Emergency.decode(data)
    assert (emergency is None) == (len(data) != 8)
    if emergency is not None:
        assert emergency.encode() == data
        assert "\n" not in emergency.text


@pytest.mark.parametrize(
    ("code", "text", "register"),
    [
        (ErrorCode.NO_ERROR, "no error: all errors are reset", 0x00),
        (ErrorCode.OVERCURRENT, "continuous overcurrent at the output", 0x03),
        (ErrorCode.DC_LINK_OVERVOLTAGE, "dc link overvoltage", 0x05),
        (ErrorCode.DC_LINK_UNDERVOLTAGE, "dc link undervoltage", 0x05),
        (ErrorCode.PARAMETER, "parameter out of its limits", 0x01),
        (ErrorCode.HEARTBEAT, "heartbeat or life guarding lost", 0x11),
        (ErrorCode.OVERSPEED, "speed outside its limits", 0x01),
        (0x2345, "current at the output side", 0x03),
        (0x2999, "current", 0x03),
        (0x8299, "protocol error", 0x11),
        (0xFF42, "device specific", 0x81),
        (0xB123, "code without a standard meaning", 0x01),
    ],
)
def test_error_codes(code: int, text: str, register: int) -> None:
    assert (error_text(code), error_register(code)) == (text, register)


def test_every_error_code_has_a_text_of_its_own() -> None:
    texts = [error_text(code) for code in ErrorCode]
    assert len(set(texts)) == len(texts)


@given(st.integers(min_value=0, max_value=0xFFFFFFFF) | st.sampled_from(list(Abort)))
def test_every_abort_code_has_one_line_with_code_meaning_and_remedy(code: int) -> None:
    text = abort_text(code)
    assert text.startswith(f"0x{code:08X} ")
    assert "\n" not in text
    assert ("not a code of CiA 301" in text) == (code not in set(Abort))
    assert text.partition(": ")[2]


def test_abort_texts_of_the_ones_met_most() -> None:
    assert abort_text(0x06020000).startswith("0x06020000 object does not exist: the EDS does not fit")
    assert abort_text(Abort.DEVICE_STATE).endswith("disable the drive first")


def test_heartbeats() -> None:
    known = {heartbeat_state(bytes([value])) for value in range(256)}
    assert known == {None, *NmtState}
    assert heartbeat_state(b"\x05") is NmtState.OPERATIONAL
    assert heartbeat_state(b"\x85") is None
    assert heartbeat_state(b"") is None
    assert heartbeat_state(b"\x05\x05") is None
