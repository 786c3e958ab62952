"""Frames of the serial line: a payload with its CRC-32, byte-stuffed so that zero occurs between frames only.

    0x00, COBS(payload, CRC-32 of the payload as little-endian u32), 0x00

COBS: S. Cheshire and M. Baker, "Consistent Overhead Byte Stuffing", IEEE/ACM Transactions on Networking 7(2),
1999. CRC-32: IEEE 802.3, as zlib computes it.
"""

from __future__ import annotations

import zlib

from cobs import cobs

from benchtool.errors import ValueRefused

MAX_PAYLOAD = 4096
"""Longest payload a host takes, bytes."""

_DELIMITER = b"\0"
_CRC = 4
_SHORTEST = 1 + _CRC
_RUN = 254  # bytes without a zero that COBS stuffs with one more


def encode_frame(payload: bytes) -> bytes:
    """Return the frame of a payload, with a zero before and behind it.

    Raises:
        ValueRefused: the payload is empty or longer than any receiver takes.
    """
    if not 1 <= len(payload) <= MAX_PAYLOAD:
        raise ValueRefused(
            f"a message of {len(payload)} bytes, 1 to {MAX_PAYLOAD} fit a frame: send it in parts"
        )
    checked = payload + zlib.crc32(payload).to_bytes(_CRC, "little")
    stuffed: bytes = cobs.encode(checked)
    return _DELIMITER + stuffed + _DELIMITER


class FrameSplitter:
    """Splits a stream of bytes into payloads. Never raises on received data, nor stores more than a frame.

    The result depends on the bytes alone, not on their division over calls.
    """

    def __init__(self, max_payload: int = MAX_PAYLOAD) -> None:
        self.frames = 0
        """Good frames."""
        self.too_long = 0
        self.bad_stuffing = 0
        self.too_short = 0
        self.bad_crc = 0
        self._longest = max_payload + _CRC
        # One more than the tightest stuffing: an encoder may close a last full run with an empty one.
        self._longest_stuffed = self._longest + self._longest // _RUN + 1
        self._begun = bytearray()
        self._skipping = False  # the frame begun is too long, and counted

    @property
    def dropped(self) -> int:
        """Frames dropped for any cause."""
        return self.too_long + self.bad_stuffing + self.too_short + self.bad_crc

    def feed(self, data: bytes) -> list[bytes]:
        """Return the payloads of the good frames that end in these bytes, in order."""
        *ended, rest = data.split(_DELIMITER)
        payloads = []
        if ended:
            if self._skipping:
                ended[0] = b""
            elif self._begun:
                ended[0] = bytes(self._begun) + ended[0]
            self._begun.clear()
            self._skipping = False
            payloads = [payload for each in ended if each and (payload := self._payload(each))]
        if not self._skipping:
            self._begun += rest
            if len(self._begun) > self._longest_stuffed:
                self.too_long += 1
                self._begun.clear()
                self._skipping = True
        return payloads

    def _payload(self, stuffed: bytes) -> bytes | None:
        if len(stuffed) > self._longest_stuffed:
            self.too_long += 1
            return None
        try:
            checked: bytes = cobs.decode(stuffed)
        except cobs.DecodeError:
            self.bad_stuffing += 1
            return None
        if len(checked) > self._longest:
            self.too_long += 1
            return None
        if len(checked) < _SHORTEST:
            self.too_short += 1
            return None
        payload = checked[:-_CRC]
        if zlib.crc32(payload) != int.from_bytes(checked[-_CRC:], "little"):
            self.bad_crc += 1
            return None
        self.frames += 1
        return payload
