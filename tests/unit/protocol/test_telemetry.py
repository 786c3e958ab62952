"""Records of the slow stream: what comes out is what the drive sent, or a gap in its place."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.block import Block
from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.telemetry import RecordDecoder, StreamLayout, most_channels, stream_layout
from benchtool.shipped import shipped

NODE = 3
DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", NODE)
CHANNELS = ("i_a", "switching_count", "torque", "omega_m", "psi_s", "u_dc")
LAYOUT = stream_layout(DICTIONARY, NODE, CHANNELS, 100.0, 1e-4)
STRIDE = 100
FRAMES = 5  # tick, sequence | 2 | 2 | 2 | sequence

Frame = tuple[int, bytes]


def record(number: int, *, first_tick: int = 500, layout: StreamLayout = LAYOUT) -> list[Frame]:
    """PDOs of record `number`, whose values all tell the number."""
    tick = (first_tick + number * layout.stride) % 2**32
    values = [
        struct.pack("<f" if channel.type == "f32" else "<I", number * 100 + column)
        for column, channel in enumerate(layout.channels)
    ]
    words = [struct.pack("<I", tick), struct.pack("<I", number), *values, struct.pack("<I", number)]
    pairs = [b"".join(words[start : start + 2]) for start in range(0, len(words), 2)]
    return [(pdo.can_id, pair) for pdo, pair in zip(layout.pdos, pairs, strict=True)]


def decoded(frames: list[Frame], decoder: RecordDecoder | None = None) -> Block | None:
    decoder = decoder or RecordDecoder(LAYOUT)
    for can_id, data in frames:
        decoder.feed(can_id, data, 0.0)
    return decoder.pop_block()


def numbers(block: Block | None) -> list[int]:
    """Numbers of the records of a block; every value of a row must be of the same record."""
    if block is None:
        return []
    assert block.data[:, 1:].tolist() == [[row[0] + column for column in range(1, 6)] for row in block.data]
    return [int(row[0]) // 100 for row in block.data]


def test_the_layout_is_in_the_order_of_the_wire() -> None:
    assert [pdo.can_id for pdo in LAYOUT.pdos] == [0x183, 0x1C3, 0x283, 0x383, 0x483]
    assert [pdo.number for pdo in LAYOUT.pdos] == [1, 5, 2, 3, 4]
    tick, sequence = DICTIONARY["tick"].mapping, DICTIONARY["stream_sequence"].mapping
    assert LAYOUT.pdos[0].mappings == (tick, sequence)
    assert LAYOUT.pdos[-1].mappings == (sequence,)
    assert LAYOUT.stride == STRIDE
    assert LAYOUT.period_s == pytest.approx(0.01)


def test_records_become_rows_with_their_units_and_ticks() -> None:
    block = decoded([frame for number in range(7) for frame in record(number)])
    assert block is not None
    assert numbers(block) == list(range(7))
    assert (block.first_tick, block.stride, block.tick_s, block.gaps) == (500, STRIDE, 1e-4, ())
    assert [(channel.name, channel.unit) for channel in block.channels][:2] == [
        ("i_a", "A"),
        ("switching_count", ""),
    ]


@given(st.lists(st.integers(0, 6 * FRAMES - 1), unique=True), st.integers(1, 4))
def test_whatever_is_lost_no_row_is_mixed_and_every_gap_is_where_it_was(lost: list[int], batch: int) -> None:
    sent = [(number, frame) for number in range(6) for frame in record(number)]
    whole = [n for n in range(6) if not any(n * FRAMES <= frame < (n + 1) * FRAMES for frame in lost)]
    decoder = RecordDecoder(LAYOUT)
    blocks = []
    for position, (_, frame) in enumerate(sent):
        if position not in lost:
            decoder.feed(*frame, 0.0)
        if decoder.rows >= batch and (block := decoder.pop_block()):
            blocks.append(block)
    if (rest := decoder.pop_block()) is not None:
        blocks.append(rest)
    assert [number for block in blocks for number in numbers(block)] == whole
    ticks = [tick for block in blocks for tick in block.ticks()]
    assert ticks == [500 + number * STRIDE for number in whole]
    counters = decoder.counters
    assert counters.received == len(whole)
    inside = whole[-1] - whole[0] + 1 - len(whole) if whole else 0
    assert (counters.missing, counters.lost) == (inside, inside)


def test_a_loss_from_within_a_record_to_within_the_next_mixes_nothing() -> None:
    """As many frames as a record has: the order alone would not show it."""
    frames = [frame for number in range(4) for frame in record(number)]
    del frames[7 : 7 + FRAMES]
    decoder = RecordDecoder(LAYOUT)
    assert numbers(decoded(frames, decoder)) == [0, 3]
    assert decoder.counters.missing == 2
    assert decoder.counters.incomplete == 1


def test_records_that_the_drive_did_not_send_are_missing_but_not_lost() -> None:
    late = [(can_id, data) for can_id, data in record(1, first_tick=500 + 3 * STRIDE)]
    decoder = RecordDecoder(LAYOUT)
    block = decoded(record(0) + late, decoder)
    assert block is not None
    assert [(gap.row, gap.missing_rows) for gap in block.gaps] == [(1, 3)]
    assert (decoder.counters.missing, decoder.counters.lost) == (3, 0)


def test_the_tick_may_wrap() -> None:
    start = 2**32 - 2 * STRIDE
    block = decoded([frame for n in range(4) for frame in record(n, first_tick=start)])
    assert block is not None
    assert block.ticks().tolist() == [start + n * STRIDE for n in range(4)]


@pytest.mark.parametrize("rows", [2**30 // STRIDE + 1, 2**31 // STRIDE - 1])
@pytest.mark.parametrize("first_tick", [0, 2**31 - STRIDE, 2**32 - STRIDE])
def test_a_gap_of_days_is_as_long_as_its_ticks_say(first_tick: int, rows: int) -> None:
    """Up to half of the tick's range, past its wrap or not."""
    decoder = RecordDecoder(LAYOUT)
    late = record(1, first_tick=first_tick + rows * STRIDE)
    block = decoded(record(0, first_tick=first_tick) + late, decoder)
    assert block is not None
    assert block.ticks().tolist() == [first_tick, first_tick + (rows + 1) * STRIDE]
    assert decoder.counters.missing == rows
    assert decoder.counters.off_grid == 0


