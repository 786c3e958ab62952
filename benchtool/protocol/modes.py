"""Modes of operation (CiA 402-2, object 0x6060) that the bench uses."""

from enum import IntEnum


class Mode(IntEnum):
    """What the setpoint means."""

    VELOCITY = 3
    TORQUE = 4
