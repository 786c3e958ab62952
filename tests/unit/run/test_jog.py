"""Timing of setpoints by the host, and its report."""

from __future__ import annotations

import pytest
from hypothesis import given, strategies as st

from benchtool.clock import VirtualClock
from benchtool.run.jog import pace


def test_an_even_clock_gives_even_periods() -> None:
    times: list[float] = []
    pacing = pace(VirtualClock(), times.append, duration_s=0.1, period_s=0.01)
    assert times == pytest.approx([0.01 * n for n in range(10)])
    assert (pacing.sent, pacing.late) == (10, 0)
    assert pacing.period_mean_s == pytest.approx(0.01)
    assert pacing.period_rms_s == pytest.approx(0.0, abs=1e-12)


def test_what_is_missed_is_left_out_and_counted() -> None:
    clock = VirtualClock()
    times: list[float] = []

    def slow_once(time_s: float) -> None:
        times.append(time_s)
        if len(times) == 3:
            clock.wait(0.033)

    pacing = pace(clock, slow_once, duration_s=0.1, period_s=0.01)
    assert times == pytest.approx([0.0, 0.01, 0.02, 0.053, 0.06, 0.07, 0.08, 0.09])
    assert (pacing.sent, pacing.late) == (8, 1)
    assert pacing.period_max_s == pytest.approx(0.033)
    # seven periods: one of 33 ms, one of 7 ms, five of 10 ms
    assert pacing.period_rms_s == pytest.approx(((0.023**2 + 0.003**2) / 7) ** 0.5)


@given(st.floats(0.001, 0.1), st.integers(1, 50), st.lists(st.floats(0.0, 0.3), max_size=50))
def test_no_burst_makes_up_for_a_delay_and_the_end_is_kept(
    period_s: float, slots: int, delays_s: list[float]
) -> None:
    clock = VirtualClock()
    delays = iter(delays_s)
    times: list[float] = []

    def action(time_s: float) -> None:
        times.append(time_s)
        clock.wait(next(delays, 0.0))

    pacing = pace(clock, action, duration_s=slots * period_s, period_s=period_s)
    assert pacing.sent == len(times) <= slots
    # of any slot of the grid there is one frame at most
    taken = [int(time_s / period_s + 1e-6) for time_s in times]
    assert taken == sorted(set(taken))
    assert clock.now_s() >= slots * period_s - 1e-9
