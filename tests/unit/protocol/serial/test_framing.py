"""Frames: payloads are recovered exactly, and damage does not extend beyond a zero."""

from __future__ import annotations

import itertools
import random

import pytest
from hypothesis import given, strategies as st

from benchtool.errors import ValueRefused
from benchtool.protocol.serial import MAX_PAYLOAD, FrameSplitter, encode_frame
from tests.unit.protocol.serial.reference import VECTORS, frame

# Zeros and full runs are where stuffing does something.
PIECES = st.one_of(
    st.binary(max_size=12), st.binary(min_size=250, max_size=260).map(lambda data: data.replace(b"\0", b"\1"))
)
PAYLOADS = st.lists(PIECES, min_size=1, max_size=5).map(b"\0".join).filter(bool)
FRAMES = [bytes.fromhex(each["frame"]) for each in VECTORS["messages"]]


def cut(data: bytes, places: list[int]) -> list[bytes]:
    """Data in parts, cut at these places modulo its length."""
    ends = sorted({place % (len(data) + 1) for place in places} | {0, len(data)})
    return [data[start:end] for start, end in itertools.pairwise(ends)]


def outcome(parts: list[bytes], max_payload: int = MAX_PAYLOAD) -> tuple[list[bytes], tuple[int, ...]]:
    """Payloads of the parts fed one after the other, and all counters."""
    splitter = FrameSplitter(max_payload)
    payloads = [payload for part in parts for payload in splitter.feed(part)]
    counts = splitter.too_long, splitter.bad_stuffing, splitter.too_short, splitter.bad_crc
    assert splitter.dropped == sum(counts)
    assert splitter.frames == len(payloads)
    return payloads, counts


@given(st.lists(PAYLOADS, max_size=4), st.lists(st.integers(0, 10_000)))
def test_frames_come_back_however_they_are_cut(payloads: list[bytes], places: list[int]) -> None:
    line = b"".join(encode_frame(payload) for payload in payloads)
    assert outcome(cut(line, places)) == (payloads, (0, 0, 0, 0))


@given(PAYLOADS)
def test_a_frame_is_what_the_page_says(payload: bytes) -> None:
    assert encode_frame(payload) == frame(payload)
    assert encode_frame(payload).count(0) == 2


@given(
    st.lists(st.one_of(st.binary(max_size=300), st.sampled_from(FRAMES))), st.lists(st.integers(0, 10_000))
)
def test_any_bytes_have_one_meaning_and_the_next_frame_comes_through(
    line: list[bytes], places: list[int]
) -> None:
    data = b"".join(line)
    whole = outcome([data], 128)
    assert outcome(cut(data, places), 128) == whole
    assert outcome([data[place : place + 1] for place in range(len(data))], 128) == whole
    assert outcome([data, FRAMES[0]], 128)[0][-1] == outcome([FRAMES[0]])[0][0]


@given(st.binary(min_size=1, max_size=400))
def test_a_damaged_frame_is_never_a_message(data: bytes) -> None:
    """Whatever is between two zeros counts once, and counts as a message only if its frame is a right one."""
    pieces = [each for each in data.split(b"\0") if each]
    payloads, counts = outcome([data + b"\0"])
    assert len(payloads) + sum(counts) == len(pieces)
    for payload in payloads:
        assert frame(payload)[1:-1] in pieces or frame(payload)[1:-1] + b"\x01" in pieces


@pytest.mark.parametrize("good", FRAMES, ids=[each["name"] for each in VECTORS["messages"]])
def test_every_flip_of_one_bit_is_found(good: bytes) -> None:
    """All but those in the zeros around it, of which another may stand beside."""
    for bit in range(8, 8 * (len(good) - 1)):
        payloads, counts = outcome([flipped(good, bit), FRAMES[0]])
        assert payloads == outcome([FRAMES[0]])[0], bit
        assert sum(counts) >= 1


@pytest.mark.parametrize("good", [each for each in FRAMES if len(each) <= 16])
def test_every_flip_of_two_bits_is_found(good: bytes) -> None:
    for bits in itertools.combinations(range(8, 8 * (len(good) - 1)), 2):
        assert outcome([flipped(good, *bits)])[0] == [], bits


def test_flips_in_a_long_frame_are_found() -> None:
    source = random.Random(0)
    good = encode_frame(bytes(source.choices(range(256), k=1294)))
    for bit in range(8, 8 * (len(good) - 1)):
        assert outcome([flipped(good, bit)])[0] == [], bit
    for _ in range(3000):
        assert outcome([flipped(good, *source.sample(range(8, 8 * (len(good) - 1)), 2))])[0] == []


def flipped(data: bytes, *bits: int) -> bytes:
    changed = bytearray(data)
    for bit in bits:
        changed[bit // 8] ^= 1 << bit % 8
    return bytes(changed)


@pytest.mark.parametrize("byte", [0, 0x11])
@pytest.mark.parametrize("limit", [1, 128, 249, 250, 251, 1000, MAX_PAYLOAD])
def test_the_longest_payload_and_one_more(limit: int, byte: int) -> None:
    longest = bytes([byte]) * limit
    assert outcome([encode_frame(longest)], limit) == ([longest], (0, 0, 0, 0))
    longer = frame(bytes([byte]) * (limit + 1))
    assert outcome([longer], limit) == ([], (1, 0, 0, 0))
    assert outcome([bytes([each]) for each in longer] + [FRAMES[0]], max(limit, 8))[0] != []


def test_a_frame_is_too_long_from_its_first_byte_too_many_on() -> None:
    """128 bytes, 4 of CRC, and one of stuffing can be."""
    splitter = FrameSplitter(128)
    splitter.feed(b"\x55" * 133)
    assert splitter.dropped == 0
    splitter.feed(b"\x55")
    assert splitter.too_long == splitter.dropped == 1


def test_a_line_without_zeros_holds_no_memory() -> None:
    splitter = FrameSplitter(128)
    for _ in range(1000):
        assert splitter.feed(b"\x55" * 100) == []
    assert splitter.too_long == splitter.dropped == 1
    assert len(splitter._begun) <= 140
    assert splitter.feed(b"\0" + FRAMES[0]) != []


@pytest.mark.parametrize("length", [0, MAX_PAYLOAD + 1])
def test_what_fits_no_frame_is_refused(length: int) -> None:
    with pytest.raises(ValueRefused, match=f"a message of {length} bytes, 1 to 4096 fit"):
        encode_frame(bytes(length))
