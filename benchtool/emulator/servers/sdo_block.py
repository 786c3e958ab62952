"""The server's side of SDO block transfer, as state machines without I/O (CiA 301, 7.2.4.3.9 to 7.2.4.3.16).

A transfer goes in sub-blocks of up to 127 segments of seven bytes. Each segment carries its number within
the sub-block; the receiver acknowledges the last one that came in order, and the sender goes on after it.
The CRC-16 is that of `binascii.crc_hqx` with initial value 0, over the data without padding (7.2.4.3.16).
"""

from __future__ import annotations

import binascii

from canopen.sdo.exceptions import SdoAbortedError

from benchtool.protocol.canopen import LAST_SEGMENT, MAX_BLOCK_SIZE, SEGMENT_SIZE, Abort, Block, Response, sdo

_HEADERS = [bytes([value]) for value in range(256)]


class BlockUpload:
    """Data on their way to the client.

    Args:
        data: of any length; no data still make one, empty, segment.
        block_size: segments per sub-block, as the client asks for.
        crc: the client checks the CRC.

    Raises:
        canopen.SdoAbortedError: the block size is not in 1 to 127.
    """

    def __init__(self, data: bytes, block_size: int, crc: bool) -> None:
        self._size = _require_block_size(block_size)
        padded = data.ljust(max(1, -(-len(data) // SEGMENT_SIZE)) * SEGMENT_SIZE, b"\x00")
        self._segments = [padded[i : i + SEGMENT_SIZE] for i in range(0, len(padded), SEGMENT_SIZE)]
        self._unused = len(padded) - len(data)
        self._crc = binascii.crc_hqx(data, 0) if crc else 0
        self._position = 0
        self._sent = 0

    def sub_block(self) -> list[bytes]:
        """Return the frames of the present sub-block."""
        segments = self._segments[self._position : self._position + self._size]
        self._sent = len(segments)
        frames = [_HEADERS[number] + segment for number, segment in enumerate(segments, start=1)]
        if self._position + self._sent == len(self._segments):
            frames[-1] = _HEADERS[LAST_SEGMENT | self._sent] + segments[-1]
        return frames

    def acknowledge(self, last_in_order: int, block_size: int) -> bytes | None:
        """Take the client's acknowledgement; the end frame when it has everything, else None.

        Raises:
            canopen.SdoAbortedError: more is acknowledged than was sent, or the new block size is wrong.
        """
        if last_in_order > self._sent:
            raise SdoAbortedError(Abort.SEQUENCE_NUMBER)
        self._position += last_in_order
        if self._position == len(self._segments):
            return sdo.block_end(Response.BLOCK_UPLOAD, self._unused, self._crc)
        self._size = _require_block_size(block_size)
        return None


class BlockDownload:
    """Data on their way from the client.

    Args:
        size: announced number of bytes; None if the client does not say.
        crc: the client sends the CRC.
    """

    def __init__(self, size: int | None, crc: bool) -> None:
        self._announced = size
        self._crc = crc
        self._segments: list[bytes] = []
        self._in_order = 0
        self.complete = False

    def segment(self, frame: bytes) -> bytes | None:
        """Take one segment; the acknowledgement if it ends a sub-block, else None.

        Raises:
            canopen.SdoAbortedError: it has number 0, or there are more data than were announced.
        """
        number, last = frame[0] & ~LAST_SEGMENT, bool(frame[0] & LAST_SEGMENT)
        if number == 0:
            raise SdoAbortedError(Abort.SEQUENCE_NUMBER)
        if number == self._in_order + 1:
            self._in_order = number
            self._segments.append(frame[1:])
            self.complete = last
            if self._announced is not None and len(self._segments) > -(
                -max(1, self._announced) // SEGMENT_SIZE
            ):
                raise SdoAbortedError(Abort.LENGTH_HIGH)
        if not last and number < MAX_BLOCK_SIZE:
            return None
        acknowledged, self._in_order = self._in_order, 0
        command = Response.BLOCK_DOWNLOAD | Block.ACKNOWLEDGE
        return bytes([command, acknowledged, MAX_BLOCK_SIZE]).ljust(sdo.FRAME_SIZE, b"\x00")

    def finish(self, frame: bytes) -> bytes:
        """Return the data, from the client's end frame.

        Raises:
            canopen.SdoAbortedError: their length or their CRC is not what the client says.
        """
        command, crc = sdo.BLOCK_END.unpack(frame)
        joined = b"".join(self._segments)
        data = joined[: len(joined) - sdo.block_unused(command)]
        if self._announced is not None and len(data) != self._announced:
            raise SdoAbortedError(Abort.LENGTH)
        if self._crc and crc != binascii.crc_hqx(data, 0):
            raise SdoAbortedError(Abort.CRC)
        return data


def _require_block_size(size: int) -> int:
    if not 1 <= size <= MAX_BLOCK_SIZE:
        raise SdoAbortedError(Abort.BLOCK_SIZE)
    return size
