"""Targets, halt, quick stop, sizes, wrap of the tick: both drives follow CiA 301 and 402 alike."""

from __future__ import annotations

import struct
from itertools import pairwise
from pathlib import Path

import pytest

from tests.device.can_endpoints import (
    ENABLE,
    HEARD,
    HOST,
    NODE,
    RESET,
    START,
    STOP,
    Frame,
    Frames,
    Pair,
    Step,
    Ticks,
    Tripped,
    nmt,
    sdo,
    set_up_pdo,
    upload,
    write,
)
from tests.wire.raw_host import TABLE

TARGETS = {"target_torque": 50, "target_velocity": 1000, "torque_command": 0.0, "omega_m_command": 1.0}
WRITTEN: list[Step] = [write("target_torque", 50), write("target_velocity", 1000)]
HALT = 0x10F
TARGET_REACHED = 1 << 10
TORQUE_MODE, VELOCITY_MODE = 4, 3


def _read(pair: Pair, name: str) -> float:
    ((can_id, answer),) = pair.play([upload(name)])
    assert can_id == 0x580 + NODE
    entry = TABLE.by_name[name]
    data = answer[4 : 4 + entry.type.bits // 8]
    return float(struct.unpack("<f", data)[0]) if entry.type.name == "F32" else int.from_bytes(data, "little")


def _status(pair: Pair) -> int:
    """State and "target reached" of the statusword."""
    return int(_read(pair, "statusword")) & (TARGET_REACHED | 0x6F)


def _targets(pair: Pair) -> list[bool]:
    """Whether each of the four has a value."""
    return [_read(pair, name) != 0 for name in TARGETS]


@pytest.mark.parametrize("word", [0x06, 0x07, 0x00, 0x02])
def test_a_target_written_before_enabling_outlives_it_and_disabling(pair: Pair, word: int) -> None:
    pair.play([*WRITTEN, *ENABLE, Ticks(3)])
    assert _targets(pair) == [True] * 4
    pair.play([write("controlword", word), Ticks(600), upload("statusword")])
    assert _targets(pair) == [True] * 4


@pytest.mark.parametrize(
    "steps",
    [
        [Tripped(0x2310)],
        [nmt(STOP), nmt(START)],
        [nmt(RESET)],
        [write("controlword", 0), write("mode_of_operation", VELOCITY_MODE)],
        *(
            [
                write("controlword", 0),
                write("abort_connection_option", action),
                write("host_heartbeat", HOST << 16 | 5),
                HEARD,
                *WRITTEN,
                *ENABLE,
                Ticks(51),
            ]
            for action in (1, 2, 3)
        ),
    ],
    ids=["fault", "NMT stop", "reset", "mode", "link: fault", "link: disable", "link: quick stop"],
)
def test_what_makes_a_fresh_command_necessary(pair: Pair, steps: list[Step]) -> None:
    pair.play([*WRITTEN, *ENABLE, Ticks(3)])
    assert _targets(pair) == [True] * 4
    pair.play(steps)
    assert _targets(pair) == [False] * 4


@pytest.mark.parametrize("mode", [TORQUE_MODE, VELOCITY_MODE])
def test_a_halt_keeps_the_state_and_the_target_and_tells_when_it_stands(pair: Pair, mode: int) -> None:
    pair.play([write("mode_of_operation", mode), *ENABLE, write("controlword", HALT)])
    pair.play([*WRITTEN, Ticks(20)])
    assert _status(pair) == TARGET_REACHED | 0x27
    assert _targets(pair) == [True] * 4
    pair.play([write("controlword", 0x0F)])
    assert _status(pair) == 0x27
    pair.play([Ticks(5), upload("statusword")])
    assert _targets(pair) == [True] * 4


def test_a_quick_stop_of_a_halted_axis_brakes_first(pair: Pair) -> None:
    pair.play([write("mode_of_operation", VELOCITY_MODE), write("omega_m_command", 20.0), *ENABLE])
    pair.play([Ticks(500), write("controlword", HALT), Ticks(1), write("controlword", 0x102)])
    assert _status(pair) == 0x07
    pair.play([Ticks(1500), upload("statusword")])


@pytest.mark.parametrize("command", ["22", "2E"])
def test_an_expedited_download_without_size_has_that_of_its_object(pair: Pair, command: str) -> None:
    assert pair.ask(f"{command} 60 60 00 03 AA BB CC") == ["60 60 60 00 00 00 00 00"]
    assert pair.ask("40 60 60 00 00 00 00 00") == ["4F 60 60 00 03 00 00 00"]
    assert pair.ask(f"{command} 40 60 00 06 00 BB CC") == ["60 40 60 00 00 00 00 00"]
    assert pair.ask(f"{command} 41 60 00 00 00 00 00") == ["80 41 60 00 02 00 01 06"]
    assert pair.ask(f"{command} FF 5F 00 00 00 00 00") == ["80 FF 5F 00 00 00 02 06"]
    assert pair.ask(f"{command} 08 10 00 00 00 00 00")[0].startswith("80 08 10 00")


def test_a_segmented_download_without_size_has_what_comes(pair: Pair) -> None:
    assert pair.ask("20 60 60 00 AA BB CC DD") == ["60 60 60 00 00 00 00 00"]
    assert pair.ask("0D 03 00 00 00 00 00 00") == ["20 00 00 00 00 00 00 00"]
    assert pair.ask("40 60 60 00 00 00 00 00") == ["4F 60 60 00 03 00 00 00"]


def test_an_error_reset_is_told_and_is_no_error(pair: Pair) -> None:
    pair.play([*ENABLE, Ticks(3), Tripped(0x8400), write("controlword", 0)])
    frames = pair.play([write("controlword", 0x80)])
    assert (0x080 + NODE, bytes(8)) in frames
    assert [_read(pair, name) for name in ("error_history_count", "error_1", "error_code")] == [1, 0x8400, 0]


# ---- the wrap of the tick ----------------------------------------------------------------------------------

BEFORE = 195
FIRST_TICK = 2**32 - BEFORE


def _ticks_of(frames: Frames, can_id: int) -> list[int]:
    return [int.from_bytes(data[:4], "little") for each, data in frames if each == can_id]


def _on_grid(first: int, last: int, period: int) -> list[int]:
    """Multiples of a period since power-up after `first`, up to `last`, as the wire has them."""
    return [tick % 2**32 for tick in range((first // period + 1) * period, last + 1, period)]


def test_process_data_and_heartbeats_keep_their_periods_over_the_wrap(
    can_library: Path, parameters: list[int]
) -> None:
    both = Pair(can_library, parameters, FIRST_TICK)
    try:
        both.play([*set_up_pdo("tpdo1", 0x181, ["tick", "omega_m"], 1), write("producer_heartbeat", 30)])
        frames = both.play([nmt(START), Ticks(2 * BEFORE)])
        middle = FIRST_TICK + 2 * BEFORE
        assert _ticks_of(frames, 0x181) == _on_grid(FIRST_TICK, middle, 10)
        assert sum(can_id == 0x700 + NODE for can_id, _ in frames) == len(_on_grid(FIRST_TICK, middle, 300))
        # Set up again after the wrap it is on the same grid: 2**32 is no multiple of 30.
        both.play([*set_up_pdo("tpdo1", 0x181, ["tick"], 3)])
        frames = both.play([Ticks(100)])
        assert _ticks_of(frames, 0x181) == _on_grid(middle, middle + 100, 30)
    finally:
        both.close()


def test_a_silent_host_is_noticed_over_the_wrap(can_library: Path, parameters: list[int]) -> None:
    both = Pair(can_library, parameters, FIRST_TICK)
    try:
        both.play([write("host_heartbeat", HOST << 16 | 20), Ticks(BEFORE - 100), HEARD, *ENABLE])
        assert both.play([Ticks(196)]) == []
        assert both.play([Ticks(1)]) == [(0x080 + NODE, bytes.fromhex("30 81 11 00 00 00 00 00"))]
    finally:
        both.close()


def test_a_capture_spans_the_wrap(can_library: Path, parameters: list[int]) -> None:
    both = Pair(can_library, parameters, FIRST_TICK)
    try:
        setup = {"capture_rows": 40, "capture_stride": 3, "capture_pretrigger": 10, "capture_trigger": 1}
        both.play([write("capture_channel_1", TABLE.by_name["tick"].mapping)])
        both.play([write(name, value) for name, value in setup.items()])
        both.play([write("capture_control", 1), Ticks(BEFORE - 5), write("omega_m_command", 3.0), Ticks(130)])
        answers = both.ask("A4 42 20 00 7F 00 00 00") + both.ask("A3 00 00 00 00 00 00 00")
        data = b"".join(bytes.fromhex(answer)[1:] for answer in answers[1:])
        rows = struct.unpack("<40I", data[32 : 32 + 160])
        assert rows[0] > 2**31 > rows[-1]
        assert [(after - before) % 2**32 for before, after in pairwise(rows)] == [3] * 39
    finally:
        both.close()


def test_process_data_with_a_refused_value_do_nothing(pair: Pair) -> None:
    """Not even what stands before that value: here the controlword."""
    pair.play(set_up_pdo("rpdo1", 0x201, ["controlword", "torque_command"]))
    pair.play([nmt(START), write("controlword", 6), Frame(0x201, struct.pack("<Hf", 7, float("nan")))])
    assert _status(pair) == 0x21
    assert _read(pair, "rpdo_dropped") == 1
    assert pair.play([sdo("40 40 60 00 00 00 00 00")])[0][1][4] == 6
