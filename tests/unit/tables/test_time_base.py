"""Time stamps of imported data: one rate, gaps, or the reason why there is none."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from benchtool.analysis.validity import held_rows
from benchtool.block import Gap
from benchtool.tables.time_base import time_base

Array = NDArray[np.float64]
ROWS = np.arange(5_000, dtype=np.float64)


@pytest.mark.parametrize("rate_Hz", [1.0, 1000.0, 3000.0, 44_100.0, 1.25e6])
@pytest.mark.parametrize("begin_s", [0.0, -0.025, 86_400.0])
def test_even_stamps_give_their_rate(rate_Hz: float, begin_s: float) -> None:
    base = time_base(begin_s + ROWS / rate_Hz)

    assert base.refusal == ""
    assert base.rate_Hz == pytest.approx(rate_Hz, rel=1e-9)
    assert base.begin_s == pytest.approx(begin_s, abs=1e-9)
    assert base.gaps == ()
    assert base.jitter_s < 1e-5 / rate_Hz + 1e-10


@pytest.mark.parametrize(
    ("rate_Hz", "decimals"), [(10_000, 3), (3_000, 4), (7_000, 4), (1_333, 3), (48_000, 3)]
)
def test_stamps_coarser_than_the_rows_give_the_rate_within_their_resolution(
    rate_Hz: float, decimals: int
) -> None:
    stamps = np.round(ROWS / rate_Hz, decimals)

    base = time_base(stamps)

    assert base.refusal == ""
    assert base.gaps == ()
    assert base.resolution_s == pytest.approx(10.0**-decimals)
    assert base.rate_Hz == pytest.approx(rate_Hz, rel=1e-3)
    # rounding is uniform over a step of the resolution: 1 / sqrt(12) of it, rms
    assert base.jitter_s == pytest.approx(10.0**-decimals / math.sqrt(12), rel=0.1)


def test_missing_rows_are_gaps() -> None:
    kept = np.delete(np.arange(5_000), [1_000, 1_001, 1_002, 3_000])

    base = time_base(kept / 3_000.0)

    assert base.refusal == ""
    assert base.gaps == (Gap(1_000, 3), Gap(2_997, 1))
    assert base.missing_rows == 4
    assert base.rate_Hz == pytest.approx(3_000.0)


def test_a_gap_in_stamps_of_four_decimals_is_found_too() -> None:
    stamps = np.delete(np.round(ROWS / 3_000.0, 4), [1_000, 1_001])
    assert time_base(stamps).gaps == (Gap(1_000, 2),)


def milliseconds(rows: Array, rate_Hz: float = 10_000.0) -> Array:
    return np.floor(rows / rate_Hz * 1_000 + 1e-6) / 1_000


@pytest.mark.parametrize("lost", [77, 503, 2_509, 4_000])
def test_one_row_less_under_one_of_the_coarse_stamps_is_a_gap(lost: int) -> None:
    base = time_base(milliseconds(np.delete(ROWS, lost)))

    (gap,) = base.gaps
    assert gap.missing_rows == 1
    assert abs(gap.row - lost) < 10  # within its stamp
    assert base.rate_Hz == pytest.approx(10_000.0, rel=1e-5)
    assert base.gaps_known


@pytest.mark.parametrize("first", [2_000, 2_003])
def test_many_rows_missing_under_coarse_stamps_are_gaps(first: int) -> None:
    base = time_base(milliseconds(np.delete(ROWS, np.s_[first : first + 50])))
    assert base.missing_rows == 50
    assert base.rate_Hz == pytest.approx(10_000.0, rel=2e-5)


def test_a_rate_just_below_a_whole_number_of_rows_for_each_stamp_has_no_gaps() -> None:
    base = time_base(milliseconds(np.arange(50_000.0), 9_950.0))
    assert base.gaps == ()
    assert base.gaps_known
    assert base.rate_Hz == pytest.approx(9_950.0, rel=1e-5)


def test_where_a_lost_row_and_another_rate_look_alike_gaps_are_not_known() -> None:
    two = time_base(milliseconds(np.delete(ROWS, [1_255, 3_755])))
    odd = time_base(np.round(np.delete(ROWS, 2_000) / 48_000.0, 3))
    for base in (two, odd):
        assert base.refusal == ""
        assert base.gaps == ()
        assert not base.gaps_known
    assert time_base(np.round(ROWS / 48_000.0, 3)).gaps_known


def test_stamps_of_five_digits_are_as_coarse_as_the_last() -> None:
    base = time_base(np.array([float(f"{row / 2_000:.5g}") for row in range(60_000)]))
    assert base.refusal == ""
    assert base.resolution_s == pytest.approx(1e-3)
    assert base.rate_Hz == pytest.approx(2_000.0, rel=1e-6)


@given(
    per_stamp=st.floats(1.2, 40.0),
    begin=st.floats(0.0, 1.0),
    lost=st.lists(st.integers(100, 3_900), max_size=3, unique=True),
)
@settings(max_examples=60, deadline=None)
def test_the_rate_of_coarse_stamps_is_known_to_within_its_uncertainty(
    per_stamp: float, begin: float, lost: list[int]
) -> None:
    rows = np.delete(np.arange(4_000.0), lost)
    base = time_base(np.floor(begin + rows / per_stamp) / 1_000)
    if not base.refusal and not lost:
        assert abs(base.rate_Hz / (1_000 * per_stamp) - 1.0) < 3 * base.rate_relative
        assert base.gaps == () or base.missing_rows == 1
    if not base.refusal and len(lost) == 3 and base.gaps_known:
        assert abs(base.missing_rows - 3) <= 1 or base.rate_relative > 3 / 4_000


@pytest.mark.parametrize("decimals", [3, 5, 6, 9])
@pytest.mark.parametrize("off", [-3e-4, -2e-5, 0.0, 4e-6, 1.3e-4])
def test_rounded_stamps_allow_the_true_rate_and_few_others(decimals: int, off: float) -> None:
    rate_Hz = 10_000.0 * (1.0 + off)
    stamps = np.round(12.0 + ROWS / rate_Hz, decimals)
    base = time_base(stamps)
    assert base.refusal == ""
    largest = math.sqrt(3.0) * base.rate_relative  # of an even distribution
    if np.ptp(np.diff(stamps)) < 1e-13:  # they number the rows
        assert largest < 1e-12
        np.testing.assert_allclose(12.0 + ROWS / base.rate_Hz, stamps, atol=1e-12)
        return
    assert abs(base.rate_Hz / rate_Hz - 1.0) <= largest + 1e-12
    resolution_s = max(10.0**-decimals, base.resolution_s if math.isfinite(base.resolution_s) else 0.0)
    assert largest <= 2.0 * resolution_s / (len(ROWS) / rate_Hz)


@pytest.mark.parametrize("rows", [20, 500, 5_000])
@pytest.mark.parametrize("step_s", [1e-4, 4e-9, 0.02, 1.0 / 3.0])
def test_stamps_of_one_step_number_the_rows_and_hide_no_other_rate(rows: int, step_s: float) -> None:
    base = time_base(step_s * np.arange(rows, dtype=np.float64) - 0.1)
    assert base.rate_Hz == pytest.approx(1.0 / step_s, rel=1e-5)
    assert base.rate_relative < 1e-6 / rows


def test_the_rate_of_stamps_that_jitter_is_known_by_all_of_them() -> None:
    random, relative = np.random.default_rng(2), []
    for _ in range(40):
        base = time_base((ROWS + 0.01 * random.standard_normal(len(ROWS))) / 10_000.0)
        relative.append((base.rate_Hz / 10_000.0 - 1.0) / base.rate_relative)
    assert 0.7 < math.sqrt(float(np.mean(np.square(relative)))) < 1.4


def test_little_jitter_is_stated_and_more_is_refused() -> None:
    jitter = np.random.default_rng(1).uniform(-1.0, 1.0, len(ROWS))

    little = time_base((ROWS + 0.03 * jitter) / 1_000.0)
    more = time_base((ROWS + 0.3 * jitter) / 1_000.0)

    assert little.refusal == ""
    assert little.jitter_s == pytest.approx(0.03e-3 / math.sqrt(3), rel=0.05)
    assert "the time stamps are not even" in more.refusal
    assert math.isnan(more.jitter_s)


@pytest.mark.parametrize(
    ("stamps", "refusal"),
    [
        (ROWS[:3], "3 rows, at least 8 are needed"),
        (np.empty(0), "0 rows"),
        (np.full(100, 2.5), "the time is 2.5 s in every row"),
        (np.insert(ROWS, 70, ROWS[69]) * 1e-3, "1 row repeats the time of the row before, first row 71"),
        (np.tile(ROWS, 2) * 1e-3, "goes back once, first by 4.999 s at row 5001: records joined together"),
        (ROWS[::-1] * 1e-3, "goes back at every row: the newest row is first, or the time counts down"),
        (np.concatenate([ROWS[:2500], 2500 + 1.37 * ROWS[:2500]]), "not even"),
    ],
)
def test_what_is_no_time_base_says_why(stamps: Array, refusal: str) -> None:
    base = time_base(stamps)
    assert refusal in base.refusal
    assert base.gaps == ()


@given(
    rate_Hz=st.floats(0.5, 1e6),
    begin_s=st.floats(-1e3, 1e3),
    lost=st.sets(st.integers(1, 398), max_size=40),
)
@settings(max_examples=60, deadline=None)
def test_no_row_is_invented_or_lost(rate_Hz: float, begin_s: float, lost: set[int]) -> None:
    """Every row stands where its stamp says, with the gaps counted."""
    rows = np.array([row for row in range(400) if row not in lost], dtype=np.float64)
    stamps = begin_s + rows / rate_Hz

    base = time_base(stamps)

    assert base.refusal == ""
    assert base.missing_rows == len(lost)
    place = np.arange(len(rows), dtype=np.float64)
    for gap in base.gaps:
        place[gap.row :] += gap.missing_rows
    np.testing.assert_allclose(base.begin_s + base.step_s * place, stamps, atol=0.02 / rate_Hz + 1e-9)


@given(st.lists(st.floats(-1e12, 1e12), max_size=40))
@settings(deadline=None)
def test_any_finite_stamps_give_an_answer(stamps: list[float]) -> None:
    base = time_base(np.array(stamps, dtype=np.float64))
    assert base.refusal or base.step_s > 0.0


@pytest.mark.parametrize(("rate_Hz", "held"), [(10_000.0, 1.0), (2_500.0, 4.0), (3_137.0, 10.0 / 3.137)])
def test_rows_of_a_slower_converter_are_held_as_long_as_its_period(rate_Hz: float, held: float) -> None:
    sample = np.floor(np.arange(5_000) / 10_000.0 * rate_Hz + 0.01)

    assert held_rows(np.sin(0.37 * sample)) == pytest.approx(held, rel=2e-3)


def test_a_signal_that_moves_by_less_than_a_step_from_row_to_row_is_not_held() -> None:
    """The 8 bits of a converter are passed at most every other row."""
    row, noise = np.arange(16_000), np.random.default_rng(7).standard_normal(16_000)
    signal = 64.0 * np.cos(0.0098 * row) + 1.9 * np.cos(0.049 * row + 3.0) + 0.13 * noise
    assert held_rows(np.round(signal)) == 1.0
    assert held_rows(np.round(20.0 * signal[row // 3 * 3])) == pytest.approx(3.0, rel=0.02)


def test_the_reason_states_how_far_jittering_stamps_are_off_and_not_where_steps_were_taken_for_gaps() -> None:
    shift = np.random.default_rng(3).uniform(-0.3, 0.3, 4000)

    refused = time_base(1e-3 * (np.arange(4000) + shift)).refusal

    off = re.search(r"off an even grid by up to (\S+) s", refused)
    assert off is not None
    assert float(off[1]) == pytest.approx(0.3e-3, rel=0.03)
