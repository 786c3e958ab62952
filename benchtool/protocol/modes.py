"""Modes of operation (CiA 402-2, object 0x6060) that the bench uses."""

from enum import IntEnum


class Mode(IntEnum):
    """What the setpoint means. VOLTAGE is the drive's own: no law runs, a stimulus sets the voltage."""

    VOLTAGE = -1
    VELOCITY = 3
    TORQUE = 4
