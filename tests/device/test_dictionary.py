"""Every access to the dictionary has the same outcome in the C library as in the emulated drive."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from benchtool.emulator.bench import EmulatedBench
from benchtool.profile import load_profile
from benchtool.protocol.dictionary.objects import DataType, Entry
from benchtool.protocol.modes import Mode
from benchtool.protocol.serial import Nmt, Read, ReadReply, Write, WriteReply
from tests.device.c_drive import CHost
from tests.wire.raw_host import TABLE, RawHost

_MEASURED = {"torque_actual", "velocity_actual", "current_actual", "dc_link_voltage", "angle_known"}
_NAMED = {"hardware_version"}


def _is_the_same_value(entry: Entry) -> bool:
    """Whether both drives hold the same value of it, which they do not of what they measure or are."""
    return entry.role != "signal" and entry.name not in _MEASURED | _NAMED


def _read(host: RawHost, index: int, sub: int) -> tuple[int, bytes]:
    reply = host.ask(Read(host.tag(), index, sub), ReadReply)
    return reply.status, reply.data


def _write(host: RawHost, index: int, sub: int, data: bytes) -> int:
    return host.ask(Write(host.tag(), index, sub, data), WriteReply).status


def _numbers(entry: Entry) -> Iterator[bytes]:
    """Values of the entry's own length: its limits, just beyond them, and what is no value at all."""
    bits = entry.type.bits
    if entry.type is DataType.F32:
        limits = [limit for limit in (entry.minimum, entry.maximum) if limit is not None]
        words = [struct.unpack("<I", struct.pack("<f", limit))[0] for limit in limits]
        around = {word + step & 0xFFFFFFFF for word in words for step in (-1, 0, 1)}
        special = [struct.pack("<f", value) for value in (math.nan, math.inf, -math.inf, 0.0, -0.0, 0.5)]
        yield from (word.to_bytes(4, "little") for word in sorted(around))
        yield from special
        return
    low, high = entry.type.limits
    interesting = {0, 1, 2, 5, 7, 100, int(low), int(high)}
    for limit in (entry.minimum, entry.maximum):
        if limit is not None:
            interesting |= {int(limit) - 1, int(limit), int(limit) + 1}
    interesting |= {value + step for value in (entry.values or {}).values() for step in (-1, 0, 1)}
    for value in sorted(interesting):
        if low <= value <= high:
            yield (value & ((1 << bits) - 1)).to_bytes(bits // 8, "little")


def _related(host: RawHost, entry: Entry) -> Iterator[bytes]:
    """What other entries limit it to, what it limits others to, and the floats around these."""
    limits = [host.read(entry.min_entry)] if entry.min_entry else []
    limits += [entry.max_times * host.read(entry.max_entry)] if entry.max_entry else []
    limits += [host.read(each.name) / each.max_times for each in TABLE if each.max_entry == entry.name]
    for limit in limits:
        word = struct.unpack("<I", struct.pack("<f", limit))[0]
        yield from (max(word + step, 0).to_bytes(4, "little") for step in (-2, -1, 0, 1, 2, -1))


def _attempts(entry: Entry) -> Iterator[bytes]:
    """None of them starts something that takes time: controlword and capture have tests of their own."""
    for length in (1, 2, 3, 4, 5, 8, 9):
        if length != entry.type.bits // 8:
            yield bytes(length)
    if entry.type.bits and entry.name not in ("controlword", "capture_control", "stimulus_control"):
        yield from _numbers(entry)


@pytest.fixture
def emulated() -> Iterator[RawHost]:
    bench = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    host = RawHost(bench)
    host.hear()
    yield host
    bench.close()


@pytest.mark.parametrize("enabled", [False, True])
def test_every_entry_is_refused_and_taken_alike(emulated: RawHost, raw: CHost, enabled: bool) -> None:
    for host in (emulated, raw):
        if enabled:
            host.enable(Mode.TORQUE)
    tried = refused = 0
    for entry in TABLE:
        place = entry.index, entry.sub
        for data in (*_attempts(entry), *_related(emulated, entry)):
            expected = _write(emulated, *place, data)
            answered = _write(raw, *place, data)
            assert answered == expected, f"{entry.name} = {data.hex()}"
            tried, refused = tried + 1, refused + bool(expected)
        theirs, ours = _read(emulated, *place), _read(raw, *place)
        assert ours[0] == theirs[0], entry.name
        if _is_the_same_value(entry):
            assert ours[1] == theirs[1], entry.name
        elif entry.name not in _NAMED:
            assert len(ours[1]) == len(theirs[1]), entry.name
    assert tried > 2000
    assert 1000 < refused < tried - 300


NOWHERE = [(0x2000, 0x63), (0x5FFF, 0), (0, 0), (0xFFFF, 0xFF), (0x1001, 1), (0x2042, 0)]


@pytest.mark.parametrize("state", [1, 2, 128])
@pytest.mark.parametrize(
    "place", [(0x2000, 0x63), (0x5FFF, 0), (0, 0), (0xFFFF, 0xFF), (0x1001, 1), (0x2042, 0)]
)
def test_what_is_not_there_or_not_now(
    emulated: RawHost, raw: CHost, state: int, place: tuple[int, int]
) -> None:
    for host in (emulated, raw):
        host.tell(Nmt(state))
    assert _read(raw, *place) == _read(emulated, *place)
    assert _write(raw, *place, bytes(4)) == _write(emulated, *place, bytes(4))


CAPTURES = [
    {"capture_channel_1": 0},
    {"capture_channel_1": TABLE.by_name["tick"].mapping},
    {"capture_channel_1": TABLE.by_name["R_s"].mapping},
    {"capture_channel_1": TABLE.by_name["tick"].mapping ^ 0x30},
    {"capture_channel_1": TABLE.by_name["tick"].mapping, "capture_channel_2": 0x55550020},
    {"capture_channel_1": TABLE.by_name["tick"].mapping, "capture_rows": 10, "capture_pretrigger": 10},
    {"capture_channel_1": TABLE.by_name["tick"].mapping, "capture_trigger_signal": 0x20000220},
    {f"capture_channel_{n}": TABLE.by_name["tick"].mapping for n in range(1, 17)} | {"capture_rows": 62_501},
    {f"capture_channel_{n}": TABLE.by_name["tick"].mapping for n in range(1, 17)} | {"capture_rows": 62_500},
]


@pytest.mark.parametrize("setup", CAPTURES, ids=range(len(CAPTURES)))
def test_captures_are_refused_and_armed_alike(emulated: RawHost, raw: CHost, setup: dict[str, int]) -> None:
    for host in (emulated, raw):
        for name, value in setup.items():
            assert host.write(name, value) == 0
    assert raw.write("capture_control", 1) == emulated.write("capture_control", 1)
    assert raw.read("capture_state") == emulated.read("capture_state")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(
    st.lists(st.sampled_from([0, 2, 6, 7, 15, 0x80, 0x8F, 0x107, 0xFFFF, 3, 0x0B]), max_size=6),
    st.integers(0, 2),
)
def test_controlwords_lead_to_the_same_states(
    emulated: RawHost, raw: CHost, words: list[int], quick_stop: int
) -> None:
    """With a quick stop in between, which neither ends without time."""
    for host in (emulated, raw):
        host.write("quick_stop_option", 2 if quick_stop else 0)
    for word in words:
        assert raw.write("controlword", word) == emulated.write("controlword", word)
        assert int(raw.read("statusword")) & 0x6F == int(emulated.read("statusword")) & 0x6F


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
@given(
    st.sampled_from([entry.index for entry in TABLE if 0x1400 <= entry.index < 0x1C00]),
    st.integers(0, 6),
    st.one_of(
        st.sampled_from([entry.mapping for entry in TABLE if entry.mappable]),
        st.sampled_from([0, 1, 2, 4, 5, 255, 0x80000181, 0x181, 0x180, 0x57F, 0x580, 0x20000281]),
        st.integers(0, 2**32 - 1),
    ),
)
def test_process_data_are_mapped_alike(
    emulated: RawHost, raw: CHost, index: int, sub: int, value: int
) -> None:
    entry = TABLE.by_key.get((index, sub))
    length = entry.type.bits // 8 if entry is not None else 4
    data = (value & ((1 << 8 * length) - 1)).to_bytes(length, "little")
    assert _write(raw, index, sub, data) == _write(emulated, index, sub, data)
    assert _read(raw, index, sub) == _read(emulated, index, sub)
