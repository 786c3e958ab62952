"""Sinks: a recorder loses nothing or raises, a viewer drops and counts, and no thread fails silently."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from benchtool.block import Block, Channel
from benchtool.errors import RecordingError
from benchtool.telemetry.fanout import FanOut, Sink
from benchtool.telemetry.worker import Worker


def block(tick: int) -> Block:
    return Block((Channel("torque", "Nm"),), tick, 1, 1e-4, np.zeros((3, 1)))


class Held:
    """A sink's work that stands still until it is let go."""

    def __init__(self) -> None:
        self.taken: list[int] = []
        self.began = threading.Event()
        self.go = threading.Event()

    def __call__(self, each: Block) -> None:
        self.began.set()
        self.go.wait()
        self.taken.append(each.first_tick)


def test_every_sink_gets_every_block_in_order() -> None:
    seen: list[list[int]] = [[], []]
    sinks = [
        Sink("a", lambda each: seen[0].append(each.first_tick), lossless=True),
        Sink("b", lambda each: seen[1].append(each.first_tick), lossless=False),
    ]
    fan_out = FanOut(sinks)
    for tick in range(50):
        fan_out.put(block(tick))
    fan_out.close()
    assert seen == [list(range(50))] * 2
    fan_out.check()


def test_a_stuck_viewer_delays_no_other_sink_and_its_rows_are_counted() -> None:
    held = Held()
    seen: list[int] = []
    viewer = Sink("viewer", held, lossless=False, size=2)
    recorder = Sink("recorder", lambda each: seen.append(each.first_tick), lossless=True)
    fan_out = FanOut([viewer, recorder])
    fan_out.put(block(0))
    held.began.wait()
    for tick in range(1, 10):
        fan_out.put(block(tick))
    held.go.set()
    fan_out.close()
    assert held.taken == [0, 1, 2]
    assert viewer.rows_dropped == 7 * 3
    assert seen == list(range(10))


def test_a_recorder_that_does_not_keep_up_is_an_error() -> None:
    held = Held()
    recorder = Sink("recorder", held, lossless=True, size=1, room_s=0.01)
    recorder.put(block(0))
    held.began.wait()
    recorder.put(block(1))
    with pytest.raises(RecordingError, match="'recorder' is 1 blocks behind"):
        recorder.put(block(2))
    held.go.set()
    recorder.worker.close()
    assert held.taken == [0, 1]


def test_an_exception_of_a_recorder_is_raised_once_at_the_caller() -> None:
    def fail(each: Block) -> None:
        raise RecordingError("disk full")

    fan_out = FanOut([Sink("recorder", fail, lossless=True, size=1)])
    for tick in range(20):
        fan_out.put(block(tick))
    fan_out.close()
    with pytest.raises(RecordingError, match="disk full"):
        fan_out.check()
    fan_out.check()


def test_what_a_viewer_raises_stops_nothing() -> None:
    def fail(each: Block) -> None:
        raise OSError("window closed")

    fan_out = FanOut([Sink("viewer", fail, lossless=False)])
    fan_out.put(block(0))
    fan_out.close()
    fan_out.check()


def test_settling_waits_for_what_is_in_hand(monkeypatch: pytest.MonkeyPatch) -> None:
    held = Held()
    worker = Worker("test", held, 4)
    assert not worker.settle()
    worker.put(block(7))
    held.began.wait()
    waits = worker._queue.all_tasks_done.wait

    def let_go(timeout: float | None = None) -> bool:
        held.go.set()
        return waits(timeout)

    monkeypatch.setattr(worker._queue.all_tasks_done, "wait", let_go)
    assert worker.settle()
    assert held.taken == [7]
    worker.close()
    worker.close()
