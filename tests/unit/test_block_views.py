"""A block cropped, joined, and as pandas, Arrow, columns, HTML and a picture."""

from __future__ import annotations

import builtins
import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.block import Block, Channel, Gap
from benchtool.errors import AnalysisError, UsageError

CHANNELS = (Channel("torque", "Nm"), Channel("i_a", "A"), Channel("<count>", ""))


@st.composite
def blocks(draw: st.DrawFn) -> Block:
    """Blocks with gaps, of any stride, that begin anywhere."""
    rows = draw(st.integers(2, 40))
    places = sorted(draw(st.sets(st.integers(1, rows - 1), max_size=4)))
    gaps = tuple(Gap(place, draw(st.integers(1, 9))) for place in places)
    data = np.arange(3.0 * rows).reshape(rows, 3)
    return Block(CHANNELS, draw(st.integers(0, 1 << 40)), draw(st.integers(1, 20)), 1e-4, data, gaps)


@given(blocks(), st.data())
def test_parts_of_a_block_are_the_block_again(block: Block, data: st.DataObject) -> None:
    cut = data.draw(st.integers(1, len(block.data) - 1))
    cut_s = float(block.time_s()[cut])
    first, second = block.crop(end_s=cut_s), block.crop(begin_s=cut_s)
    assert len(first.data) == cut
    assert np.array_equal(np.concatenate([first.ticks(), second.ticks()]), block.ticks())
    joined = Block.joined([first, second])
    assert np.array_equal(joined.ticks(), block.ticks())
    assert np.array_equal(joined.data, block.data)
    assert joined.gaps == block.gaps
    assert second.time_s()[0] == 0.0
    assert first.data.base is not None  # no copy


@given(blocks())
def test_a_duration_counts_what_is_missing(block: Block) -> None:
    row_s = block.stride * block.tick_s
    assert block.duration_s == pytest.approx(block.time_s()[-1] + row_s)


@pytest.mark.parametrize(
    "times", [(0.01, 0.02), (0.002, 0.001), (math.nan, 1.0), (0.0, math.nan), (0.001, 0.001)]
)
def test_a_crop_without_a_row_is_refused(times: tuple[float, float]) -> None:
    block = Block.from_arrays(1000.0, {}, torque=np.zeros(5))
    with pytest.raises(AnalysisError, match=r"no row lies|has no length"):
        block.crop(*times)


def test_what_does_not_follow_is_not_joined() -> None:
    block = Block.from_arrays(1000.0, {}, torque=np.zeros(5))
    with pytest.raises(AnalysisError, match="tick 0, tick 5"):
        Block.joined([block, block])
    with pytest.raises(AnalysisError, match="at 500 Hz"):
        Block.joined([block, Block.from_arrays(500.0, {}, torque=np.zeros(5))])
    with pytest.raises(AnalysisError, match="no block to join"):
        Block.joined([])


def test_columns_frame_and_arrow_have_names_units_and_time_and_no_copy() -> None:
    data = np.asfortranarray(np.arange(12.0).reshape(4, 3))
    block = Block(CHANNELS, 7, 2, 1e-3, data, (Gap(2, 1),))
    frame = block.to_pandas()
    assert list(frame.columns) == ["torque", "i_a", "<count>"]
    assert frame.index.name == "time_s"
    assert frame.index.tolist() == pytest.approx([0.0, 0.002, 0.006, 0.008])
    assert frame.attrs["units"] == {"torque": "Nm", "i_a": "A", "<count>": ""}
    assert np.shares_memory(frame["i_a"].to_numpy(), data)
    batch = block.to_arrow()
    assert batch.schema.names == ["time_s", "torque", "i_a", "<count>"]
    assert batch.schema.field("torque").metadata == {b"unit": b"Nm"}
    assert batch.column("i_a").to_pylist() == data[:, 1].tolist()
    assert np.shares_memory(batch.column("i_a").to_numpy(), data)
    assert np.shares_memory(block.columns["torque"], data)
    assert np.array_equal(block["torque"], block.column("torque"))


def test_without_pandas_the_line_that_installs_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    imported = builtins.__import__

    def missing(name: str, *arguments: Any) -> Any:
        if name == "pandas":
            raise ImportError(name)
        return imported(name, *arguments)

    monkeypatch.setattr(builtins, "__import__", missing)
    with pytest.raises(UsageError, match=r"pip install 'benchtool\[pandas\]'"):
        Block.from_arrays(1000.0, {}, torque=np.zeros(5)).to_pandas()


def test_a_notebook_shows_numbers_and_nothing_of_a_name_is_html() -> None:
    block = Block(CHANNELS, 0, 1, 1e-3, np.array([[1.0, math.nan, 2.0], [3.0, math.nan, 2.0]]))
    shown = block._repr_html_()
    assert "&lt;count&gt;" in shown
    assert "<count>" not in shown
    assert "2 rows at 1000 Hz" in shown
    assert "nan" in shown
    assert "torque [Nm]" in repr(block)


def test_a_picture_has_a_panel_for_each_unit_and_a_break_at_a_gap() -> None:
    block = Block(CHANNELS, 0, 1, 1e-3, np.zeros((4, 3)), (Gap(2, 3),))
    plot = block.plot("torque", "i_a")
    assert [axes.get_ylabel() for axes in plot.figure.axes] == ["torque in Nm", "i_a in A"]
    (line,) = plot.figure.axes[0].lines
    drawn = np.asarray(line.get_ydata())
    assert np.flatnonzero(np.isnan(drawn)).tolist() == [2]
    assert plot._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(AnalysisError, match="no channel 'torqe'"):
        block.plot("torqe")


def test_a_block_is_pickled() -> None:
    block = Block.from_arrays(1000.0, {"torque": "Nm"}, torque=np.arange(5.0))
    again = pickle.loads(pickle.dumps(block))
    assert np.array_equal(again.data, block.data)
    assert again.channels == block.channels
