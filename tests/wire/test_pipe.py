"""The in-process line: order, hang-up, and a barrier that waits for pending bytes."""

from __future__ import annotations

import sys
import threading

import pytest

from benchtool.clock import VirtualClock
from benchtool.errors import LinkClosed
from benchtool.link.pipe import PipePort, pipe


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


@pytest.fixture
def ends(clock: VirtualClock) -> tuple[PipePort, PipePort]:
    return pipe(clock)


def test_bytes_go_both_ways_in_order_with_their_times(
    clock: VirtualClock, ends: tuple[PipePort, PipePort]
) -> None:
    one, other = ends
    one.write(b"a")
    clock.wait(0.5)
    one.write(b"b")
    other.write_at(b"c", 0.25)
    assert other.read_timed() == (b"a", 0.0)
    assert other.read_timed() == (b"b", 0.5)
    assert one.read_timed() == (b"c", 0.25)
    assert other.read() == b"", "nothing more has come"


def test_a_read_that_would_wait_is_woken_and_loses_nothing_by_it(
    ends: tuple[PipePort, PipePort], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[PipePort.__module__], "READ_S", threading.TIMEOUT_MAX)
    one, other = ends
    other.wake()
    assert other.read() == b""
    one.write(b"a")
    other.wake()
    assert other.read() == b"a"
    thread = threading.Thread(target=other.read)
    thread.start()
    other.wake()
    thread.join()


def test_what_was_sent_before_a_hang_up_still_arrives(ends: tuple[PipePort, PipePort]) -> None:
    one, other = ends
    one.write(b"last")
    one.close()
    one.close()
    assert other.read() == b"last"
    with pytest.raises(OSError, match="hung up"):
        other.read()
    with pytest.raises(OSError, match="hung up"):
        other.write(b"x")
    with pytest.raises(OSError, match="closed"):
        one.read()
    with pytest.raises(OSError, match="closed"):
        one.write(b"x")


def test_settling_waits_for_what_is_in_hand(ends: tuple[PipePort, PipePort]) -> None:
    one, other = ends
    assert not other.settle()
    one.write(b"request")
    dealt_with: list[bytes] = []
    in_hand, settling = threading.Event(), threading.Event()

    def serve() -> None:
        data = other.read()
        in_hand.set()
        settling.wait()
        dealt_with.append(data)
        other.read()

    reader = threading.Thread(target=serve)
    reader.start()
    in_hand.wait()
    waits = other._lock.wait

    def let_go(timeout: float | None = None) -> bool:
        settling.set()
        return waits(timeout)

    other._lock.wait = let_go  # type: ignore[method-assign]
    try:
        assert other.settle()
        assert dealt_with == [b"request"]
    finally:
        settling.set()
        reader.join()


def test_a_reader_that_has_ended_is_named(ends: tuple[PipePort, PipePort]) -> None:
    one, other = ends
    one.write(b"request")
    reader = threading.Thread(target=other.read, name="reader")
    reader.start()
    reader.join()
    with pytest.raises(LinkClosed, match="receive thread 'reader' has ended"):
        other.settle()


def test_a_reader_that_does_not_come_back_is_named(ends: tuple[PipePort, PipePort]) -> None:
    one, other = ends
    one.write(b"request")
    with pytest.raises(LinkClosed, match="does not come back"):
        other.settle(timeout_s=0.01)


def test_bytes_to_a_closed_end_are_not_waited_for(ends: tuple[PipePort, PipePort]) -> None:
    one, other = ends
    one.write(b"request")
    other.close()
    assert not other.settle()


def test_settling_waits_until_a_reader_has_taken_a_hang_up(ends: tuple[PipePort, PipePort]) -> None:
    one, other = ends
    settling = threading.Event()
    concluded: list[str] = []

    def serve() -> None:
        try:
            while True:
                other.read()
        except OSError as reason:
            settling.wait()
            concluded.append(str(reason))

    reader = threading.Thread(target=serve)
    reader.start()
    one.write(b"request")
    other.settle()
    one.close()
    waits = other._lock.wait

    def let_go(timeout: float | None = None) -> bool:
        if threading.current_thread() is not reader:
            settling.set()
        return waits(timeout)

    other._lock.wait = let_go  # type: ignore[method-assign]
    try:
        assert other.settle()
        assert concluded == ["the other end hung up"]
    finally:
        settling.set()
        reader.join()
    assert not other.settle()
