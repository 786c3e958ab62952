"""How much a capture may hold: a million values, and one row more than come before its trigger."""

from __future__ import annotations

import struct

import pytest

from benchtool.emulator.firmware.objects import Refused
from benchtool.protocol.canopen.abort import Abort
from tests.unit.firmware.test_protection_limits import TABLE, drive

_SIGNALS = ("torque", "i_d", "i_q", "u_dc", "i_a", "i_b", "i_c", "psi_s")


@pytest.mark.parametrize(
    ("channels", "rows", "pretrigger", "refused"),
    [
        (5, 200_000, 0, False),
        (8, 125_001, 0, True),
        (1, 100, 99, False),
        (1, 100, 100, True),
        (0, 100, 0, True),
    ],
)
def test_what_has_no_room_is_refused(channels: int, rows: int, pretrigger: int, refused: bool) -> None:
    firmware, _ = drive()
    for place, name in enumerate(_SIGNALS[:channels]):
        firmware.objects[f"capture_channel_{place + 1}"] = TABLE.by_name[name].mapping
    firmware.objects[f"capture_channel_{channels + 1}"] = 0
    firmware.objects["capture_rows"], firmware.objects["capture_pretrigger"] = rows, pretrigger
    entry = TABLE.by_name["capture_control"]
    data = struct.pack("<B", 1)
    if refused:
        with pytest.raises(Refused) as reason:
            firmware.objects.write(entry.index, entry.sub, data)
        assert reason.value.code == Abort.PARAMETER_INCOMPATIBLE
    else:
        firmware.objects.write(entry.index, entry.sub, data)
