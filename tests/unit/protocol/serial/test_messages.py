"""Messages: encoding and decoding are inverse, invalid bytes are refused, and nothing raises."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given, strategies as st

from benchtool.errors import ValueRefused
from benchtool.protocol import serial as wire
from benchtool.protocol.canopen.emcy import Emergency
from tests.unit.protocol.serial.reference import VECTORS

U8, U16, U32 = (st.integers(0, (1 << bits) - 1) for bits in (8, 16, 32))
F32 = st.floats(width=32, allow_nan=False)
DATA = st.binary(min_size=1, max_size=40)
REFUSAL = st.integers(1, 0xFFFFFFFF)
CHANNELS = st.lists(U32, max_size=20).map(tuple)

REQUESTS: st.SearchStrategy[wire.Message] = st.one_of(
    st.builds(wire.Identify, U8, U8),
    st.builds(wire.Read, U8, U16, U8),
    st.builds(wire.Write, U8, U16, U8, DATA),
    st.builds(wire.Open, U8, U16, U8),
    st.builds(wire.Chunks, U8, U8, U32, U16),
    st.builds(wire.Stream, U8, U16, U8, st.just(0), CHANNELS),
    st.lists(st.tuples(U32, F32), max_size=20).flatmap(
        lambda pairs: st.builds(
            wire.Stream,
            *(U8, U16, U8, st.just(1)),
            st.just(tuple(mapping for mapping, _ in pairs)),
            st.just(tuple(scale for _, scale in pairs)),
        )
    ),
    st.builds(wire.Setpoint, U32, F32, F32),
    st.builds(wire.HostHeartbeat, U8, U8),
    st.builds(wire.Nmt, U8),
)
REPLIES: st.SearchStrategy[wire.Message] = st.one_of(
    st.builds(
        wire.Identity,
        *(U8, U32, st.just(1), U8, U8, U32, U32, U32, U32, U32, U32, U16, U16),
        st.text(max_size=60),
    ),
    st.builds(wire.Identity, *(U8, U32, st.integers(2, 255), U8, U8, U32)),
    st.builds(wire.ReadReply, U8, st.just(0), U16, U8, st.binary(max_size=40)),
    st.builds(wire.ReadReply, U8, REFUSAL, U16, U8),
    st.builds(wire.WriteReply, U8, U32, U16, U8),
    st.builds(wire.OpenReply, U8, U32, U16, U8, U8, U32, U16, U32),
    st.builds(wire.ChunkReply, U8, st.just(0), U8, U32, DATA),
    st.builds(wire.ChunkReply, U8, REFUSAL, U8, U32),
    st.builds(wire.StreamReply, U8, U32, U16, U32, U32),
    st.builds(wire.Heartbeat, U8, U32),
    st.tuples(st.integers(1, 255), DATA).flatmap(
        lambda shape: st.builds(
            wire.Batch, U16, U32, U32, U16, st.just(shape[0]), st.just(shape[1] * shape[0])
        )
    ),
    st.builds(wire.Event, U8, U32, st.builds(Emergency, U16, U8, st.binary(min_size=5, max_size=5))),
    st.builds(wire.Reject, U8, U8, U8),
)
PAYLOADS = [bytes.fromhex(each["payload"]) for each in VECTORS["messages"]]
OPEN_ENDED = (0x03, 0x42, 0x82, 0x85)  # types whose data may have any length


@given(REQUESTS)
def test_a_request_is_understood_by_the_drive_alone(message: wire.Message) -> None:
    payload = wire.encode_message(message)
    assert wire.decode_request(payload) == message
    assert wire.decode_reply(payload) is None


@given(REPLIES)
def test_a_reply_is_understood_by_the_host_alone(message: wire.Message) -> None:
    payload = wire.encode_message(message)
    assert wire.decode_reply(payload) == message
    assert wire.decode_request(payload) is None


@given(
    st.one_of(st.binary(max_size=60), st.sampled_from(PAYLOADS)), st.binary(max_size=3), st.integers(0, 60)
)
def test_no_bytes_raise_and_what_is_understood_is_what_was_said(
    data: bytes, more: bytes, length: int
) -> None:
    for payload in (data, data + more, data[:length]):
        request, reply = wire.decode_request(payload), wire.decode_reply(payload)
        assert request is None or reply is None
        if isinstance(request, wire.Reject):
            assert payload[0] in range(1, 16)
            assert request.type == payload[0]
            assert request.tag == (payload[1] if len(payload) > 1 else 0)
        elif request is not None and not isinstance(request, wire.Setpoint | wire.Stream):  # NaNs may differ
            assert wire.encode_message(request) == payload
        if reply is not None and not isinstance(reply, wire.Identity):  # whose name may be no UTF-8
            assert wire.encode_message(reply) == payload


@pytest.mark.parametrize("payload", PAYLOADS, ids=[each["name"] for each in VECTORS["messages"]])
def test_no_other_length_is_taken(payload: bytes) -> None:
    whole = wire.decode_request(payload) or wire.decode_reply(payload)
    for other in [payload[:length] for length in range(1, len(payload))] + [payload + b"\1"]:
        request, reply = wire.decode_request(other), wire.decode_reply(other)
        if isinstance(request, wire.Reject):
            assert request.reason == wire.RejectReason.WRONG_LENGTH
            continue
        found = request or reply
        assert found is None or (payload[0] in OPEN_ENDED and found != whole)


def test_an_identity_of_another_version_is_read_as_far_as_all_versions_agree() -> None:
    ours = wire.encode_message(wire.Identity(7, 0, 1, 3, 127, 0xA928D4B2, vendor_id=5, device_name="Drive"))
    for end in (14, 15, len(ours), len(ours) + 9):
        theirs = (ours + bytes(9))[:6] + b"\x02" + (ours + bytes(9))[7:end]
        assert wire.decode_reply(theirs) == wire.Identity(7, 0, 2, 3, 127, 0xA928D4B2)
    assert wire.decode_reply(ours[:6] + b"\x02" + ours[7:13]) is None


def test_a_name_that_is_no_text_does_not_hide_the_drive() -> None:
    payload = wire.encode_message(wire.Identity(7, 0, 1, 3, 127, 1, device_name="AB"))[:-1] + b"\xff"
    identity = wire.decode_reply(payload)
    assert isinstance(identity, wire.Identity)
    assert identity.device_name == "A\N{REPLACEMENT CHARACTER}"


def test_numbers_that_are_none_come_through_for_the_drive_to_refuse() -> None:
    setpoint = wire.decode_request(struct.pack("<BIff", 0x10, 1, float("nan"), float("inf")))
    assert isinstance(setpoint, wire.Setpoint)
    assert setpoint.torque_command_Nm != setpoint.torque_command_Nm
    assert setpoint.omega_m_command_rad_s == float("inf")


@pytest.mark.parametrize(
    ("message", "complaint"),
    [
        (wire.Read(256, 0x6041, 0), "Read cannot be sent"),
        (wire.Read(0, -1, 0), "Read cannot be sent"),
        (wire.Setpoint(0, 1e39, 0.0), "Setpoint cannot be sent"),
        (wire.Write(0, 0x6040, 0, b""), "Write with 0 bytes of data"),
        (wire.ReadReply(0, 1, 0x6041, 0, b"1"), "ReadReply with 1 bytes"),
        (wire.ChunkReply(0, 0, 1, 0), "ChunkReply with 0 bytes"),
        (wire.Batch(1, 0, 0, 1, 2, b"123"), "Batch with 3 bytes"),
        (wire.Stream(0, 1, 1, 1, (1, 2), (1.0,)), "1 scales for 2 channels of format 1, 2 are expected"),
        (wire.Stream(0, 1, 1, 0, (1, 2), (1.0, 1.0)), "2 scales for 2 channels of format 0, 0 are expected"),
        (wire.Stream(0, 1, 1, 2, (1,)), "format 2 of a stream"),
        (wire.Stream(0, 1, 1, 1, (1,), (1e39,)), "Stream cannot be sent"),
        (wire.Stream(0, 1, 1, 0, (0,) * 256), "Stream cannot be sent"),
        (wire.Identity(0, 0, 1, 1, 0, 0, device_name="é" * 128), "a device name of 256 bytes, 255 fit"),
        (wire.Event(256, 0, Emergency(0, 0)), "Event cannot be sent"),
    ],
)
def test_what_no_payload_can_say_is_refused(message: wire.Message, complaint: str) -> None:
    with pytest.raises(ValueRefused, match=complaint):
        wire.encode_message(message)
