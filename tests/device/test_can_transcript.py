"""The C library on a CAN bus answers byte for byte as the emulated drive does.

One difference is meant, and has a test: the C library has no room for a second copy of a capture, so arming
another one ends the upload of the one before. Stimuli are not compared: the library plays none. Frames of one
tick are compared in the order of their identifiers, as a bus passes them.
"""

from __future__ import annotations

import binascii
import struct
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings, strategies as st

from benchtool.protocol.capture_data import decode_header
from benchtool.protocol.dictionary.objects import Entry
from tests.device.can_endpoints import (
    ENABLE,
    HEARD,
    HOST,
    NODE,
    RESET,
    RESET_COMMUNICATION,
    START,
    STOP,
    TRIPS,
    Frame,
    Pair,
    Step,
    Ticks,
    Tripped,
    download,
    nmt,
    sdo,
    set_up_pdo,
    upload,
    write,
)
from tests.wire.raw_host import TABLE

ABORT = sdo("80 00 00 00 00 00 00 08")


# ---- objects -----------------------------------------------------------------------------------------------


def test_every_object_is_read_alike(pair: Pair) -> None:
    pair.play([Ticks(5)])
    for entry in TABLE:
        pair.play([upload(entry.name)])
        answers = pair.play([sdo("60 00 00 00 00 00 00 00"), sdo("70 00 00 00 00 00 00 00")])
        assert len(answers) == 2
    assert pair.ask("40 00 10 01 00 00 00 00") == ["80 00 10 01 11 00 09 06"]
    assert pair.ask("40 FF 5F 00 00 00 00 00") == ["80 FF 5F 00 00 00 02 06"]


