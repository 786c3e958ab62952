"""SDO abort codes (CiA 301, 7.2.4.3.17, table 22) with meanings and remedies."""

from __future__ import annotations

from enum import IntEnum


class Abort(IntEnum):
    """Abort codes of CiA 301."""

    TOGGLE_BIT = 0x05030000
    TIMED_OUT = 0x05040000
    COMMAND_SPECIFIER = 0x05040001
    BLOCK_SIZE = 0x05040002
    SEQUENCE_NUMBER = 0x05040003
    CRC = 0x05040004
    OUT_OF_MEMORY = 0x05040005
    UNSUPPORTED_ACCESS = 0x06010000
    WRITE_ONLY = 0x06010001
    READ_ONLY = 0x06010002
    NO_OBJECT = 0x06020000
    NOT_MAPPABLE = 0x06040041
    MAPPING_TOO_LONG = 0x06040042
    PARAMETER_INCOMPATIBLE = 0x06040043
    DEVICE_INCOMPATIBLE = 0x06040047
    HARDWARE = 0x06060000
    LENGTH = 0x06070010
    LENGTH_HIGH = 0x06070012
    LENGTH_LOW = 0x06070013
    NO_SUB_INDEX = 0x06090011
    VALUE = 0x06090030
    VALUE_HIGH = 0x06090031
    VALUE_LOW = 0x06090032
    MAX_BELOW_MIN = 0x06090036
    NO_CONNECTION = 0x060A0023
    GENERAL = 0x08000000
    NOT_STORED = 0x08000020
    LOCAL_CONTROL = 0x08000021
    DEVICE_STATE = 0x08000022
    NO_DICTIONARY = 0x08000023
    NO_DATA = 0x08000024


_AGAIN = "try again; if it stays, look for a second master on the bus"
_BUS = "check the bus (termination, bit rate, load) and try again"
_EDS = "the EDS does not fit this drive; use the EDS of its firmware version"
_LIMITS = "give a value within the object's limits"

_TEXTS: dict[int, tuple[str, str]] = {
    Abort.TOGGLE_BIT: ("toggle bit not alternated", _AGAIN),
    Abort.TIMED_OUT: ("SDO protocol timed out", _BUS),
    Abort.COMMAND_SPECIFIER: (
        "command specifier not valid or unknown",
        "the drive does not support this kind of transfer; use a segmented one",
    ),
    Abort.BLOCK_SIZE: ("invalid block size", _AGAIN),
    Abort.SEQUENCE_NUMBER: ("invalid sequence number", _BUS),
    Abort.CRC: ("checksum of the block wrong", _BUS),
    Abort.OUT_OF_MEMORY: ("out of memory", "transfer less data at once"),
    Abort.UNSUPPORTED_ACCESS: ("unsupported access to an object", _EDS),
    Abort.WRITE_ONLY: ("read of a write-only object", "do not read this object"),
    Abort.READ_ONLY: ("write to a read-only object", "do not write this object"),
    Abort.NO_OBJECT: ("object does not exist", _EDS),
    Abort.NOT_MAPPABLE: ("object cannot be mapped to a PDO", "map another object"),
    Abort.MAPPING_TOO_LONG: ("mapped objects exceed the length of the PDO", "map at most eight bytes"),
    Abort.PARAMETER_INCOMPATIBLE: ("parameter incompatible with others", "check what it depends on"),
    Abort.DEVICE_INCOMPATIBLE: ("incompatible inside the device", "check what it depends on"),
    Abort.HARDWARE: ("access failed by a hardware error", "check the drive's supply and memory, reset it"),
    Abort.LENGTH: ("data type or length does not match", _EDS),
    Abort.LENGTH_HIGH: ("data too long", _EDS),
    Abort.LENGTH_LOW: ("data too short", _EDS),
    Abort.NO_SUB_INDEX: ("sub-index does not exist", _EDS),
    Abort.VALUE: ("value not allowed", _LIMITS),
    Abort.VALUE_HIGH: ("value too high", _LIMITS),
    Abort.VALUE_LOW: ("value too low", _LIMITS),
    Abort.MAX_BELOW_MIN: ("maximum below minimum", "set the limits in the right order"),
    Abort.NO_CONNECTION: ("no SDO connection available", "close the other client"),
    Abort.GENERAL: ("general error", "read error_code (0x603F) and the emergencies"),
    Abort.NOT_STORED: ("data cannot be transferred or stored", "check signature and state of the drive"),
    Abort.LOCAL_CONTROL: ("refused under local control", "give the drive back to remote control"),
    Abort.DEVICE_STATE: ("refused in the present state of the drive", "disable the drive first"),
    Abort.NO_DICTIONARY: ("no object dictionary present", "check the drive's firmware"),
    Abort.NO_DATA: ("no data available", "wait until the drive has the data"),
}


def abort_text(code: int) -> str:
    """Return the code, meaning and remedy on one line, also of a code that CiA 301 does not define."""
    meaning, remedy = _TEXTS.get(
        code, ("not a code of CiA 301", "look it up in the manual of the drive's manufacturer")
    )
    return f"0x{code:08X} {meaning}: {remedy}"
