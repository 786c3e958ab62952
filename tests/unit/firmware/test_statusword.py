"""Bits of the drive's statusword that its state does not say (CiA 402-2, object 0x6041)."""

from __future__ import annotations

from benchtool.emulator.firmware.device import Firmware
from tests.unit.firmware.test_protection_limits import TABLE, drive

WARNING, VOLTAGE_ENABLED, INTERNAL_LIMIT = 7, 4, 11


def _bit(firmware: Firmware, place: int) -> bool:
    entry = TABLE.by_name["statusword"]
    word = int.from_bytes(firmware.objects.read(entry.index, entry.sub), "little")
    return bool(word >> place & 1)


def test_the_warning_stands_for_as_long_as_a_lost_link_is_not_forgotten() -> None:
    firmware, sent = drive()
    seen = [_bit(firmware, WARNING)]
    firmware.supervision.configure(127 << 16 | 100)
    seen.append(_bit(firmware, WARNING))
    firmware.feed_link()
    seen.append(_bit(firmware, WARNING))
    firmware.advance_to(firmware.core.tick + 1100)
    assert len(sent) == 1
    seen.append(_bit(firmware, WARNING))
    firmware.supervision.rearm()
    seen.append(_bit(firmware, WARNING))
    assert seen == [False, False, False, True, False]


def test_the_voltage_bit_is_that_of_a_dc_link_above_its_least() -> None:
    firmware, _ = drive()
    firmware.objects["u_dc"], firmware.objects["u_dc_min"] = 51.0, 50.0
    assert _bit(firmware, VOLTAGE_ENABLED)
    firmware.objects["u_dc"] = 49.0
    assert not _bit(firmware, VOLTAGE_ENABLED)
    assert not _bit(firmware, INTERNAL_LIMIT)
