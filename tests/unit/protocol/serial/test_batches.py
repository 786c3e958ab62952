"""Batches: rows are what the drive measured, at the tick it measured them, or a gap in their place."""

from __future__ import annotations

import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.block import Block, Gap
from benchtool.errors import ValueRefused
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.serial import Batch, BatchDecoder
from benchtool.shipped import shipped
from tests.unit.protocol.serial.reference import VECTORS

DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
CHANNELS = [DICTIONARY[name] for name in ("torque", "switching_count", "i_a")]
STRIDE, SCHEMA, TICK_S = 3, 7, 1e-4
START = 1000


def decoder(stride: int = STRIDE) -> BatchDecoder:
    return BatchDecoder(CHANNELS, stride, TICK_S, 0, (), SCHEMA)


def batch(sequence: int, row: int, n: int, *, start: int = START) -> Batch:
    """Rows `row` to `row + n` of a stream whose values tell the row."""
    rows = b"".join(struct.pack("<fIf", each, each, -0.5 * each) for each in range(row, row + n))
    return Batch(SCHEMA, sequence % 2**32, (start + row * STRIDE) % 2**32, STRIDE, n, rows)


def rows(block: Block | None) -> list[int]:
    """Numbers of the rows of a block; values and ticks must tell the same one."""
    if block is None:
        return []
    found = [round(value) for value in block.data[:, 0]]
    assert block.data.tolist() == [[row, row, -0.5 * row] for row in found]
    assert [(tick - START) // STRIDE for tick in block.ticks()] == found
    return found


def test_batches_become_rows_with_units_ticks_and_arrival() -> None:
    taker = decoder()
    assert [taker.feed(batch(0, 0, 2), 0.5), taker.feed(batch(1, 2, 3), 0.75)] == [2, 3]
    assert (taker.rows, taker.tick, taker.arrival_s) == (5, START + 4 * STRIDE, 0.75)
    block = taker.pop_block()
    assert rows(block) == [0, 1, 2, 3, 4]
    assert block is not None
    assert (block.first_tick, block.stride, block.tick_s, block.gaps) == (START, STRIDE, TICK_S, ())
    assert [(each.name, each.unit) for each in block.channels] == [
        ("torque", "Nm"),
        ("switching_count", ""),
        ("i_a", "A"),
    ]
    assert (taker.rows, taker.pop_block()) == (0, None)


@given(
    st.lists(st.tuples(st.integers(1, 5), st.sampled_from(["sent", "lost", "not made"])), max_size=12),
    st.integers(1, 20),
)
def test_whatever_is_lost_every_row_is_right_and_every_gap_in_its_place(
    stream: list[tuple[int, str]], take_at: int
) -> None:
    """Not made: the drive missed records between two batches and says so by the tick alone."""
    taker, blocks = decoder(), []
    sequence = row = 0
    kept: list[int] = []
    missing = lost = 0
    since_missing, since_lost = 0, False
    for n, fate in stream:
        if fate == "sent":
            assert taker.feed(batch(sequence, row, n), 0.0) == n
            if kept:
                missing += since_missing
                lost += since_missing if since_lost else 0
            since_missing, since_lost = 0, False
            kept += range(row, row + n)
        else:
            since_missing += n
            since_lost |= fate == "lost"
        sequence += fate != "not made"
        row += n
        if taker.rows >= take_at and (block := taker.pop_block()):
            blocks.append(block)
    if (block := taker.pop_block()) is not None:
        blocks.append(block)
    assert [each for block in blocks for each in rows(block)] == kept
    counters = taker.counters
    assert (counters.received, counters.missing, counters.lost) == (len(kept), missing, lost)
    assert (counters.incomplete, counters.off_grid, counters.malformed) == (0, 0, 0)


def test_gaps_within_a_block() -> None:
    taker = decoder()
    for each in (batch(0, 0, 2), batch(2, 4, 1), batch(3, 8, 2)):
        taker.feed(each, 0.0)
    block = taker.pop_block()
    assert rows(block) == [0, 1, 4, 8, 9]
    assert block is not None
    assert block.gaps == (Gap(2, 2), Gap(3, 3))
    assert (taker.counters.missing, taker.counters.lost) == (5, 2)


@given(st.permutations(range(6)), st.lists(st.integers(0, 5), max_size=8))
def test_old_batches_again_or_out_of_order_are_never_taken(order: list[int], again: list[int]) -> None:
    taker = decoder()
    newest, expected, off_grid = -1, [], 0
    for number in order + again:
        taken = taker.feed(batch(number, 2 * number, 2), 0.0)
        assert taken == (2 if number > newest else 0)
        if taken:
            expected += [2 * number, 2 * number + 1]
            newest = number
        else:
            off_grid += 2
    assert rows(taker.pop_block()) == expected
    assert taker.counters.off_grid == off_grid


@pytest.mark.parametrize(
    "wrong",
    [
        replace(batch(1, 2, 2), first_tick=START + 2 * STRIDE + 1),  # off the grid
        replace(batch(1, 2, 2), first_tick=START),  # the tick of old, the sequence of now
        replace(batch(0, 2, 2), sequence=0),  # the sequence of old, the tick of now
        replace(batch(1, 2, 2), sequence=2**32 - 1),
        replace(batch(1, 2, 2), first_tick=(START - STRIDE) % 2**32),
        replace(batch(1, 2, 2), first_tick=(START + 2**31 + STRIDE) % 2**32),
        replace(batch(1, 2, 2), sequence=1 + 1),  # a batch lost, and no room for its records
        replace(batch(1, 5, 2), sequence=1 + 4),
    ],
)
def test_a_batch_that_does_not_continue_the_stream_is_left_out(wrong: Batch) -> None:
    taker = decoder()
    taker.feed(batch(0, 0, 2), 0.0)
    assert taker.feed(wrong, 1.0) == 0
    assert taker.counters.off_grid == 2
    assert taker.feed(batch(1, 2, 2), 0.0) == 2
    assert rows(taker.pop_block()) == [0, 1, 2, 3]
    assert taker.counters.missing == 0


@pytest.mark.parametrize("ticks", [-1, -8, -(2**31), 2**31, 0])
@pytest.mark.parametrize("stride", [1, 8])
def test_time_never_runs_backwards(stride: int, ticks: int) -> None:
    """Strides that divide 2**32: the way back is a whole number of them, too."""
    taker = decoder(stride)
    row = batch(0, 0, 1).data
    assert taker.feed(Batch(SCHEMA, 0, START, stride, 1, row), 0.0) == 1
    assert taker.feed(Batch(SCHEMA, 1, (START + ticks) % 2**32, stride, 1, row), 0.0) == 0
    assert (taker.counters.off_grid, taker.tick) == (1, START)


@pytest.mark.parametrize(
    "wrong",
    [
        replace(batch(1, 2, 2), data=batch(1, 2, 2).data[:-1]),
        replace(batch(1, 2, 2), data=batch(1, 2, 3).data),
        replace(batch(1, 2, 2), stride=STRIDE + 1),
        replace(batch(1, 2, 2), stride=0),
        replace(batch(1, 2, 2), n=0, data=b""),
    ],
)
def test_a_batch_of_another_shape_is_left_out(wrong: Batch) -> None:
    taker = decoder()
    taker.feed(batch(0, 0, 2), 0.0)
    assert taker.feed(wrong, 0.0) == 0
    assert taker.counters.malformed == 1
    assert rows(taker.pop_block()) == [0, 1]


def test_a_batch_of_another_schema_is_not_ours() -> None:
    taker = decoder()
    assert taker.feed(replace(batch(0, 0, 2), schema=SCHEMA - 1), 0.0) == 0
    assert taker.other_schema == 1
    assert taker.counters == decoder().counters
    assert taker.feed(batch(9, 0, 2), 0.0) == 2


def test_tick_and_sequence_may_wrap() -> None:
    start = 2**32 - 5 * STRIDE + 1
    taker = decoder()
    for number in range(5):
        assert taker.feed(batch(2**32 - 2 + number, 2 * number, 2, start=start), 0.0) == 2
    block = taker.pop_block()
    assert block is not None
    assert block.ticks().tolist() == [start + row * STRIDE for row in range(10)]
    assert taker.tick == start + 9 * STRIDE
    taker.feed(batch(2**32 - 2 + 6, 12, 2, start=start), 0.0)
    block = taker.pop_block()
    assert block is not None
    assert block.first_tick == start + 12 * STRIDE
    assert (taker.counters.missing, taker.counters.lost) == (2, 2)


@pytest.mark.parametrize("missing", [2**30 // STRIDE + 2, 2**31 // STRIDE - 2])
@pytest.mark.parametrize("start", [START, 2**32 - STRIDE])
def test_a_gap_of_days_is_as_long_as_its_ticks_say(start: int, missing: int) -> None:
    taker = decoder()
    taker.feed(batch(0, 0, 1, start=start), 0.0)
    assert taker.feed(batch(1, 1 + missing, 1, start=start), 0.0) == 1
    block = taker.pop_block()
    assert block is not None
    assert [(gap.row, gap.missing_rows) for gap in block.gaps] == [(1, missing)]
    assert block.ticks().tolist() == [start, start + (1 + missing) * STRIDE]


@pytest.mark.parametrize("lost", [2**30, 2**31 - 2])
def test_batches_lost_are_counted_past_the_wrap_of_their_sequence(lost: int) -> None:
    taker = decoder(stride=1)
    one = batch(2**32 - 1, 0, 1).data
    taker.feed(Batch(SCHEMA, 2**32 - 1, START, 1, 1, one), 0.0)
    assert taker.feed(Batch(SCHEMA, lost, START + lost + 1, 1, 1, one), 0.0) == 1
    assert taker.counters.lost == lost


def test_a_batch_may_wrap_within() -> None:
    start = 2**32 - 2 * STRIDE
    taker = decoder()
    taker.feed(batch(0, 0, 4, start=start), 0.0)
    taker.feed(batch(1, 4, 1, start=start), 0.0)
    block = taker.pop_block()
    assert block is not None
    assert block.gaps == ()
    assert block.ticks().tolist() == [start + row * STRIDE for row in range(5)]


def test_words_keep_their_bits_and_their_type() -> None:
    taker = decoder(1)
    words = struct.pack("<III", 0x3DCCCCCD, 0xFFFFFFFF, 0x7F800000)
    taker.feed(Batch(SCHEMA, 0, 0, 1, 1, words), 0.0)
    block = taker.pop_block()
    assert block is not None
    assert np.float32(block.data[0, 0]).tobytes() == words[:4]
    assert block.data[0, 1:].tolist() == [2**32 - 1, np.inf]


def test_factors_of_the_dictionary_apply() -> None:
    scaled = replace(DICTIONARY["torque"], factor=0.25)
    for layout, scales, data, expected in (
        (0, (), struct.pack("<ff", 3.0, 5.0), [0.75, 5.0]),
        (1, (0.5, 2.0), struct.pack("<hh", 3, 5), [0.375, 10.0]),
    ):
        taker = BatchDecoder([scaled, DICTIONARY["i_a"]], 1, TICK_S, layout, scales, SCHEMA)
        taker.feed(Batch(SCHEMA, 0, 0, 1, 1, data), 0.0)
        block = taker.pop_block()
        assert block is not None
        assert block.data.tolist() == [expected]


def test_scaled_values_are_read_as_the_vectors_send_them() -> None:
    for vector in VECTORS["scaled"]:
        taker = BatchDecoder([DICTIONARY["torque"]], 1, TICK_S, 1, [vector["scale"]], SCHEMA)
        taker.feed(Batch(SCHEMA, 0, 0, 1, 1, struct.pack("<h", vector["raw"])), 0.0)
        block = taker.pop_block()
        assert block is not None
        if vector["raw"] == -32768:
            assert np.isnan(block.data[0, 0])
        else:
            assert abs(block.data[0, 0] - vector["value"]) <= vector["scale"] / 2


def test_a_scale_is_what_the_wire_carries_of_it() -> None:
    taker = BatchDecoder([DICTIONARY["torque"]], 1, TICK_S, 1, [0.1], SCHEMA)
    taker.feed(Batch(SCHEMA, 0, 0, 1, 1, struct.pack("<h", 1000)), 0.0)
    block = taker.pop_block()
    assert block is not None
    assert block.data[0, 0] == 1000 * float(np.float32(0.1))


@given(st.lists(st.builds(Batch, *[st.integers(-2, 9)] * 5, st.binary(max_size=60))))
def test_no_batch_raises(batches: list[Batch]) -> None:
    taker = BatchDecoder(CHANNELS, STRIDE, TICK_S, 0, (), 1)
    for each in batches:
        taker.feed(each, 0.0)
    block = taker.pop_block()
    assert (0 if block is None else len(block.data)) == taker.counters.received


@pytest.mark.parametrize(
    ("names", "layout", "scales", "complaint"),
    [
        ((), 0, (), "one or more of f32"),
        (("statusword",), 0, (), r"statusword \(u16\)"),
        (("torque",), 0, (1.0,), "1 scales for 1 channels of format 0"),
        (("torque", "i_a"), 1, (1.0,), "1 scales for 2 channels of format 1"),
    ],
)
def test_what_cannot_be_a_stream_is_refused(
    names: tuple[str, ...], layout: int, scales: tuple[float, ...], complaint: str
) -> None:
    with pytest.raises(ValueRefused, match=complaint):
        BatchDecoder([DICTIONARY[name] for name in names], 1, TICK_S, layout, scales, SCHEMA)
