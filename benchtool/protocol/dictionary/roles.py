"""Standard objects by their role: the host's table of indices.

Vendors name their objects freely, so the host asks for a role: `dictionary[Role.STATUSWORD]`. A profile may
redirect it to another object of the drive. Sources: CiA 301, 7.5.2 (communication objects), and CiA 402-2
(IEC 61800-7-201).
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from enum import Enum, unique
from typing import Final

from benchtool.errors import ValueRefused


@unique
class Role(Enum):
    """Role of an object; the value is its index and sub-index in the standard.

    Of process data it is the first PDO's; those of the n-th are at index + n - 1.
    """

    DEVICE_TYPE = 0x1000, 0
    ERROR_REGISTER = 0x1001, 0
    SYNC_COB_ID = 0x1005, 0
    SYNC_PERIOD = 0x1006, 0
    DEVICE_NAME = 0x1008, 0
    HARDWARE_VERSION = 0x1009, 0
    FIRMWARE_VERSION = 0x100A, 0
    STORE_PARAMETERS = 0x1010, 1
    RESTORE_DEFAULT_PARAMETERS = 0x1011, 1
    CONSUMER_HEARTBEAT = 0x1016, 1
    PRODUCER_HEARTBEAT = 0x1017, 0
    VENDOR_ID = 0x1018, 1
    PRODUCT_CODE = 0x1018, 2
    REVISION_NUMBER = 0x1018, 3
    SERIAL_NUMBER = 0x1018, 4
    RPDO_COB_ID = 0x1400, 1
    RPDO_MAPPING = 0x1600, 0
    TPDO_COB_ID = 0x1800, 1
    TPDO_MAPPING = 0x1A00, 0

    ABORT_CONNECTION_OPTION = 0x6007, 0
    ERROR_CODE = 0x603F, 0
    CONTROLWORD = 0x6040, 0
    STATUSWORD = 0x6041, 0
    QUICK_STOP_OPTION = 0x605A, 0
    SHUTDOWN_OPTION = 0x605B, 0
    DISABLE_OPERATION_OPTION = 0x605C, 0
    HALT_OPTION = 0x605D, 0
    FAULT_REACTION_OPTION = 0x605E, 0
    MODE_OF_OPERATION = 0x6060, 0
    MODE_OF_OPERATION_DISPLAY = 0x6061, 0
    SUPPORTED_MODES = 0x6502, 0
    TARGET_TORQUE = 0x6071, 0
    MAX_TORQUE = 0x6072, 0
    MOTOR_RATED_CURRENT = 0x6075, 0
    MOTOR_RATED_TORQUE = 0x6076, 0
    TORQUE_ACTUAL = 0x6077, 0
    CURRENT_ACTUAL = 0x6078, 0
    DC_LINK_VOLTAGE = 0x6079, 0
    TARGET_POSITION = 0x607A, 0
    POSITION_ACTUAL = 0x6064, 0
    VELOCITY_ACTUAL = 0x606C, 0
    TARGET_VELOCITY = 0x60FF, 0

    @property
    def title(self) -> str:
        """Name of the role as profiles and messages have it: `target_torque`."""
        return self.name.lower()

    @property
    def key(self) -> tuple[int, int]:
        """Index and sub-index in the standard."""
        return self.value

    @property
    def address(self) -> str:
        """Index and sub-index in the standard as text, `0x6071:0`."""
        index, sub = self.value
        return f"0x{index:04X}:{sub}"

    @property
    def label(self) -> str:
        """Where the standard has it, and its name: `0x6071:0 target_torque`."""
        return f"{self.address} {self.title}"

    @property
    def unit(self) -> str:
        """SI unit of the quantity that the object is of; empty of a code, bits or a count."""
        return _UNITS.get(self, "")

    @property
    def is_text(self) -> bool:
        """Whether the object is a string; all others are numbers."""
        return self in (Role.DEVICE_NAME, Role.HARDWARE_VERSION, Role.FIRMWARE_VERSION)

    @classmethod
    def named(cls, title: str) -> Role:
        """Return the role of a name as a profile states it.

        Raises:
            ValueRefused: there is none of that name.
        """
        names = [role.title for role in cls]
        if title in names:
            return cls[title.upper()]
        close = difflib.get_close_matches(title, names, n=1, cutoff=0.5)
        hint = f"did you mean '{close[0]}'?" if close else f"the roles are {', '.join(names)}"
        raise ValueRefused(f"no role '{title}': {hint}")


_UNITS: Final[Mapping[Role, str]] = {
    **dict.fromkeys((Role.TARGET_TORQUE, Role.MAX_TORQUE, Role.MOTOR_RATED_TORQUE, Role.TORQUE_ACTUAL), "Nm"),
    **dict.fromkeys((Role.MOTOR_RATED_CURRENT, Role.CURRENT_ACTUAL), "A"),
    Role.DC_LINK_VOLTAGE: "V",
    **dict.fromkeys((Role.TARGET_POSITION, Role.POSITION_ACTUAL), "rad"),
    **dict.fromkeys((Role.TARGET_VELOCITY, Role.VELOCITY_ACTUAL), "rad/s"),
}
