"""Parts of a block keep its time base and its gaps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.block import Block, Channel, Gap
from benchtool.errors import AnalysisError
from benchtool.results.windows import longest_unbroken, rows_of, unbroken, without


@st.composite
def blocks(draw: st.DrawFn) -> Block:
    rows = draw(st.integers(1, 60))
    at = draw(st.lists(st.integers(1, rows - 1), unique=True, max_size=5)) if rows > 1 else []
    gaps = tuple(Gap(row, draw(st.integers(1, 9))) for row in sorted(at))
    stride = draw(st.integers(1, 50))
    data = np.arange(rows, dtype=np.float64)[:, None]
    return Block((Channel("row", ""),), draw(st.integers(0, 10**9)), stride, 1e-4, data, gaps)


@given(blocks(), st.data())
def test_every_row_keeps_its_tick(block: Block, data: st.DataObject) -> None:
    first = data.draw(st.integers(0, len(block.data) - 1))
    last = data.draw(st.integers(first + 1, len(block.data)))
    part = rows_of(block, first, last)
    np.testing.assert_array_equal(part.ticks(), block.ticks()[first:last])
    np.testing.assert_array_equal(part.column("row"), np.arange(first, last))


@given(blocks(), st.floats(-0.1, 1.0), st.floats(1e-3, 1.0))
def test_a_window_has_the_rows_of_its_time_and_no_others(
    block: Block, from_s: float, length_s: float
) -> None:
    time_s = block.time_s()
    inside = (time_s >= from_s - 1e-9) & (time_s < from_s + length_s - 1e-9)
    if not inside.any():
        with pytest.raises(AnalysisError, match="no row lies from"):
            block.crop(from_s, from_s + length_s)
        return
    window = block.crop(from_s, from_s + length_s)
    np.testing.assert_array_equal(window.ticks(), block.ticks()[inside])


@given(blocks())
def test_the_stretches_without_a_gap_are_all_rows(block: Block) -> None:
    parts = list(unbroken(block))
    assert all(not part.gaps for part in parts)
    np.testing.assert_array_equal(np.concatenate([part.ticks() for part in parts]), block.ticks())
    assert len(longest_unbroken(block).data) == max(len(part.data) for part in parts)
    missing = sum(gap.missing_rows for gap in block.gaps)
    assert block.duration_s == pytest.approx((len(block.data) + missing) * block.stride * 1e-4)


@pytest.mark.parametrize(("from_s", "to_s"), [(2.0, 1.0), (1.0, 1.0), (float("nan"), 1.0)])
def test_a_window_without_length_is_refused(from_s: float, to_s: float) -> None:
    block = Block((Channel("a", ""),), 0, 1, 1e-4, np.zeros((5, 1)))
    with pytest.raises(AnalysisError, match="has no length: give the earlier end first"):
        block.crop(from_s, to_s)


def test_a_block_without_a_channel_keeps_the_others() -> None:
    block = Block((Channel("a", "A"), Channel("b", "V")), 0, 1, 1e-4, np.array([[1.0, 2.0]]))
    assert without(block, {"a"}).column("b")[0] == 2.0
    assert without(block, {"a"}).names == ("b",)
    assert without(block, {"c"}) is block
