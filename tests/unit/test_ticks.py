"""The one place that knows the wrap of the drive's ticks."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from benchtool.ticks import TICKS, ahead, apart, counted_on, follows, on_wire

counts = st.integers(0, 5 * TICKS)
near_enough = st.integers(-TICKS // 2 + 1, TICKS // 2 - 1)


@given(counts, near_enough)
def test_a_count_survives_the_wire(count: int, off: int) -> None:
    if count + off >= 0:
        assert counted_on(on_wire(count), near=count + off) == count


@given(counts)
def test_without_a_reference_a_tick_is_what_the_wire_says(count: int) -> None:
    assert counted_on(on_wire(count), None) == on_wire(count)


@given(counts, counts)
def test_distances_do_not_depend_on_the_wrap(one: int, other: int) -> None:
    assert ahead(one, other) == ahead(on_wire(one), on_wire(other))
    assert apart(one, other) == apart(other, one) <= TICKS // 2
    assert on_wire(other + ahead(one, other)) == on_wire(one)


@given(counts, near_enough)
def test_of_two_counts_one_follows_the_other(count: int, off: int) -> None:
    assert follows(on_wire(count + off), on_wire(count)) is (off > 0)
    assert follows(on_wire(count), on_wire(count + off)) is (off < 0)


def test_around_the_wrap() -> None:
    assert ahead(4, TICKS - 6) == 10
    assert counted_on(4, near=TICKS - 6) == TICKS + 4
    assert counted_on(TICKS - 6, near=TICKS + 4) == TICKS - 6
    assert counted_on(TICKS - 6, near=4) == TICKS - 6, "a count is not negative"
