"""Virtual time advances only in `wait`, in order, and nothing unhandled is left behind."""

from __future__ import annotations

import pytest

from benchtool.clock import RealClock, VirtualClock


def test_waiting_is_advancing() -> None:
    clock = VirtualClock()
    moments: list[float] = []
    clock.follow(moments.append)
    clock.wait(1.5)
    clock.wait(0.25)
    assert clock.now_s() == 1.75
    assert moments == [1.5, 1.75]


def test_timers_fire_in_order_and_followers_stand_at_each_of_them() -> None:
    clock = VirtualClock()
    seen: list[tuple[str, float]] = []
    clock.follow(lambda now_s: seen.append(("follow", now_s)))
    clock.call_every(0.4, lambda: seen.append(("slow", clock.now_s())))
    clock.call_every(0.25, lambda: seen.append(("fast", clock.now_s())))
    clock.wait(0.5)
    assert seen == [
        ("slow", 0.0),
        ("fast", 0.0),
        ("follow", 0.25),
        ("fast", 0.25),
        ("follow", 0.4),
        ("slow", 0.4),
        ("follow", 0.5),
        ("fast", 0.5),
    ]


def test_a_cancelled_timer_stays_silent() -> None:
    clock = VirtualClock()
    calls: list[float] = []
    timer = clock.call_every(0.1, lambda: calls.append(clock.now_s()))
    clock.wait(0.1)
    timer.cancel()
    clock.wait(1.0)
    assert calls == [0.0, 0.1]


def test_what_was_sent_is_handled_before_time_moves() -> None:
    clock = VirtualClock()
    queues = {"drive": 2, "host": 0}
    order: list[str] = []

    def settle_drive() -> bool:
        busy = queues["drive"] > 0
        if busy:
            queues["drive"] -= 1
            queues["host"] += 1
            order.append("drive")
        return busy

    def settle_host() -> bool:
        busy = queues["host"] > 0
        if busy:
            queues["host"] -= 1
            order.append("host")
        return busy

    clock.settle_with(settle_drive)
    clock.settle_with(settle_host)
    clock.follow(lambda _: order.append("time"))
    clock.wait(1.0)
    assert order == ["drive", "host", "drive", "host", "time"]


def test_a_real_timer_hands_its_failure_to_whoever_cancels_it() -> None:
    def fail() -> None:
        raise RuntimeError("adapter gone")

    timer = RealClock().call_every(3600.0, fail)
    with pytest.raises(RuntimeError, match="adapter gone"):
        timer.cancel()
