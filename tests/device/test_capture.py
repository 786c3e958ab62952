"""A capture of the tick itself has the same bytes from the C library as from the emulated drive."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from benchtool.emulator.bench import EmulatedBench
from benchtool.profile import load_profile
from benchtool.protocol.serial import ChunkReply, Chunks, Open, OpenReply
from tests.device.c_drive import CHost
from tests.wire.raw_host import TABLE, RawHost, mapping

IMMEDIATE, SETPOINT, RISING, FALLING = 0, 1, 2, 3
DATA = TABLE.by_name["capture_data"]


@pytest.fixture
def emulated() -> Iterator[RawHost]:
    bench = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    host = RawHost(bench)
    host.hear()
    yield host
    bench.close()


def _captured(host: RawHost, setup: dict[str, float], moved: bool) -> bytes | int:
    """The bytes, or the state that it stays in."""
    settings = {
        "capture_channel_1": mapping("tick"),
        "capture_channel_2": mapping("law_clipped"),
        "capture_trigger_signal": mapping("tick"),
        **setup,
    }
    for name, value in settings.items():
        host.write(name, value)
    host.bench.clock.wait(0.0123)
    host.write("capture_control", 1)
    host.bench.clock.wait(0.0077)
    if moved:
        host.write("omega_m_command", 1.0)
    host.bench.clock.wait(0.2)
    if (state := int(host.read("capture_state"))) != 3:
        return state
    opened = host.ask(Open(1, DATA.index, DATA.sub), OpenReply)
    count = -(-opened.size // opened.chunk_size)
    told = host.tell(Chunks(2, opened.upload, 0, count))
    return b"".join(each.data for each in told if isinstance(each, ChunkReply))


@pytest.mark.parametrize("stride", [1, 7])
@pytest.mark.parametrize("pretrigger", [0, 20, 99])
@pytest.mark.parametrize(
    ("trigger", "level", "completes"),
    [
        (IMMEDIATE, 0.0, True),
        (SETPOINT, 0.0, True),
        (RISING, 150.0, True),
        (RISING, 150.5, True),
        (RISING, 100.0, False),
        (RISING, -1.0, False),
        (RISING, 1e12, False),
        (FALLING, 150.0, False),
    ],
)
def test_the_bytes_are_the_same(
    emulated: RawHost, raw: CHost, trigger: int, level: float, completes: bool, pretrigger: int, stride: int
) -> None:
    setup = {
        "capture_rows": 100,
        "capture_stride": stride,
        "capture_pretrigger": pretrigger,
        "capture_trigger": trigger,
        "capture_trigger_level": level,
    }
    expected = _captured(emulated, setup, trigger == SETPOINT)
    assert isinstance(expected, bytes) == completes
    assert _captured(raw, setup, trigger == SETPOINT) == expected