def test_every_object_takes_or_refuses_the_same_values(pair: Pair) -> None:
    taken = refused = 0
    for entry in TABLE:
        for data in _edges(entry.type.bits // 8 or 4):
            if entry.name in ("controlword", "stimulus_control"):
                continue
            (answer,) = pair.play([download(entry.index, entry.sub, data)])
            taken, refused = taken + (answer[1][0] == 0x60), refused + (answer[1][0] == 0x80)
        if entry.name != "angle_known":  # no index passes here, for which encoder_reference waits now
            pair.play([upload(entry.name)])
    assert taken > 300
    assert refused > 2000


def _edges(size: int) -> list[bytes]:
    numbers = [0, 1, 2, 255, (1 << 8 * size) - 1, 1 << (8 * size - 1), (1 << (8 * size - 1)) - 1]
    floats = [struct.pack("<f", x) for x in (0.5, -1.0, 1e9, -1e9, 3.4e38, float("nan"), float("-inf"))]
    other_sizes = [bytes(n) for n in range(1, 5) if n != size]
    return [(n % (1 << 8 * size)).to_bytes(size, "little") for n in numbers] + floats + other_sizes


# ---- transfers ---------------------------------------------------------------------------------------------


def test_segments_carry_a_name_and_a_wrong_toggle_ends_it(pair: Pair) -> None:
    assert pair.ask("40 08 10 00 00 00 00 00")[0].startswith("41 08 10 00 19 00")
    text = b""
    for toggle in (0, 1, 0, 1):
        (answer,) = pair.ask(f"{0x60 | toggle << 4:02X} 00 00 00 00 00 00 00")
        raw = bytes.fromhex(answer)
        text += raw[1 : 8 - (raw[0] >> 1 & 7)]
    assert text == b"benchtool reference drive"
    pair.ask("40 08 10 00 00 00 00 00")
    assert pair.ask("70 00 00 00 00 00 00 00") == ["80 08 10 00 00 00 03 05"]


def test_downloads_in_segments_and_in_blocks(pair: Pair) -> None:
    entry = TABLE.by_name["R_s"]
    place = f"{entry.index & 0xFF:02X} {entry.index >> 8:02X} {entry.sub:02X}"
    value = struct.pack("<f", 0.25)
    text = value.hex(" ").upper()
    pair.ask(f"21 {place} 04 00 00 00")
    assert pair.ask(f"07 {text} 00 00 00") == ["20 00 00 00 00 00 00 00"]
    assert pair.ask(f"40 {place} 00 00 00 00")[0].endswith(text)
    pair.ask(f"21 {place} 05 00 00 00")
    assert pair.ask(f"07 {text} 00 00 00") == [f"80 {place} 10 00 07 06"]  # not the length announced
    crc = binascii.crc_hqx(value, 0).to_bytes(2, "little").hex(" ")
    for size, end, unused, answer in (
        (4, crc, 3, "A1 00 00 00 00 00 00 00"),
        (4, "00 00", 3, f"80 {place} 04 00 04 05"),  # CRC
        (5, crc, 3, f"80 {place} 10 00 07 06"),  # not the length announced
        (5, "00 00", 2, f"80 {place} 04 00 04 05"),
    ):
        assert pair.ask(f"C6 {place} {size:02X} 00 00 00") == [f"A4 {place} 7F 00 00 00"]
        assert pair.ask(f"81 {text} 00 00 00") == ["A2 01 7F 00 00 00 00 00"]
        assert pair.ask(f"{0xC1 | unused << 2:02X} {end} 00 00 00 00 00") == [answer]
    pair.ask(f"C2 {place} 04 00 00 00")
    pair.ask(f"01 {text} 00 00 00")
    assert pair.ask("82 00 00 00 00 00 00 00") == [f"80 {place} 12 00 07 06"]


def test_a_capture_comes_in_blocks_with_its_crc(pair: Pair) -> None:
    pair.play(_capture("omega_m", "torque", "tick", rows=200, pretrigger=50))
    assert [len(pair.play([upload("capture_rows_done")])), pair.ask("40 42 20 00 00 00 00 00")] == [
        1,
        ["80 42 20 00 22 00 00 08"],
    ]
    pair.play([Ticks(40), write("omega_m_command", 3.0), Ticks(170)])
    (begun,) = pair.ask("A4 42 20 00 1F 00 00 00")
    size = int.from_bytes(bytes.fromhex(begun)[4:8], "little")
    data, answers = b"", pair.ask("A3 00 00 00 00 00 00 00")
    lost = 0
    while True:
        frames = [bytes.fromhex(answer) for answer in answers]
        if frames[0][0] & 0xE3 == 0xC1 and len(frames) == 1:
            break
        keep = len(frames) if lost else 5  # the rest of the first sub-block got lost
        lost += 1
        data += b"".join(frame[1:] for frame in frames[:keep])
        answers = pair.ask(f"A2 {keep:02X} {40 + lost:02X} 00 00 00 00 00")
    end = frames[0]
    data = data[: len(data) - (end[0] >> 2 & 7)]
    assert len(data) == size == 32 + 200 * 12
    assert int.from_bytes(end[1:3], "little") == binascii.crc_hqx(data, 0)
    header = decode_header(data)
    assert (header.rows, header.n_channels) == (200, 3)
    assert pair.ask("A1 00 00 00 00 00 00 00") == []


@pytest.mark.parametrize("size", [4, 127], ids=["between blocks", "after the last"])
def test_a_capture_that_is_gone_ends_its_upload(pair: Pair, size: int) -> None:
    pair.play([*_capture("omega_m", rows=50), write("omega_m_command", 1.0), Ticks(60)])
    (begun,) = pair.ask(f"A4 42 20 00 {size:02X} 00 00 00")
    assert begun.startswith("C6 ")
    segments = len(pair.ask("A3 00 00 00 00 00 00 00"))
    pair.c.arm_capture()
    assert pair.c.send(*_request(f"A2 {segments:02X} 04 00 00 00 00 00")) == [
        (0x580 + NODE, bytes.fromhex("80 42 20 00 22 00 00 08"))
    ]


def test_no_more_segments_are_acknowledged_than_were_sent(pair: Pair) -> None:
    pair.ask("A4 08 10 00 02 00 00 00")
    assert len(pair.ask("A3 00 00 00 00 00 00 00")) == 2
    assert pair.ask("A2 03 02 00 00 00 00 00") == ["80 08 10 00 03 00 04 05"]


@pytest.mark.parametrize("command", [RESET, RESET_COMMUNICATION])
def test_a_reset_ends_a_transfer(pair: Pair, command: int) -> None:
    pair.ask("C6 01 20 01 04 00 00 00")
    pair.play([Frame(*_nmt(command))])
    assert pair.ask("40 00 10 00 00 00 00 00") == ["43 00 10 00 92 01 02 00"]


def _request(text: str) -> tuple[int, bytes]:
    return 0x600 + NODE, bytes.fromhex(text)


def _nmt(command: int) -> tuple[int, bytes]:
    return 0x000, bytes([command, NODE])


def _capture(*channels: str, rows: int, pretrigger: int = 0) -> list[Step]:
    return [
        *(write(f"capture_channel_{n}", TABLE.by_name[name].mapping) for n, name in enumerate(channels, 1)),
        write(f"capture_channel_{len(channels) + 1}", 0),
        write("capture_rows", rows),
        write("capture_stride", 1),
        write("capture_pretrigger", pretrigger),
        write("capture_trigger", 1),
        write("capture_trigger_signal", TABLE.by_name["omega_m"].mapping),
        write("capture_control", 1),
    ]


# ---- time --------------------------------------------------------------------------------------------------


def test_heartbeats_come_at_the_same_ticks(pair: Pair) -> None:
    everyone = Frame(0x000, bytes([START, 0]))
    steps: list[Step] = [write("producer_heartbeat", 10), Ticks(250), everyone, Ticks(120)]
    beats = [frame for frame in pair.play(steps) if frame[0] == 0x700 + NODE]
    assert [data[0] for _, data in beats] == [127, 127, 5]
    assert [data for _, data in pair.play([nmt(RESET_COMMUNICATION)])] == [b"\x00"]


def test_a_silent_host_is_a_fault_and_an_emergency_in_the_same_tick(pair: Pair) -> None:
    # the torque is to end within the 200 periods: the watchdog expires three before
    pair.play([write("host_heartbeat", HOST << 16 | 20), *ENABLE[:3]])
    assert pair.ask("2B 40 60 00 0F 00 00 00") == ["80 40 60 00 22 00 00 08"]  # not heard yet
    pair.play([HEARD, write("controlword", 15), Ticks(150), HEARD, Ticks(196)])
    assert pair.play([Ticks(1)]) == [(0x080 + NODE, bytes.fromhex("30 81 11 00 00 00 00 00"))]
    pair.play([upload("statusword"), upload("link_state"), upload("error_1"), Ticks(50)])
    answers = pair.play([write("controlword", 0x80), upload("statusword")])
    assert answers[0] == (0x080 + NODE, bytes(8))


@pytest.mark.parametrize(
    "mapped", [["torque_command", "omega_m_command"], ["omega_m_command", "torque_command"]]
)
def test_setpoints_alone_keep_the_link_alive(pair: Pair, mapped: list[str]) -> None:
    setpoints = Frame(0x201, struct.pack("<ff", 0.0, 1.0))
    pair.play([*set_up_pdo("rpdo1", 0x201, mapped), write("host_heartbeat", HOST << 16 | 10), HEARD, *ENABLE])
    assert pair.play([Ticks(90), setpoints, Ticks(90), setpoints, Ticks(96)]) == []
    pair.play([Frame(0x201, bytes(7)), Frame(0x201, struct.pack("<ff", float("nan"), 0.0))])  # not taken
    assert pair.play([Ticks(1)])[0][0] == 0x080 + NODE


@pytest.mark.parametrize("code", TRIPS)
def test_a_trip_is_an_emergency_in_its_tick(pair: Pair, code: int) -> None:
    pair.play([*ENABLE, Ticks(5)])
    frames = pair.play([Tripped(code)])
    assert [(can_id, data[:2]) for can_id, data in frames] == [(0x081, code.to_bytes(2, "little"))]
    pair.play([Ticks(3), upload("statusword"), upload("error_register"), nmt(STOP), upload("statusword")])


def test_a_quick_stop_ends_in_the_same_tick(pair: Pair) -> None:
    pair.play(
        [*ENABLE, Ticks(20), write("controlword", 2), upload("statusword"), Ticks(30), upload("statusword")]
    )


def test_process_data_come_at_the_same_ticks_with_the_same_bytes(pair: Pair) -> None:
    pair.play(
        [
            *set_up_pdo("tpdo1", 0x181, ["tick", "stream_sequence"], 1),
            *set_up_pdo("tpdo2", 0x281, ["omega_m", "torque"], 1),
            *set_up_pdo("tpdo5", 0x1C1, ["i_a", "i_b"], 2),
            *set_up_pdo("tpdo3", 0x381, ["statusword", "mode_of_operation_display", "error_code"], 3),
            *set_up_pdo("rpdo1", 0x201, ["torque_command", "omega_m_command"]),
        ]
    )
    assert pair.play([Ticks(40), Frame(0x201, struct.pack("<ff", 9.0, 9.0)), Frame(0x201, b"")]) == []
    assert pair.ask("40 51 20 02 00 00 00 00") == ["43 51 20 02 00 00 00 00"]  # not even counted
    frames = pair.play([*ENABLE, Frame(0x201, struct.pack("<ff", 0.5, 10.0)), Ticks(120)])
    process = [can_id for can_id, _ in frames if 0x180 < can_id < 0x580]
    assert process.count(0x181) == process.count(0x281) == 12
    assert (process.count(0x1C1), process.count(0x381)) == (6, 4)
    pair.play([upload("omega_m_command"), upload("stream_sequence")])
    # Not with an invalid value, not in part, and nothing at all once the PDO is disabled.
    pair.play([Frame(0x201, struct.pack("<ff", 0.1, float("nan"))), Frame(0x201, b"\0" * 7)])
    assert pair.ask("40 51 20 02 00 00 00 00") == ["43 51 20 02 02 00 00 00"]
    pair.play([upload("torque_command"), write("tpdo1_cob_id", 1 << 31 | 0x181), Ticks(30)])
    assert 0x181 not in [can_id for can_id, _ in pair.play([Ticks(30)])]


def test_a_refused_value_takes_back_those_before_it(pair: Pair) -> None:
    pair.play(
        [
            *set_up_pdo("rpdo2", 0x301, ["psi_s_command", "mode_of_operation"]),
            nmt(START),
            Frame(0x301, struct.pack("<fb", 0.5, -1)),
            upload("psi_s_command"),
            Frame(0x301, struct.pack("<fb", 0.75, 77)),
        ]
    )
    ((_, answer),) = pair.play([upload("psi_s_command")])
    assert answer[4:] == struct.pack("<f", 0.5)


# ---- anything ----------------------------------------------------------------------------------------------

_PARTS = [entry for entry in TABLE if entry.name != "stimulus_control"]  # the C library plays no stimuli
_entries = st.one_of(
    st.sampled_from(_PARTS),
    st.sampled_from([e for e in _PARTS if e.index in (0x6040, 0x2040) or e.access == "wo"]),
)
_places = st.one_of(
    _entries.map(lambda entry: (entry.index, entry.sub)),
    st.tuples(_entries.map(lambda entry: entry.index), st.integers(0, 255)).filter(
        lambda at: at != (0x2060, 1)
    ),
)
_values = st.one_of(
    st.binary(min_size=4, max_size=4),
    st.integers(0, 300).map(lambda n: n.to_bytes(4, "little")),
    st.floats(-10, 10, width=32).map(lambda x: struct.pack("<f", x)),
    st.sampled_from([entry.mapping for entry in TABLE if entry.mappable]).map(
        lambda mapping: mapping.to_bytes(4, "little")
    ),
)
_initiations = st.builds(
    lambda command, place, value: Frame(
        0x600 + NODE, bytes([command, *place[0].to_bytes(2, "little"), place[1]]) + value
    ),
    st.sampled_from(
        [0x20, 0x21, 0x22, 0x23, 0x27, 0x2B, 0x2F, 0x40, 0x40, 0xA0, 0xA4, 0xC0, 0xC2, 0xC4, 0xC6]
    ),
    _places,
    _values,
)
_continuations = st.builds(
    lambda command, rest: Frame(0x600 + NODE, bytes([command]) + rest),
    st.sampled_from(
        [
            0x00,
            0x01,
            0x10,
            0x11,
            0x07,
            0x60,
            0x70,
            0x80,
            0xA1,
            0xA2,
            0xA3,
            0x01,
            0x02,
            0x81,
            0x82,
            0xC1,
            0xCD,
            0xD5,
        ]
    ),
    st.one_of(
        st.binary(min_size=7, max_size=7), st.integers(0, 3).map(lambda n: bytes([n, 3, 0, 0, 0, 0, 0]))
    ),
)
_matching_writes = st.builds(
    lambda entry, value: download(entry.index, entry.sub, value[: entry.type.bits // 8 or 4]),
    _entries,
    _values,
)
_SEGMENTED = [entry for entry in TABLE if entry.type.bits == 0]


def _block_upload(entry: Entry, size: int, acknowledged: int, next_size: int) -> list[Step]:
    head = bytes([0xA4, *entry.index.to_bytes(2, "little"), entry.sub, size, 0, 0, 0])
    requests = (head, b"\xa3" + bytes(7), bytes([0xA2, acknowledged, next_size, 0, 0, 0, 0, 0]))
    return [Frame(0x600 + NODE, request) for request in requests]


def _segmented_upload(entry: Entry, segments: int) -> list[Step]:
    return [
        upload(entry.name),
        *(sdo(f"{0x60 | n % 2 << 4:02X} 00 00 00 00 00 00 00") for n in range(segments)),
    ]


def _block_download(entry: Entry, data: bytes, spoilt: bool) -> list[Step]:
    announced = len(data).to_bytes(4, "little")
    segments = [data[i : i + 7] for i in range(0, len(data), 7)]
    crc = (binascii.crc_hqx(data, 0) ^ spoilt).to_bytes(2, "little")
    return [
        Frame(0x600 + NODE, bytes([0xC6, *entry.index.to_bytes(2, "little"), entry.sub]) + announced),
        *(
            Frame(0x600 + NODE, bytes([n | (n == len(segments)) << 7]) + part.ljust(7, b"\0"))
            for n, part in enumerate(segments, start=1)
        ),
        Frame(0x600 + NODE, bytes([0xC1 | (7 * len(segments) - len(data)) << 2]) + crc + bytes(5)),
    ]


_transfers: st.SearchStrategy[list[Step]] = st.one_of(
    _initiations.map(lambda frame: [frame]),
    _continuations.map(lambda frame: [frame]),
    _matching_writes.map(lambda frame: [frame]),
    st.builds(
        _block_upload,
        st.one_of(st.sampled_from(_SEGMENTED), _entries),
        st.integers(0, 128),
        st.integers(0, 5),
        st.integers(0, 128),
    ),
    st.builds(_segmented_upload, st.sampled_from(_SEGMENTED), st.integers(1, 5)),
    st.builds(
        _block_download,
        _entries,
        _values | st.binary(min_size=1, max_size=20),
        st.sampled_from([False] * 3 + [True]),
    ),
)
_process_data: st.SearchStrategy[list[Step]] = st.one_of(
    st.builds(
        set_up_pdo,
        st.sampled_from(["tpdo1", "tpdo2", "tpdo6", "tpdo8"]),
        st.integers(0x17F, 0x1A0),
        st.lists(st.sampled_from(["omega_m", "tick", "i_a", "statusword", "controlword"]), max_size=3),
        st.integers(0, 2),
    ),
    st.builds(
        set_up_pdo,
        st.sampled_from(["rpdo1", "rpdo2"]),
        st.sampled_from([0x201, 0x301]),
        st.lists(st.sampled_from(["torque_command", "omega_m_command", "controlword"]), max_size=3),
    ),
    st.builds(
        lambda can_id, data: [Frame(can_id, data)],
        st.sampled_from([0x201, 0x301, 0x080, 0x181]),
        st.binary(max_size=8) | st.tuples(_values, _values).map(b"".join),
    ),
)
_life: st.SearchStrategy[list[Step]] = st.one_of(
    st.integers(1, 30).map(lambda n: [Ticks(n)]),
    st.integers(1, 30).map(lambda n: [nmt(START), Ticks(n)]),
    st.sampled_from([1, 2, 128, 129, 130, 77]).map(lambda command: [ABORT, nmt(command)]),
    st.sampled_from([6, 7, 15, 0, 2, 0x80, 0x10F]).map(lambda word: [write("controlword", word)]),
    st.just([write("controlword", 0x80), *ENABLE]),
    st.binary(max_size=2).map(lambda data: [Frame(0x700 + HOST, data)]),
    st.integers(0, 5).map(
        lambda ms: [write("host_heartbeat", HOST << 16 | ms), Frame(0x700 + HOST, b"\x05")]
    ),
    st.sampled_from(TRIPS).map(lambda code: [Tripped(code)]),
)
_steps = st.one_of(_transfers, _transfers, _process_data, _life, _life)


@settings(max_examples=60, phases=[Phase.explicit, Phase.generate])  # to shrink one takes minutes
@given(st.lists(_steps, min_size=10, max_size=60))
def test_nothing_tells_the_two_apart(
    can_library: Path, parameters: list[int], steps: list[list[Step]]
) -> None:
    both = Pair(can_library, parameters)
    try:
        both.play(step for some in steps for step in some)
    finally:
        both.close()
