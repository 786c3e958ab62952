"""Network management of CANopen (CiA 301, 7.2.8): commands, states, heartbeat."""

from __future__ import annotations

from enum import IntEnum


class NmtCommand(IntEnum):
    """Command specifiers of the node control services (7.2.8.2.1)."""

    START = 0x01
    STOP = 0x02
    ENTER_PRE_OPERATIONAL = 0x80
    RESET_NODE = 0x81
    RESET_COMMUNICATION = 0x82


class NmtState(IntEnum):
    """States as coded in the heartbeat (7.2.8.3.2.2); BOOT_UP is the message after a reset."""

    BOOT_UP = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


_STATES = {int(state): state for state in NmtState}


def heartbeat_state(data: bytes) -> NmtState | None:
    """Return the state in a heartbeat message; None if the message is invalid (one byte, bit 7 reserved).
    Never raises."""
    return _STATES.get(data[0]) if len(data) == 1 else None
