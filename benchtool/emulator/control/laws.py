"""The torque laws by number, chosen at run time by object `law`."""

from __future__ import annotations

from enum import IntEnum
from typing import Any

from benchtool.emulator.control import tpc
from benchtool.emulator.control.estimation import Situation
from benchtool.emulator.jit import njit


class Law(IntEnum):
    """Values of object `law`."""

    TPC = 0


_TPC = int(Law.TPC)


@njit
def voltage(at: Situation, torque: float, psi_s: float, drive: Any) -> tuple[float, float, float, bool]:
    """Mean voltage of the period that begins in the situation `at`, its angle against the rotor flux, and
    whether the law had to clip. An unknown law asks for none."""
    if drive.law == _TPC:
        return tpc.voltage(at, torque, psi_s, drive)
    return 0.0, 0.0, 0.0, True
