"""Virtual time advances only in `wait`, in order, and nothing unhandled is left behind."""

from __future__ import annotations

import itertools

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

    clock.register(settle_drive)
    clock.register(settle_host)
    clock.follow(lambda _: order.append("time"))
    clock.wait(1.0)
    assert order == ["drive", "host", "drive", "host", "time"]


def test_a_real_timer_raises_its_failure_in_cancel() -> None:
    def fail() -> None:
        raise RuntimeError("adapter gone")

    timer = RealClock().call_every(3600.0, fail)
    with pytest.raises(RuntimeError, match="adapter gone"):
        timer.cancel()


class Wall:
    """A wall clock in a test's hand."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 100.0
        self.slept: list[float] = []
        monkeypatch.setattr("benchtool.clock.time.monotonic", lambda: self.now_s)
        monkeypatch.setattr("benchtool.clock.time.sleep", self._sleep)

    def _sleep(self, duration_s: float) -> None:
        self.slept.append(duration_s)
        self.now_s += duration_s


@pytest.mark.parametrize(("speed", "step_s"), [(1.0, 0.02), (2.0, 0.001), (0.5, 0.3)])
def test_a_paced_clock_keeps_step_with_the_wall(
    monkeypatch: pytest.MonkeyPatch, speed: float, step_s: float
) -> None:
    wall = Wall(monkeypatch)
    clock = VirtualClock(paced=True, speed=speed, step_s=step_s)
    moments: list[tuple[float, float]] = []
    clock.follow(lambda now_s: moments.append((now_s, wall.now_s)))
    for _ in range(4):
        clock.wait(0.15)
    assert all(virtual_s == pytest.approx(speed * (wall_s - 100.0)) for virtual_s, wall_s in moments)
    steps = [after[0] - before[0] for before, after in itertools.pairwise(moments)]
    assert max(steps) <= step_s + 1e-9
    assert clock.late_s == 0.0


def test_a_short_delay_is_caught_up_and_a_long_one_given_up_and_told(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = Wall(monkeypatch)
    clock = VirtualClock(paced=True, step_s=0.1)
    clock.wait(1.0)
    wall.now_s += 0.95
    clock.wait(1.0)
    assert wall.now_s == pytest.approx(102.0)
    assert clock.late_s == 0.0
    wall.now_s += 5.0
    clock.wait(1.0)
    assert clock.late_s == pytest.approx(4.9)
    assert wall.now_s == pytest.approx(107.9), "a step was due at once, the others at their pace"


def test_how_much_is_caught_up_can_be_chosen(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = Wall(monkeypatch)
    clock = VirtualClock(paced=True, step_s=0.01, catch_up_s=0.1)
    clock.wait(1.0)
    wall.now_s += 0.05
    clock.wait(1.0)
    assert clock.late_s == 0.0
    wall.now_s += 0.5
    clock.wait(1.0)
    assert clock.late_s == pytest.approx(0.49)
    assert wall.now_s == pytest.approx(103.49)


def test_a_drive_that_is_too_slow_for_the_pace_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = Wall(monkeypatch)
    clock = VirtualClock(paced=True, speed=10.0, step_s=0.1)

    def slow(_: float) -> None:
        wall.now_s += 0.02  # for 0.01 s of its due

    clock.follow(slow)
    clock.wait(100.0)
    assert clock.late_s == pytest.approx(10.0, abs=1.1)
    assert sum(wall.slept) < 0.02


@pytest.mark.parametrize("arguments", [{"speed": 0.0}, {"speed": -1.0}, {"step_s": 0.0}])
def test_a_pace_is_positive(arguments: dict[str, float]) -> None:
    with pytest.raises(ValueError, match="must be positive"):
        VirtualClock(paced=True, **arguments)


def test_a_real_clock_cannot_settle() -> None:
    """What waits for an answer goes by this: only a clock that has settled it says that none will come."""
    asked: list[str] = []

    def settle() -> bool:
        asked.append("settled")
        return False

    for clock, known in ((RealClock(), False), (VirtualClock(), True)):
        asked.clear()
        clock.register(settle)
        assert clock.settle() is known is clock.virtual
        assert asked == ["settled"] * known
        clock.unregister(settle)
        clock.settle()
        assert asked == ["settled"] * known