@pytest.mark.parametrize("ticks", [-STRIDE, 0, 37, -37])
def test_a_record_off_the_time_base_is_counted_and_left_out(ticks: int) -> None:
    decoder = RecordDecoder(LAYOUT)
    frames = record(0) + record(0, first_tick=500 + ticks) + record(1)
    assert numbers(decoded(frames, decoder)) == [0, 1]
    assert decoder.counters.off_grid == 1
    assert (decoder.counters.missing, decoder.counters.lost) == (0, 0)


@given(st.lists(st.tuples(st.sampled_from([0x183, 0x1C3, 0x283, 0x483, 0x99]), st.binary(max_size=8))))
def test_no_bytes_raise(frames: list[Frame]) -> None:
    decoder = RecordDecoder(LAYOUT)
    decoded(frames, decoder)
    known = [data for can_id, data in frames if can_id != 0x99]
    assert decoder.counters.malformed <= len(known)


def test_a_frame_of_a_wrong_length_ends_its_record() -> None:
    frames = record(0)
    frames[2] = (frames[2][0], frames[2][1][:7])
    decoder = RecordDecoder(LAYOUT)
    assert numbers(decoded(frames + record(1), decoder)) == [1]
    assert (decoder.counters.malformed, decoder.counters.incomplete) == (1, 1)


def test_floats_keep_their_bits() -> None:
    layout = stream_layout(DICTIONARY, NODE, ("torque",), 1000.0, 1e-4)
    value = struct.pack("<I", 0x3DCCCCCD)
    stamp = struct.pack("<II", 10, 1)
    frames = [(layout.pdos[0].can_id, stamp), (layout.pdos[1].can_id, value + struct.pack("<I", 1))]
    block = decoded(frames, RecordDecoder(layout))
    assert block is not None
    assert np.float32(block.data[0, 0]).tobytes() == value


@pytest.mark.parametrize(
    ("names", "rate_Hz", "complaint"),
    [
        (("torqe",), 100.0, "did you mean 'torque'"),
        ((), 100.0, "one or more different signals"),
        (("torque", "torque"), 100.0, "one or more different signals"),
        (("R_s",), 100.0, "cannot be a channel"),
        (("statusword",), 100.0, "a signal of four bytes is expected"),
        (
            (*CHANNELS, "i_b", "i_c", "i_d", "i_q", "u_alpha", "u_beta", "theta_m", "psi_alpha"),
            1.0,
            "13",
        ),
        (("torque",), 300.0, "choose 333.333 Hz"),
        (("torque",), 5000.0, "choose 1000 Hz"),
        (("torque",), 0.0, "is not possible"),
        (("torque",), float("nan"), "is not possible"),
    ],
)
def test_what_cannot_be_streamed_is_refused(names: tuple[str, ...], rate_Hz: float, complaint: str) -> None:
    with pytest.raises(ValueRefused, match=complaint):
        stream_layout(DICTIONARY, NODE, names, rate_Hz, 1e-4)


def test_a_high_node_id_has_four_tpdos() -> None:
    assert len(stream_layout(DICTIONARY, 64, CHANNELS[:5], 100.0, 1e-4).pdos) == 4
    assert [most_channels(node_id) for node_id in (1, 63, 64, 127)] == [13, 13, 5, 5]
    with pytest.raises(ValueRefused, match="choose fewer"):
        stream_layout(DICTIONARY, 64, CHANNELS, 100.0, 1e-4)
