"""Wrapping and unwrapping of the drive's ticks."""

from __future__ import annotations

from hypothesis import given, strategies as st

from benchtool.ticks import TICKS, is_newer, ticks_between, ticks_since, unwrap_tick, wrap_tick

counts = st.integers(0, 5 * TICKS)
near_enough = st.integers(-TICKS // 2 + 1, TICKS // 2 - 1)


@given(counts, near_enough)
def test_a_count_survives_the_wire(count: int, off: int) -> None:
    if count + off >= 0:
        assert unwrap_tick(wrap_tick(count), near=count + off) == count


@given(counts)
def test_without_a_reference_a_tick_is_what_the_wire_says(count: int) -> None:
    assert unwrap_tick(wrap_tick(count), None) == wrap_tick(count)


@given(counts, counts)
def test_distances_do_not_depend_on_the_wrap(one: int, other: int) -> None:
    assert ticks_since(one, other) == ticks_since(wrap_tick(one), wrap_tick(other))
    assert ticks_between(one, other) == ticks_between(other, one) <= TICKS // 2
    assert wrap_tick(other + ticks_since(one, other)) == wrap_tick(one)


@given(counts, near_enough)
def test_of_two_counts_one_follows_the_other(count: int, off: int) -> None:
    assert is_newer(wrap_tick(count + off), wrap_tick(count)) is (off > 0)
    assert is_newer(wrap_tick(count), wrap_tick(count + off)) is (off < 0)


def test_around_the_wrap() -> None:
    assert ticks_since(4, TICKS - 6) == 10
    assert unwrap_tick(4, near=TICKS - 6) == TICKS + 4
    assert unwrap_tick(TICKS - 6, near=TICKS + 4) == TICKS - 6
    assert unwrap_tick(TICKS - 6, near=4) == TICKS - 6, "a count is not negative"
