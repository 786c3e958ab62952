"""Whether a drive restarted while its link was gone, by its ticks."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from benchtool.link.clock_anchor import TickAnchor

TICK_S = 1e-4
WRAP = 1 << 32


def mark(tick: int, at_s: float) -> TickAnchor:
    return TickAnchor(tick % WRAP, at_s, TICK_S)


@given(
    tick=st.integers(0, WRAP - 1),
    past_s=st.floats(0.0, 1e5),
    drift=st.floats(-5e-4, 5e-4),
)
def test_a_drive_that_ran_on_is_no_other_one(tick: int, past_s: float, drift: float) -> None:
    later = mark(tick + round(past_s * (1.0 + drift) / TICK_S), 7.0 + past_s)
    assert mark(tick, 7.0).restarted_since(later) is False


@pytest.mark.parametrize(
    ("tick", "later"),
    [
        (100_000, 0),
        (100_000, 105_000),
        (100_000, 250_000),
        (WRAP - 10, 30_000),
        (0, WRAP - 1),
        (0, WRAP // 2 + 50_000),
    ],
)
def test_ticks_that_are_not_where_time_would_have_brought_them(tick: int, later: int) -> None:
    assert mark(tick, 0.0).restarted_since(mark(later, 5.0)) is True
