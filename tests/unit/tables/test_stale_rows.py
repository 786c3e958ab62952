"""Rows that repeat the one before because nothing new was read, and what is measured without them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.stale_rows import often_stale, repeating_rows, stale_rows, too_stale
from tests.at_length import at_length

Array = NDArray[np.float64]
ROWS = 4_000
TURN = 2 * np.pi


def held(values: Array, stale: NDArray[np.bool_]) -> Array:
    return values[np.maximum.accumulate(np.where(stale, 0, np.arange(len(values))))]


def some(share: float, seed: int = 1) -> NDArray[np.bool_]:
    stale = np.random.default_rng(seed).random(ROWS) < share
    stale[0] = False
    return stale


def signals(noise: float = 1e-3) -> Array:
    random, row = np.random.default_rng(2), np.arange(ROWS)
    exact = np.stack([5.0 * np.cos(TURN * 0.03 * row), 2.0 + 0.1 * np.cos(TURN * 0.18 * row)], axis=1)
    return np.asarray(exact + noise * random.standard_normal(exact.shape))


@pytest.mark.parametrize("share", [1e-3, 0.05, 0.2])
@pytest.mark.parametrize("step", [0.0, 1e-3])
def test_repeated_rows_of_signals_that_move_are_stale(share: float, step: float) -> None:
    values, stale = signals(), some(share)
    values = np.round(values / step) * step if step else values
    assert np.mean(stale_rows(repeating_rows(held(values, stale))) != stale) < 1e-3


def test_rows_that_are_equal_by_a_coarse_converter_or_at_rest_are_not() -> None:
    row = np.arange(ROWS)
    sine = np.cos(TURN * 0.003 * row)
    for values in (np.round(40.0 * sine), np.round(3e4 * np.where(row < 2_000, sine, 1.0)), np.ones(ROWS)):
        assert not np.any(repeating_rows(np.column_stack([values, 3.0 * np.ones(ROWS)])))


@pytest.mark.parametrize(("digits", "gain"), [(3, 1.0), (3, 0.37), (4, 1.0)])
def test_few_digits_are_coarser_where_numbers_are_large(digits: int, gain: float) -> None:
    """`-4.99e+00` beside `8.31e-03`: crests are equal by chance, whatever the least step of the column is."""
    noise = 2.0 * 10.0 ** (1 - digits)
    row = np.arange(ROWS)
    values = 5.0 * np.cos(TURN * 0.001 * row) + noise * np.random.default_rng(3).standard_normal(ROWS)
    written = np.array([float(f"{each:.{digits - 1}e}") for each in values])
    assert np.count_nonzero(np.diff(written) == 0.0) > 20
    none = np.zeros(ROWS, dtype=np.bool_)
    assert often_stale(gain * written - 0.2, none) == ""
    assert "sampled less often" in often_stale(held(gain * written, some(0.05)), none)


def test_crests_that_are_clipped_repeat_by_no_chance() -> None:
    clipped = np.clip(signals()[:, :1], -4.9, 4.9)
    assert np.count_nonzero(np.diff(clipped[:, 0]) == 0.0) > 200
    assert not np.any(repeating_rows(clipped))


@pytest.mark.parametrize("rate", [0.4, 0.8])
def test_rows_at_an_even_lower_rate_are_not_continued(rate: float) -> None:
    """Those that do not repeat are late by a part of a row."""
    taken = np.floor(np.arange(ROWS) * rate).astype(np.int64)
    stale = stale_rows(repeating_rows(signals()[taken]))
    assert "sampled less often" in too_stale(stale) or "60 %" in too_stale(stale)


@pytest.mark.parametrize("share", [0.05, 0.35])
def test_a_column_that_repeats_alone_is_named(share: float) -> None:
    values = signals()
    none = np.zeros(ROWS, dtype=np.bool_)
    assert "sampled less often" in often_stale(held(values, some(share))[:, 0], none)
    assert often_stale(values[:, 0], none) == ""
    rounded = np.round(values[:, 0] / 0.2) * 0.2
    assert often_stale(rounded, none) == ""


@pytest.mark.parametrize(("columns", "turns"), [(1, 0.0017), (1, 0.0005), (3, 0.0005)])
def test_a_current_that_rests_between_its_moves_repeats_by_chance(columns: int, turns: float) -> None:
    """As one that no voltage drives for a part of each period of its carrier, in steps of a converter."""
    row = np.arange(ROWS)
    shift = TURN / 3.0 * np.arange(columns)[:, np.newaxis]
    carried = 0.5 * np.cos(shift) * (row // 2 % 2)
    exact = 5.0 * np.cos(TURN * turns * row - shift) + carried
    noise = 2e-3 * np.random.default_rng(5).standard_normal(exact.shape)
    values = 0.02 * np.round((exact + noise).T / 0.02)
    none = np.zeros(ROWS, dtype=np.bool_)
    assert np.mean(~np.any(np.diff(values, axis=0), axis=1)) > 0.02
    assert not np.any(repeating_rows(values))
    if turns > 1e-3:
        assert "sampled less often" in often_stale(held(values, some(0.1))[:, 0], none)


def test_what_is_between_many_is_not_told() -> None:
    assert "40 %" in too_stale(np.arange(ROWS) % 5 < 2)
    assert too_stale(some(0.2)) == ""


def test_a_record_that_stands_still_for_long_is_none_of_stale_rows() -> None:
    values = signals()
    values[1_000:3_000] = 0.0
    repeating = repeating_rows(values)
    assert np.count_nonzero(repeating) == 1_999
    assert not np.any(stale_rows(repeating))


def numbers(path: Path, values: Array, angle: bool = False) -> dict[str, Measurement]:
    columns = {"current": "i", "torque": "T"} | ({"angle": "a"} if angle else {})
    lines = (",".join(map(repr, map(float, row))) for row in values)
    path.write_text("t,i,T,a\n" + "\n".join(lines), encoding="utf-8")
    return {each.name: each for each in analyze_table(TableQuestion(path, "t:s", columns)).measurements}


@pytest.mark.parametrize("share", [0.18, *at_length(0.03)])
def test_lines_keep_their_size(tmp_path: Path, share: float) -> None:
    time_s, angle = np.arange(ROWS) * 1e-4, np.mod(TURN * 0.015 * np.arange(ROWS), TURN)
    values = np.column_stack([held(np.column_stack([signals(), angle]), some(share))])
    table = np.column_stack([time_s, values])
    found = numbers(tmp_path / "t.csv", table) | {
        name: each for name, each in numbers(tmp_path / "t.csv", table, True).items() if "order" in name
    }
    for name, truth in (
        ("current_fundamental", 5.0),
        ("torque_line_amplitude", 0.1),
        ("torque_order_12", 0.1),
    ):
        number = found[name]
        assert number.uncertainty is not None
        assert abs(number.value - truth) < 3.0 * number.uncertainty.standard < 0.01 * truth
    assert "left out" in found["current_fundamental"].definition
    assert found["torque_order_12"].basis.gaps


def test_lines_of_too_many_are_undefined_and_the_mean_is_not(tmp_path: Path) -> None:
    values = held(signals(), some(0.5))
    found = numbers(tmp_path / "t.csv", np.column_stack([np.arange(ROWS) * 1e-4, values, values[:, 0]]))
    assert found["torque_mean"].value == pytest.approx(2.0, abs=0.01)
    for name in ("current_fundamental", "torque_line_amplitude"):
        assert "repeat all values" in found[name].reason
