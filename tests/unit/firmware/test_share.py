"""A wire's share of a processor: requests within it never wait, a flood is limited to it."""

from __future__ import annotations

import pytest
from hypothesis import given, settings, strategies as st

from benchtool.emulator.ports.share import Share


class _Thread:
    """A thread that handles what it reads, and waits when it is told to."""

    def __init__(self, share: float) -> None:
        self.now_s = self.spent_s = self.waited_s = 0.0
        self._share = Share(share, lambda: self.now_s, lambda: self.spent_s)

    def read(self, handling_s: float) -> None:
        if (pause_s := self._share.pause_s()) > 0.0:
            self.now_s += pause_s
            self.waited_s += pause_s
        self._share.handed_over()
        self.now_s += handling_s
        self.spent_s += handling_s


@settings(max_examples=20, deadline=None)
@given(handling_s=st.floats(1e-3, 1e-2), share=st.floats(0.05, 0.9))
def test_a_flood_takes_its_share_and_no_more(handling_s: float, share: float) -> None:
    thread = _Thread(share)
    for _ in range(2000):
        thread.read(handling_s)
    assert thread.spent_s / thread.now_s == pytest.approx(share, rel=0.1, abs=0.01)


def test_requests_within_the_share_never_wait() -> None:
    thread = _Thread(0.25)
    for _ in range(10_000):
        thread.read(0.2e-3)
        thread.now_s += 0.8e-3  # 20 % of the time
    assert thread.waited_s == 0.0


def test_a_burst_is_served_at_once_after_a_quiet_time() -> None:
    thread = _Thread(0.25)
    thread.now_s += 100.0
    for _ in range(40):
        thread.read(1e-3)
    assert thread.waited_s == 0.0
