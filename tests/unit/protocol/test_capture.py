"""The data of an on-drive capture: encoded and decoded exactly, damage is detected."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.errors import CaptureError
from benchtool.protocol.capture_data import (
    HEADER_SIZE,
    CaptureHeader,
    decode_capture,
    decode_header,
    encode_capture,
)
from benchtool.protocol.dictionary.objects import DataType
from benchtool.protocol.dictionary.variable import Variable

TICK = Variable(0x2030, 1, "tick", DataType.U32)
TORQUE = Variable(0x2030, 12, "torque", DataType.F32, unit="Nm")
SPEED = Variable(0x606C, 0, "velocity_actual", DataType.I32, unit="rad/s", factor=0.001)
CHANNELS = (TICK, TORQUE, SPEED)

HEADER = CaptureHeader(
    n_channels=3, stride=2, tick_period_ns=100_000, rows=2, first_tick=7, trigger_tick=9, sequence=4
)
ROWS = b"".join(
    np.array(value, dtype=type_).tobytes()
    for value, type_ in ((7, "<u4"), (0.65, "<f4"), (-15710, "<i4"), (9, "<u4"), (-1.5, "<f4"), (3, "<i4"))
)
DATA = encode_capture(HEADER, ROWS)


def test_layout_byte_by_byte() -> None:
    assert DATA[:28] == bytes.fromhex("42544331 0300 0200 a0860100 02000000 07000000 09000000 04000000")
    assert DATA[HEADER_SIZE:] == ROWS
    assert len(DATA) == 32 + 2 * 3 * 4


def test_decoded_block() -> None:
    block = decode_capture(DATA, CHANNELS, sequence=4)
    assert block.names == ("tick", "torque", "velocity_actual")
    assert [channel.unit for channel in block.channels] == ["", "Nm", "rad/s"]
    assert (block.first_tick, block.stride, block.tick_s) == (7, 2, 1e-4)
    assert block.data.dtype == np.float64
    np.testing.assert_allclose(block.data, [[7, 0.65, -15.71], [9, -1.5, 0.003]], rtol=1e-7)
    assert block.gaps == ()
    assert decode_header(DATA) == HEADER


@given(
    header=st.builds(
        CaptureHeader,
        n_channels=st.integers(1, 16),
        stride=st.integers(1, 0xFFFF),
        tick_period_ns=st.integers(1, 0xFFFFFFFF),
        rows=st.integers(1, 20),
        first_tick=st.integers(0, 0xFFFFFFFF),
        trigger_tick=st.integers(0, 0xFFFFFFFF),
        sequence=st.integers(0, 0xFFFFFFFF),
    ),
    seed=st.integers(0, 2**32 - 1),
)
def test_round_trip(header: CaptureHeader, seed: int) -> None:
    shape = header.rows, header.n_channels
    words = np.random.default_rng(seed).integers(0, 2**32, size=shape, dtype=np.uint32)
    data = encode_capture(header, words.astype("<u4").tobytes())
    assert decode_header(data) == header
    block = decode_capture(data, [TICK] * header.n_channels, header.sequence)
    np.testing.assert_array_equal(block.data, words)
    assert (block.first_tick, block.stride) == (header.first_tick, header.stride)
    assert block.tick_s == header.tick_period_ns / 1e9


@pytest.mark.parametrize("length", range(len(DATA)))
def test_every_truncation_is_refused(length: int) -> None:
    with pytest.raises(CaptureError, match=f"came with {length} bytes"):
        decode_capture(DATA[:length], CHANNELS, sequence=4)


@pytest.mark.parametrize("bit", range(8 * len(DATA)))
def test_every_flipped_bit_is_refused(bit: int) -> None:
    damaged = bytearray(DATA)
    damaged[bit // 8] ^= 1 << bit % 8
    with pytest.raises(CaptureError):
        decode_capture(bytes(damaged), CHANNELS, sequence=4)


@given(st.binary(max_size=100), st.booleans())
def test_any_bytes_are_refused_and_nothing_else_is_raised(noise: bytes, with_magic: bool) -> None:
    with pytest.raises(CaptureError):
        decode_capture(b"BTC1" + noise if with_magic else noise, CHANNELS, sequence=4)


def test_messages_name_what_was_seen_and_expected() -> None:
    with pytest.raises(CaptureError, match="capture 4, capture 5 was armed"):
        decode_capture(DATA, CHANNELS, sequence=5)
    with pytest.raises(CaptureError, match="has 3 channels, 2 were asked for"):
        decode_capture(DATA, CHANNELS[:2], sequence=4)
    with pytest.raises(CaptureError, match="torque is of type u16"):
        decode_capture(DATA, (TICK, replace(TORQUE, type=DataType.U16), SPEED), sequence=4)
    with pytest.raises(CaptureError, match="42544332, 42544331"):
        decode_capture(b"BTC2" + DATA[4:], CHANNELS, sequence=4)
    with pytest.raises(CaptureError, match="came with 57 bytes, its header tells of 56"):
        decode_capture(DATA + b"\0", CHANNELS, sequence=4)


@pytest.mark.parametrize("field", ["n_channels", "stride", "tick_period_ns", "rows"])
def test_a_zero_that_makes_no_sense_is_refused(field: str) -> None:
    header = replace(HEADER, **{field: 0})
    rows = bytes(4 * header.rows * header.n_channels)
    with pytest.raises(CaptureError, match="none may be 0"):
        decode_capture(encode_capture(header, rows), CHANNELS, sequence=4)
