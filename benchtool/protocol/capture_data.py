"""The data of an on-drive capture, object 0x2042: a header of 32 bytes and the rows, little-endian.

    offset  0  magic "BTC1"          12  rows u32             24  sequence u32
            4  n_channels u16        16  first_tick u32       28  crc u32
            6  stride u16 (ticks)    20  trigger_tick u32     32  rows of n_channels values, 4 bytes each
            8  tick_period_ns u32

`crc` is the CRC-32 of IEEE 802.3 (zlib's) over the 28 bytes before it and all rows. Values are u32 or f32, as
the captured signals are.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.block import Block, Channel
from benchtool.errors import CaptureError
from benchtool.protocol.dictionary.variable import Variable

MAGIC = b"BTC1"
HEADER_SIZE = 32
MOST_VALUES = 1_000_000
"""Capacity of the reference drive: rows times channels (`capture_rows`)."""

_VALUE_SIZE = 4
_HEADER = struct.Struct("<4sHHIIIII")
_CRC = struct.Struct("<I")


@dataclass(frozen=True)
class CaptureHeader:
    """Fields of the header; the ticks are those of the drive and wrap at 2**32."""

    n_channels: int
    stride: int
    tick_period_ns: int
    rows: int
    first_tick: int
    trigger_tick: int
    sequence: int


def encode_capture(header: CaptureHeader, rows: bytes) -> bytes:
    """Return the data as the drive offers them; `rows` has header.rows times header.n_channels values."""
    head = _HEADER.pack(MAGIC, *astuple(header))
    return head + _CRC.pack(zlib.crc32(rows, zlib.crc32(head))) + rows


def decode_header(data: bytes) -> CaptureHeader:
    """Return the header of a capture whose length and checksum hold.

    Raises:
        CaptureError: too short, not a capture, inconsistent or damaged.
    """
    if len(data) < HEADER_SIZE:
        raise CaptureError(
            f"the capture came with {len(data)} bytes, its header alone has {HEADER_SIZE}: capture again"
        )
    magic, *fields = _HEADER.unpack_from(data)
    if magic != MAGIC:
        raise CaptureError(
            f"the capture begins with {magic.hex()}, {MAGIC.hex()} (BTC1) is expected: "
            f"the firmware's capture format is not this tool's, update the older of the two"
        )
    header = CaptureHeader(*fields)
    expected = HEADER_SIZE + header.rows * header.n_channels * _VALUE_SIZE
    if len(data) != expected:
        raise CaptureError(
            f"the capture came with {len(data)} bytes, its header tells of {expected} "
            f"({header.rows} rows of {header.n_channels} values): read it again"
        )
    (crc,) = _CRC.unpack_from(data, _HEADER.size)
    seen = zlib.crc32(memoryview(data)[HEADER_SIZE:], zlib.crc32(data[: _HEADER.size]))
    if seen != crc:
        raise CaptureError(
            f"the capture's checksum is 0x{seen:08X}, 0x{crc:08X} is expected: it was damaged, read it again"
        )
    if 0 in (header.n_channels, header.stride, header.tick_period_ns, header.rows):
        raise CaptureError(
            f"the capture tells of {header.rows} rows, {header.n_channels} channels, stride {header.stride} "
            f"and {header.tick_period_ns} ns per tick, none may be 0: update the firmware"
        )
    return header


def decode_capture(data: bytes, channels: Sequence[Variable], sequence: int) -> Block:
    """Return the rows of a capture as a Block, in units of the channels.

    Args:
        data: object 0x2042 as read.
        channels: the captured signals, in order.
        sequence: `capture_sequence` of the capture that was armed.

    Raises:
        CaptureError: damaged, of another capture, or of other channels; names what was seen and expected.
    """
    header = decode_header(data)
    if header.sequence != sequence:
        raise CaptureError(
            f"the data are of capture {header.sequence}, capture {sequence} was armed: "
            f"another host armed one, capture again"
        )
    if header.n_channels != len(channels):
        raise CaptureError(
            f"the capture has {header.n_channels} channels, {len(channels)} were asked for: capture again"
        )
    words = np.frombuffer(data, dtype="<u4", offset=HEADER_SIZE).reshape(header.rows, header.n_channels)
    columns = [_column(words[:, number], channel) for number, channel in enumerate(channels)]
    return Block(
        channels=tuple(Channel(channel.name, channel.unit) for channel in channels),
        first_tick=header.first_tick,
        stride=header.stride,
        tick_s=header.tick_period_ns / 1e9,
        data=np.stack(columns, axis=1),
    )


def _column(words: NDArray[np.uint32], channel: Variable) -> NDArray[np.float64]:
    if channel.type.numpy is None or channel.type.numpy.itemsize != _VALUE_SIZE:
        raise CaptureError(
            f"channel {channel.name} is of type {channel.type}, a capture has values of four bytes: "
            f"choose signals of four bytes"
        )
    column = np.ascontiguousarray(words).view(channel.type.numpy).astype(np.float64)
    return column if channel.factor == 1 else column * channel.factor
