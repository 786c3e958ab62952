"""Objects that the drive computes when they are read: the units of CiA 402, and the errors of the past."""

from __future__ import annotations

import math

import pytest

from benchtool.emulator.firmware.device import Firmware
from benchtool.emulator.firmware.objects import Refused
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.emcy import ErrorCode
from tests.unit.firmware.test_protection_limits import TABLE, drive


def read(firmware: Firmware, name: str) -> int:
    entry = TABLE.by_name[name]
    return int.from_bytes(firmware.objects.read(entry.index, entry.sub), "little", signed=True)


def test_signals_in_the_units_of_cia_402() -> None:
    firmware, _ = drive()
    signals = {"T_N": 8.0, "torque": -2.0, "omega_m": -15.5, "u_dc": 122.25, "i_q": 4.0}
    for name, value in signals.items():
        firmware.objects[name] = value
    firmware.objects["motor_rated_current"] = 2000  # mA
    assert read(firmware, "motor_rated_torque") == 8000, "mN·m"
    assert read(firmware, "torque_actual") == -250, "per mille of the rated torque"
    assert read(firmware, "velocity_actual") == -15_500
    assert read(firmware, "dc_link_voltage") == 122_250, "mV"
    assert read(firmware, "current_actual") == round(4.0 / math.sqrt(2.0) / 2.0 * 1e3), "rms"
    firmware.objects["torque"] = 1e6
    assert read(firmware, "torque_actual") == 32_767
    firmware.objects["u_dc"] = -0.1
    assert read(firmware, "dc_link_voltage") == 0


def test_the_errors_of_the_past_the_latest_first() -> None:
    firmware, _ = drive(stored={"i_trip": 1e4})  # beyond the range: a fault of its own after each reset
    assert read(firmware, "error_history_count") == 1
    firmware.supervision.configure(127 << 16 | 100)
    firmware.feed_link()
    firmware.advance_to(firmware.core.tick + 1100)
    assert read(firmware, "error_1") & 0xFFFF == ErrorCode.HEARTBEAT
    assert read(firmware, "error_2") & 0xFFFF == ErrorCode.PARAMETER
    assert read(firmware, "error_history_count") == 2
    with pytest.raises(Refused) as reason:
        read(firmware, "error_3")
    assert reason.value.code == Abort.NO_DATA
