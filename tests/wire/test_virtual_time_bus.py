"""The barrier of the in-process bus, and that it remains a python-can virtual bus."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import can
import pytest

from benchtool.clock import VirtualClock
from benchtool.errors import LinkClosed
from benchtool.link.canopen.virtual import VirtualTimeBus

FRAME = can.Message(arbitration_id=0x181, data=b"\x01\x02", is_extended_id=False)


@pytest.fixture
def bus(channel: str) -> Iterator[VirtualTimeBus]:
    with VirtualTimeBus(channel) as opened:
        yield opened


@pytest.fixture
def peer(channel: str) -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel=channel) as opened:
        yield opened


@contextmanager
def receiving(bus: can.BusABC, handle: Callable[[can.Message], None]) -> Iterator[threading.Thread]:
    stop = threading.Event()

    def run() -> None:
        while not stop.is_set():
            received = bus.recv(0.02)
            if received is not None:
                handle(received)

    thread = threading.Thread(target=run, name="receiving")
    thread.start()
    yield thread
    stop.set()
    thread.join()


def test_there_is_nothing_to_settle_without_frames(bus: VirtualTimeBus) -> None:
    assert bus.settle() is False


def test_settle_returns_after_the_last_frame_was_handled(bus: VirtualTimeBus, peer: can.BusABC) -> None:
    handled: list[int] = []
    with receiving(bus, lambda received: handled.append(received.arbitration_id)):
        for can_id in range(500):
            peer.send(can.Message(arbitration_id=can_id, is_extended_id=False))
        assert bus.settle() is True
        assert handled == list(range(500))
        assert bus.settle() is False


def test_settle_waits_for_the_handler_and_not_only_for_an_empty_queue(
    bus: VirtualTimeBus, peer: can.BusABC
) -> None:
    began, gate, settled = threading.Event(), threading.Event(), threading.Event()

    def handle(_: can.Message) -> None:
        began.set()
        gate.wait(5.0)

    def settle() -> None:
        bus.settle()
        settled.set()

    with receiving(bus, handle):
        peer.send(FRAME)
        assert began.wait(5.0)
        settling = threading.Thread(target=settle)
        settling.start()
        assert not settled.wait(0.05)
        gate.set()
        settling.join()
    assert settled.is_set()


def test_frames_that_a_filter_keeps_out_are_dealt_with(bus: VirtualTimeBus, peer: can.BusABC) -> None:
    bus.set_filters([{"can_id": 0x600, "can_mask": 0x7FF}])
    handled: list[can.Message] = []
    with receiving(bus, handled.append):
        peer.send(FRAME)
        assert bus.settle() is True
    assert handled == []


def test_a_filter_set_between_two_frames_counts_from_then_on(bus: VirtualTimeBus, peer: can.BusABC) -> None:
    """Also for frames that the bus took together with the one before."""
    for can_id in (0x101, 0x601, 0x102, 0x602, 0x103):
        peer.send(can.Message(arbitration_id=can_id, is_extended_id=False))
    received = [bus.recv(0.0)]
    bus.set_filters([{"can_id": 0x600, "can_mask": 0x700}])
    received += [bus.recv(0.1), bus.recv(0.1)]
    assert [each and each.arbitration_id for each in received] == [0x101, 0x601, 0x602]
    bus.set_filters(None)
    assert [each and each.arbitration_id for each in (bus.recv(0.0), bus.recv(0.0))] == [0x103, None]
    assert bus.settle() is False


def test_a_receiver_that_waits_can_be_woken_and_loses_nothing_by_it(
    bus: VirtualTimeBus, peer: can.BusABC
) -> None:
    received: list[can.Message | None] = []
    thread = threading.Thread(target=lambda: received.append(bus.recv(None)))
    thread.start()
    bus.wake()  # without which it would wait for ever
    thread.join()
    peer.send(FRAME)
    bus.wake()
    peer.send(FRAME)
    received += [bus.recv(0.0), bus.recv(0.0), bus.recv(0.0)]
    assert [each is not None for each in received] == [False, True, False, True]
    assert bus.recv(0.0) is None
    assert bus.settle() is False


def test_a_dead_receiver_is_named_at_once(bus: VirtualTimeBus, peer: can.BusABC) -> None:
    thread = threading.Thread(target=lambda: bus.recv(0), name="firmware")
    thread.start()
    thread.join()
    peer.send(FRAME)
    started_s = time.monotonic()
    with pytest.raises(LinkClosed, match=r"1 frames on .* because the receive thread 'firmware' has ended"):
        bus.settle()
    assert time.monotonic() - started_s < 1.0


def test_a_receiver_that_never_returns_is_told_after_the_timeout(
    bus: VirtualTimeBus, peer: can.BusABC
) -> None:
    peer.send(FRAME)
    with pytest.raises(LinkClosed, match="does not come back"):
        bus.settle(timeout_s=0.01)


def test_frames_to_a_bus_closed_since_are_not_waited_for(channel: str, peer: can.BusABC) -> None:
    bus = VirtualTimeBus(channel)
    peer.send(FRAME)
    bus.shutdown()
    assert bus.settle() is False
    with pytest.raises(can.CanOperationError):
        bus.send(FRAME)


def test_virtual_time_waits_for_answers_to_answers(channel: str) -> None:
    clock = VirtualClock()
    hops: list[int] = []
    with VirtualTimeBus(channel, clock=clock) as left, VirtualTimeBus(channel, clock=clock) as right:

        def passing_on(bus: can.BusABC) -> Callable[[can.Message], None]:
            def handle(received: can.Message) -> None:
                hops.append(received.arbitration_id)
                if received.arbitration_id < 100:
                    bus.send(can.Message(arbitration_id=received.arbitration_id + 1, is_extended_id=False))

            return handle

        clock.register(left.settle)
        clock.register(right.settle)
        with receiving(left, passing_on(left)), receiving(right, passing_on(right)):
            left.send(can.Message(arbitration_id=0, is_extended_id=False))
            clock.wait(0.0)
            assert hops == list(range(101))


def test_frames_cross_to_plain_peers_and_back_unchanged(bus: VirtualTimeBus, peer: can.BusABC) -> None:
    sent = [
        FRAME,
        can.Message(arbitration_id=0x12345678, is_extended_id=True, data=bytes(range(8))),
        can.Message(arbitration_id=0x705, is_extended_id=False, is_remote_frame=True, dlc=1),
        can.Message(arbitration_id=0, is_error_frame=True, is_extended_id=False),
        can.Message(arbitration_id=1, is_fd=True, bitrate_switch=True, data=bytes(64)),
    ]
    for source, sink in ((bus, peer), (peer, bus)):
        for message in sent:
            source.send(message)
            received = sink.recv(1.0)
            assert received is not None
            assert received.equals(message, timestamp_delta=None, check_channel=False)
            assert received.is_rx


def test_every_receiver_gets_a_message_of_its_own(channel: str, bus: VirtualTimeBus) -> None:
    message = can.Message(arbitration_id=1, data=b"\x01", is_extended_id=False)
    with VirtualTimeBus(channel) as first, VirtualTimeBus(channel) as second:
        bus.send(message)
        message.data[0] = 9
        one, two = first.recv(1.0), second.recv(1.0)
        assert one is not None
        assert two is not None
        one.data[0] = 7
        assert two.data == b"\x01"
    assert bus.recv(0) is None


def test_own_messages_come_back_only_on_request_and_marked(channel: str) -> None:
    with VirtualTimeBus(channel, receive_own_messages=True) as bus:
        bus.send(FRAME)
        received = bus.recv(1.0)
        assert received is not None
        assert not received.is_rx


def test_timestamps_are_the_clocks(channel: str, peer: can.BusABC) -> None:
    clock = VirtualClock()
    clock.wait(2.5)
    stamped = can.Message(arbitration_id=1, timestamp=7.0, is_extended_id=False)
    with (
        VirtualTimeBus(channel, clock=clock) as timed,
        VirtualTimeBus(channel, preserve_timestamps=True) as kept,
    ):
        timed.send(stamped)
        kept.send(stamped)
        received = [peer.recv(1.0), peer.recv(1.0)]
    assert [message.timestamp for message in received if message is not None] == [2.5, 7.0]


def test_a_timestamp_without_a_clock_is_the_time_of_day(bus: VirtualTimeBus, peer: can.BusABC) -> None:
    before_s = time.time()
    bus.send(FRAME)
    received = peer.recv(1.0)
    assert received is not None
    assert before_s <= received.timestamp <= time.time()


def test_a_full_receiver_is_an_error_of_the_sender(channel: str, bus: VirtualTimeBus) -> None:
    with can.Bus(interface="virtual", channel=channel, rx_queue_size=1) as full:
        bus.send(FRAME)
        with pytest.raises(can.CanOperationError):
            bus.send(FRAME, timeout=0.01)
        assert full.recv(0) is not None


def test_frames_sent_together_are_those_sent_one_by_one(channel: str) -> None:
    contents = [bytes([number, 5, 6]) for number in range(3)]
    clock = VirtualClock()
    with (
        VirtualTimeBus(channel, clock=clock, receive_own_messages=True) as source,
        VirtualTimeBus(channel, preserve_timestamps=True) as sink,
    ):
        for sender in (source, sink):
            for data in contents:
                sender.send(can.Message(arbitration_id=0x585, data=data, is_extended_id=False, timestamp=2.5))
            sender.send_data(0x585, contents, 2.5)
        for receiver in (source, sink):
            received = [receiver.recv(0.0) for _ in range(6 if receiver is sink else 12)]
            assert None not in received
            assert receiver.recv(0.0) is None
            for one, other in zip(_each_of(received, 0), _each_of(received, 3), strict=True):
                assert other.equals(one, timestamp_delta=0.0)


def _each_of(received: list[can.Message | None], first: int) -> list[can.Message]:
    """Return the frames of one way of sending, which alternate three by three."""
    return [
        each for at in range(first, len(received), 6) for each in received[at : at + 3] if each is not None
    ]
