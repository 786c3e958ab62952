"""The emergency message and its error codes.

Sources: CiA 301, 7.2.7 (the message, the code classes of table 26, the error register 0x1001) and CiA 402-1
(IEC 61800-7-201), the error codes of a drive.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import TypeVar

_MESSAGE = struct.Struct("<HB5s")


class ErrorCode(IntEnum):
    """Error codes that the reference drive raises."""

    NO_ERROR = 0x0000
    OVERCURRENT = 0x2310
    OVERLOAD = 0x2350
    DC_LINK_OVERVOLTAGE = 0x3210
    DC_LINK_UNDERVOLTAGE = 0x3220
    TEMPERATURE = 0x4310
    WATCHDOG = 0x6010
    PARAMETER = 0x6320
    ENCODER = 0x7305
    HEARTBEAT = 0x8130
    BUS_OFF_RECOVERED = 0x8140
    OVERSPEED = 0x8400


_TEXTS = {
    0x0000: "no error: all errors are reset",
    0x2310: "continuous overcurrent at the output",
    0x2320: "short circuit or earth leakage at the output",
    0x2350: "overload of the motor (I2t)",
    0x3110: "mains overvoltage",
    0x3120: "mains undervoltage",
    0x3210: "dc link overvoltage",
    0x3220: "dc link undervoltage",
    0x4210: "device temperature too high",
    0x4310: "drive temperature too high",
    0x5530: "non-volatile memory failed",
    0x6010: "software reset by the watchdog",
    0x6320: "parameter out of its limits",
    0x7121: "motor blocked",
    0x7305: "encoder 1 failed",
    0x8110: "CAN overrun: messages were lost",
    0x8120: "CAN in error passive mode",
    0x8130: "heartbeat or life guarding lost",
    0x8140: "recovered from bus off",
    0x8210: "PDO not processed: wrong length",
    0x8220: "PDO longer than mapped",
    0x8400: "speed outside its limits",
    0x8500: "position controller failed",
    0x8611: "following error",
}

# Class of codes, by as many leading digits as are given, longest first in the lookup.
_CLASSES = {
    "00": "no error",
    "10": "generic error",
    "2": "current",
    "21": "current at the input side",
    "22": "current inside the device",
    "23": "current at the output side",
    "3": "voltage",
    "31": "mains voltage",
    "32": "voltage inside the device",
    "33": "output voltage",
    "4": "temperature",
    "41": "ambient temperature",
    "42": "device temperature",
    "5": "device hardware",
    "6": "device software",
    "61": "internal software",
    "62": "user software",
    "63": "data set",
    "7": "additional module",
    "8": "monitoring",
    "81": "communication",
    "82": "protocol error",
    "90": "external error",
    "F0": "additional function",
    "FF": "device specific",
}

_GENERIC = 0x01
_REGISTER_BITS = {"2": 0x02, "3": 0x04, "4": 0x08, "81": 0x10, "82": 0x10, "FF": 0x80}


@dataclass(frozen=True)
class Emergency:
    """One emergency message: error code, error register 0x1001, five bytes of the manufacturer."""

    code: int
    register: int
    vendor: bytes = bytes(5)

    def encode(self) -> bytes:
        """Return the eight bytes on the wire; the manufacturer's part is padded with zeros or cut to five."""
        return _MESSAGE.pack(self.code, self.register, self.vendor)

    @staticmethod
    def decode(data: bytes) -> Emergency | None:
        """Return the message in eight bytes; None if it is invalid. Never raises."""
        return Emergency(*_MESSAGE.unpack(data)) if len(data) == _MESSAGE.size else None

    @property
    def text(self) -> str:
        """Code and meaning, one line."""
        return f"0x{self.code:04X} {error_text(self.code)}"


def error_text(code: int) -> str:
    """Return what an error code means; of a code without an entry, what its class means."""
    return _TEXTS.get(code) or _by_class(code, _CLASSES) or "code without a standard meaning"


def error_register(code: int) -> int:
    """Return the bits of the error register 0x1001 that an error code sets: bit 0 with every error, and its
    class's."""
    return (_GENERIC | (_by_class(code, _REGISTER_BITS) or 0)) if code else 0


_T = TypeVar("_T")


def _by_class(code: int, classes: Mapping[str, _T]) -> _T | None:
    digits = f"{code:04X}"
    return next((classes[digits[:n]] for n in (2, 1) if digits[:n] in classes), None)
