"""Decimation for drawing: no peak is lost, a gap stays a gap."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.block import Block, Channel, Gap
from benchtool.report.figures.envelope import COLUMNS, band, envelope, trace


@given(st.integers(1, 3000), st.integers(1, 40), st.integers(0, 2**32 - 1), st.floats(0, 0.2))
def test_every_stretch_keeps_its_extremes(rows: int, columns: int, seed: int, missing: float) -> None:
    random = np.random.default_rng(seed)
    y = random.standard_normal(rows)
    y[random.random(rows) < missing] = np.nan
    x = np.arange(rows, dtype=np.float64)

    at, drawn = envelope(x, y, columns)

    np.testing.assert_array_equal(drawn, y[at.astype(int)])
    assert np.all(np.diff(at) > 0)
    assert (at[0], at[-1]) == (0, rows - 1)
    if rows <= 4 * columns:
        assert len(at) == rows
        return
    length = -(-rows // columns)  # no stretch is longer than the others
    for begin in range(0, rows, length):
        inside = y[begin : begin + length]
        end = begin + len(inside)
        kept = drawn[(at >= begin) & (at < end)]
        if np.isfinite(inside).any():
            assert np.nanmin(kept) == np.nanmin(inside)
            assert np.nanmax(kept) == np.nanmax(inside)
        assert np.isnan(kept).any() == np.isnan(inside).any()


def test_a_single_sample_in_six_million_is_drawn() -> None:
    y = np.zeros(6_000_000)
    y[4_321_234] = 1.0
    x, drawn = envelope(np.arange(len(y), dtype=np.float64), y)
    assert drawn.max() == 1.0
    assert x[drawn.argmax()] == 4_321_234
    assert len(drawn) <= 3 * COLUMNS + 4


@given(
    st.integers(1, 3000),
    st.integers(1, 400),
    st.lists(st.integers(1, 2999), max_size=3),
    st.integers(0, 2**32 - 1),
)
def test_a_band_has_the_extremes_of_every_stretch_and_none_across_a_gap(
    rows: int, stretches: int, places: list[int], seed: int
) -> None:
    values = np.random.default_rng(seed).standard_normal((rows, 1))
    gaps = tuple(Gap(row, 7) for row in sorted(set(places)) if row < rows)
    block = Block((Channel("torque", "Nm"),), 0, 1, 1e-3, values, gaps)

    time_s, least, greatest = band(block, "torque", stretches)

    known = ~np.isnan(time_s)
    assert np.count_nonzero(~known) == len(gaps)
    assert np.count_nonzero(known) <= stretches + len(gaps) + 1
    assert (np.nanmin(least), np.nanmax(greatest)) == (values.min(), values.max())
    assert np.all(np.diff(time_s[known]) > 0)
    assert 0.0 <= time_s[known][0] <= time_s[known][-1] <= (rows - 1 + 7 * len(gaps)) * 1e-3
    parts = np.split(values[:, 0], [gap.row for gap in gaps])
    broken = np.split(least, np.flatnonzero(~known))
    for part, drawn in zip(parts, broken, strict=True):
        assert np.nanmin(drawn) == part.min()


@pytest.mark.parametrize("rows", [100, 100_000])
def test_a_line_breaks_at_a_gap_and_time_goes_on_behind_it(rows: int) -> None:
    data = np.arange(rows, dtype=np.float64)[:, np.newaxis]
    block = Block((Channel("torque", "Nm"),), 0, 1, 1e-3, data, (Gap(rows // 2, 50),))

    time_s, drawn = trace(block, "torque")

    (gap,) = np.flatnonzero(np.isnan(drawn))
    assert drawn[gap - 1] == rows // 2 - 1
    assert drawn[gap + 1] == rows // 2
    assert time_s[gap + 1] - time_s[gap - 1] == pytest.approx(0.051)
    assert time_s[-1] == pytest.approx((rows + 49) * 1e-3)


def test_only_the_first_rows_if_so_asked() -> None:
    block = Block((Channel("a", ""),), 0, 1, 1.0, np.zeros((10, 1)), (Gap(8, 1),))
    time_s, drawn = trace(block, "a", 5)
    assert len(time_s) == len(drawn) == 5
