"""Times that count since 1970 or modulo a power of two, and numbers that mark no reading."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st
from numpy.typing import NDArray

from benchtool.errors import AnalysisError
from benchtool.tables import TableQuestion, analyze_table
from benchtool.tables.clocks import Clock, read_clock
from benchtool.tables.selection import Selection

Array = NDArray[np.float64]
PER_S = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


def time_in(unit: str = "s", unit_from: str = "assumed") -> Selection:
    return Selection(1, "t", unit, unit_from, 1.0 / PER_S[unit], "s")


@given(st.sampled_from(sorted(PER_S)), st.floats(946_684_800.0, 4_102_444_000.0))
def test_a_time_since_1970_has_the_unit_that_puts_it_in_this_century(unit: str, begin_s: float) -> None:
    times = np.asarray((begin_s + np.arange(50) * 0.01) * PER_S[unit], dtype=np.float64)
    found, time_s, clock = read_clock(time_in(), times)
    assert (found.unit, found.unit_from) == (unit, "size")
    np.testing.assert_allclose(time_s, times / PER_S[unit], rtol=1e-15)
    assert clock.day is not None
    assert 2000 <= clock.day.year <= 2099


@pytest.mark.parametrize("unit_from", ["option", "head"])
def test_a_stated_unit_stays(unit_from: str) -> None:
    times = 1.7e12 + np.arange(50.0)
    found, time_s, clock = read_clock(time_in("s", unit_from), times)
    assert (found.unit, found.unit_from, clock) == ("s", unit_from, Clock())
    assert time_s is times


def test_thousands_of_years_are_no_seconds() -> None:
    times = 5e12 + np.arange(50.0)
    with pytest.raises(AnalysisError, match="thousands of years if in seconds: state its unit, as 't:us'"):
        read_clock(time_in(), times)
    assert read_clock(time_in("s", "option"), times)[1] is times


@pytest.mark.parametrize("first", [0.0, 1e5, 9e8, 5e9])
def test_other_sizes_tell_no_unit(first: float) -> None:
    found, _, clock = read_clock(time_in(), first + np.arange(50.0))
    assert (found.unit_from, clock.day) == ("assumed", None)


@given(
    bits=st.sampled_from([8, 16, 24, 32]),
    share=st.floats(0.01, 0.2),
    signed=st.booleans(),
    begin=st.floats(0.0, 0.99),
    rounds=st.floats(1.5, 8.0),
)
def test_a_counter_goes_on_behind_its_last_count(
    bits: int, share: float, signed: bool, begin: float, rounds: float
) -> None:
    modulus = 2**bits
    step = max(2, round(share * modulus))
    rows = int(rounds * modulus / step) + 2
    count = int(begin * modulus) + step * np.arange(rows)
    raw = (count % modulus).astype(float) - (modulus // 2 if signed else 0)
    selection = Selection(1, "t", "us", "option", 1e-6, "s", gain=0.5, offset=3.0)
    found, time_s, clock = read_clock(selection, (0.5 * raw + 3.0) * 1e-6)
    assert found == selection
    assert clock.modulus == modulus
    assert clock.rollovers == np.count_nonzero(np.diff(raw) < 0)
    np.testing.assert_allclose(np.diff(time_s), 0.5e-6 * step, rtol=1e-6)


@pytest.mark.parametrize("missing", [1, 2, 3])
def test_a_counter_goes_round_over_rows_that_are_missing_there(missing: int) -> None:
    """It was refused: the longer step at its rollover was none of its own."""
    counts = 60_000.0 + 100.0 * np.arange(200)
    behind = int(np.argmax(counts >= 65_536.0))
    kept = np.delete(counts, np.arange(behind, behind + missing))
    _, time_s, clock = read_clock(time_in("us", "head"), (kept % 65_536.0) * 1e-6)
    assert (clock.modulus, clock.rollovers) == (65_536, 1)
    np.testing.assert_allclose(time_s, kept * 1e-6, rtol=1e-9)


@pytest.mark.parametrize(
    "counts",
    [
        np.tile(np.arange(0.0, 1000.0), 3),  # records of the same length joined together
        np.tile(np.arange(0.0, 65_000.0, 100.0), 3),
        np.tile(np.arange(0.0, 256.0, 90.0), 20),  # steps too long to tell the rounds
        np.tile(np.linspace(0.0, 255.0, 300), 3),  # not whole
        np.arange(100.0),
        np.full(10, 7.0),
        np.arange(100.0)[::-1],
    ],
)
def test_what_is_no_counter_stays_as_it_is(counts: Array) -> None:
    _, time_s, clock = read_clock(time_in("s", "head"), counts)
    assert clock == Clock()
    np.testing.assert_array_equal(time_s, counts)


def table(folder: Path, head: str, *columns: NDArray[np.floating[Any] | np.integer[Any]]) -> Path:
    path = folder / "table.csv"
    np.savetxt(path, np.column_stack(columns), fmt="%.10g", delimiter=",", header=head, comments="")
    return path


def current(rows: int) -> Array:
    row = np.arange(rows, dtype=np.float64)
    samples: Array = np.round(5.0 * np.sin(2e-3 * np.pi * row) + 0.01 * np.sin(1.7 * row), 4)
    return samples


def test_a_table_of_a_counter_is_measured_and_says_so(tmp_path: Path) -> None:
    path = table(tmp_path, "ticks [us],ia [A]", 100 * np.arange(8000) % 65_536, current(8000))
    answer = analyze_table(TableQuestion(path, "ticks [us]", {"current": "ia"}))
    frequency = next(each for each in answer.measurements if each.name == "fundamental_frequency")
    assert frequency.value == pytest.approx(10.0, rel=1e-4)
    assert [str(each.kind) for each in answer.remarks] == ["time_rolls_over"]
    assert "16 bits" in answer.remarks[0].text


def test_a_span_counts_what_is_left_out_on_the_same_axis(tmp_path: Path) -> None:
    samples = current(4000)
    samples[[500, 3000]] = np.nan
    path = table(tmp_path, "time,ia [A]", 1.7e12 + np.arange(4000), samples)
    question = TableQuestion(path, "time", {"current": "ia"}, from_s=1.7e9 + 2.0)
    answer = analyze_table(question)
    assert answer.record.lost.within == 1
    assert answer.remarks[0].text.endswith("state it, as --time 'time:ms'")


@pytest.mark.parametrize("mark", [-9999.0, 999.0, 99_999.0])
def test_a_number_of_nines_far_from_all_others_marks_no_reading(tmp_path: Path, mark: float) -> None:
    samples = current(4000)
    samples[[0, 100, 3999]] = mark
    path = table(tmp_path, "t [s],ia [A]", 1e-4 * np.arange(4000), samples)
    answer = analyze_table(TableQuestion(path, "t", {"current": "ia"}))
    found = {each.name: each.value for each in answer.measurements}
    assert found["current_fundamental"] == pytest.approx(5.0, rel=1e-3)
    assert f"a cell is {mark:.0f}, which marks no reading" in answer.remarks[0].text


@pytest.mark.parametrize("value", [99.0, 500.0, 9998.0])
def test_other_spikes_are_values(tmp_path: Path, value: float) -> None:
    samples = current(4000)
    samples[100] = value
    path = table(tmp_path, "t [s],ia [A]", 1e-4 * np.arange(4000), samples)
    answer = analyze_table(TableQuestion(path, "t", {"current": "ia"}))
    assert not answer.record.lost.left_out


def test_a_count_that_reaches_999_marks_nothing(tmp_path: Path) -> None:
    samples = np.arange(1000.0)
    path = table(tmp_path, "t [s],ia [A]", 1e-4 * np.arange(1000), samples)
    answer = analyze_table(TableQuestion(path, "t", {"current": "ia"}))
    assert not answer.record.lost.left_out
