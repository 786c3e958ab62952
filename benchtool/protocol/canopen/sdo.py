"""SDO on the wire: command specifiers, their flags, and the layout of the frames (CiA 301, 7.2.4.3).

The upper three bits of the first byte are the specifier, which client and server number differently; the
others are flags whose meaning depends on it.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Final

FRAME_SIZE: Final = 8
SPECIFIER: Final = 0xE0
"""Bits of the first byte that are the command specifier."""


class Request(IntEnum):
    """Command specifiers of the client, ccs."""

    DOWNLOAD_SEGMENT = 0x00
    DOWNLOAD = 0x20
    UPLOAD = 0x40
    UPLOAD_SEGMENT = 0x60
    BLOCK_UPLOAD = 0xA0
    BLOCK_DOWNLOAD = 0xC0


class Response(IntEnum):
    """Command specifiers of the server, scs."""

    UPLOAD_SEGMENT = 0x00
    DOWNLOAD_SEGMENT = 0x20
    UPLOAD = 0x40
    DOWNLOAD = 0x60
    BLOCK_DOWNLOAD = 0xA0
    BLOCK_UPLOAD = 0xC0


ABORT: Final = 0x80
"""Common to client and server."""

SIZE_INDICATED: Final = 0x01
"""Of an initiate: the number of bytes is given, in bits 2 and 3 if it is expedited (as those unused)."""

EXPEDITED: Final = 0x02
NO_MORE_SEGMENTS: Final = 0x01
TOGGLE: Final = 0x10


class Block(IntEnum):
    """Subcommands of block transfer, bits 0 and 1 (bit 0 alone of a client's block download)."""

    INITIATE = 0
    END = 1
    ACKNOWLEDGE = 2
    START_UPLOAD = 3


BLOCK_SUBCOMMAND: Final = 0x03
BLOCK_SIZE_INDICATED: Final = 0x02
BLOCK_CRC: Final = 0x04
"""Of an initiate: the sender supports the CRC."""

LAST_SEGMENT: Final = 0x80
"""Bit of a block segment's first byte, whose others are its number within the sub-block."""

SEGMENT_SIZE: Final = 7
MAX_BLOCK_SIZE: Final = 127
"""Segments of a sub-block."""

INITIATE: Final = struct.Struct("<BHBL")
"""Command, index, sub-index; a number of bytes, or the bytes of an expedited transfer."""

BLOCK_END: Final = struct.Struct("<BH5x")
"""Command with the unused bytes of the last segment in bits 2 to 4, and the CRC-16 of the data."""

ABORT_CODE: Final = struct.Struct("<L")


def expedited(specifier: int, size: int) -> int:
    """Return the command of an expedited transfer of `size` bytes, 1 to 4, which it indicates."""
    return specifier | EXPEDITED | SIZE_INDICATED | (4 - size) << 2


def expedited_data(frame: bytes) -> bytes:
    """Return bytes that an expedited transfer brings; all four if it does not say how many of them count."""
    unused = frame[0] >> 2 & 0x03 if frame[0] & SIZE_INDICATED else 0
    return frame[4 : FRAME_SIZE - unused]


def segment(specifier: int, toggle: int, data: bytes, *, last: bool) -> bytes:
    """Return a frame of segmented transfer with at most seven bytes of data."""
    command = specifier | toggle | (SEGMENT_SIZE - len(data)) << 1 | (NO_MORE_SEGMENTS if last else 0)
    return bytes([command]) + data.ljust(SEGMENT_SIZE, b"\x00")


def segment_data(frame: bytes) -> bytes:
    """Return the bytes that a frame of segmented transfer brings."""
    return frame[1 : FRAME_SIZE - (frame[0] >> 1 & 0x07)]


def block_end(specifier: int, unused: int, crc: int) -> bytes:
    """Return the frame that ends a block transfer."""
    return BLOCK_END.pack(specifier | Block.END | unused << 2, crc)


def block_unused(command: int) -> int:
    """Return the number of unused bytes of the last segment, by the command that ends a block transfer."""
    return command >> 2 & 0x07


def key(frame: bytes) -> tuple[int, int]:
    """Return the index and sub-index in an initiate or an abort."""
    return int.from_bytes(frame[1:3], "little"), frame[3]


def initiates(command: int) -> bool:
    """Return whether a request names an object, which its answer then repeats."""
    match command & SPECIFIER:
        case Request.DOWNLOAD | Request.UPLOAD:
            return True
        case Request.BLOCK_UPLOAD:
            return command & BLOCK_SUBCOMMAND == Block.INITIATE
        case Request.BLOCK_DOWNLOAD:
            return not command & Block.END
    return False
