"""Process data through the link: subscribers get them in the receive thread, which no exception ends."""

from __future__ import annotations

import queue

import can
import pytest

from benchtool.clock import RealClock
from benchtool.errors import LinkClosed
from benchtool.link import Frame
from benchtool.link.canopen.link import CanopenLink
from tests.wire.endpoints import NODE, ScriptedBus, frame


def _next(received: queue.Queue[Frame]) -> tuple[int, str]:
    got = received.get(timeout=5.0)
    return got.can_id, got.data.hex()


def test_frames_go_to_who_subscribed_until_he_has_enough(scripted: ScriptedBus, host: CanopenLink) -> None:
    first: queue.Queue[Frame] = queue.Queue()
    second: queue.Queue[Frame] = queue.Queue()
    host.subscribe([0x185, 0x285], first.put)
    host.subscribe([0x385], second.put)
    for can_id, data in ((0x185, "0102"), (0x285, ""), (0x385, "03"), (0x485, "04")):
        scripted.arriving.put(frame(can_id, data))
    assert [_next(first), _next(first), _next(second)] == [(0x185, "0102"), (0x285, ""), (0x385, "03")]
    host.unsubscribe([0x185, 0x999])
    scripted.arriving.put(frame(0x185, "05"))
    scripted.arriving.put(frame(0x285, "06"))
    assert _next(first) == (0x285, "06")
    assert host.counters.frames_dropped == 0


def test_frames_other_than_data_reach_no_receiver(scripted: ScriptedBus, host: CanopenLink) -> None:
    received: queue.Queue[Frame] = queue.Queue()
    host.subscribe([0x185], received.put)
    scripted.arriving.put(frame(0x185, "", is_remote_frame=True))
    scripted.arriving.put(frame(0x185, "01", is_extended_id=True))
    scripted.arriving.put(frame(0x185, "02", is_error_frame=True))
    scripted.arriving.put(frame(0x185, "03"))
    assert _next(received) == (0x185, "03")
    assert received.empty()
    assert host.counters.frames_dropped == 3


def test_a_receiver_that_raises_is_counted_and_reception_goes_on(
    scripted: ScriptedBus, host: CanopenLink
) -> None:
    received: queue.Queue[Frame] = queue.Queue()

    def fail(_: Frame) -> None:
        raise ZeroDivisionError

    host.subscribe([0x185], fail)
    host.subscribe([0x285], received.put)
    scripted.arriving.put(frame(0x185, "01"))
    scripted.arriving.put(frame(0x285, "02"))
    assert _next(received) == (0x285, "02")
    assert host.counters.receive_errors == 1


def test_setpoints_are_sent_as_they_are_until_the_link_is_closed(
    scripted: ScriptedBus, host: CanopenLink
) -> None:
    host.send_pdo(0x205, bytes.fromhex("0011223344556677"))
    assert [(sent.arbitration_id, sent.data.hex()) for sent in scripted.sent] == [(0x205, "0011223344556677")]
    host.close()
    with pytest.raises(LinkClosed):
        host.send_pdo(0x205, b"")


def test_the_time_of_arrival_is_the_adapters_where_that_is_asked_for(scripted: ScriptedBus) -> None:
    received: queue.Queue[Frame] = queue.Queue()

    def stamp(arrived: can.Message) -> float:
        return arrived.timestamp

    with CanopenLink(scripted, NODE, RealClock(), arrival_s=stamp) as link:
        link.subscribe([0x185], received.put)
        scripted.arriving.put(frame(0x185, "01", timestamp=12.5))
        assert received.get(timeout=5.0) == Frame(0x185, b"\x01", 12.5)
