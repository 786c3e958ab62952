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
from benchtool.link.canopen.virtual import FrameBurst, Received, VirtualTimeBus

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


@contextmanager
def serving(bus: VirtualTimeBus, handle: Callable[[Received], None]) -> Iterator[list[Exception]]:
    """Have a thread serve a bus, which keeps what is raised there."""
    stop, raised = threading.Event(), list[Exception]()
    assert bus.handle_with(handle)

    def run() -> None:
        while not stop.is_set():
            try:
                bus.serve(0.02)
            except LookupError as failure:
                raised.append(failure)

    thread = threading.Thread(target=run, name="serving")
    thread.start()
    yield raised
    stop.set()
    bus.wake()
    thread.join()
    bus.leave()


def ids_of(received: Received) -> list[int]:
    frames = received if isinstance(received, FrameBurst) else (received,)
    return [each.arbitration_id for each in frames]


def test_frames_are_handled_in_order_by_the_thread_that_settles(channel: str) -> None:
    clock = VirtualClock()
    handled: list[tuple[int, str]] = []

    def handle(received: Received) -> None:
        handled.extend((each, threading.current_thread().name) for each in ids_of(received))

    with (
        VirtualTimeBus(channel, clock=clock) as bus,
        VirtualTimeBus(channel, clock=clock) as peer,
        serving(bus, handle),
    ):
        for can_id in range(300):
            peer.send(can.Message(arbitration_id=can_id, is_extended_id=False))
            if can_id % 3 == 0:
                peer.send_data(can_id, [b"\x01", b"\x02"], 0.0)
            if can_id % 50 == 0:
                assert bus.settle() is True
        bus.settle()
        assert bus.settle() is False
    sent = [each for can_id in range(300) for each in [can_id] * (3 if can_id % 3 == 0 else 1)]
    assert [can_id for can_id, _ in handled] == sent
    assert threading.current_thread().name in {name for _, name in handled}


def test_frames_are_handled_where_no_thread_settles(channel: str) -> None:
    clock = VirtualClock()
    arrived = threading.Event()
    with (
        VirtualTimeBus(channel, clock=clock) as bus,
        VirtualTimeBus(channel, clock=clock) as peer,
        serving(bus, lambda _: arrived.set()),
    ):
        peer.send(FRAME)
        assert arrived.wait(5.0)


@pytest.mark.parametrize("clock", [None, VirtualClock()])
def test_what_a_handler_raises_is_its_receivers(channel: str, clock: VirtualClock | None) -> None:
    handled: list[int] = []

    def handle(received: Received) -> None:
        handled.extend(ids_of(received))
        if handled[-1] == 2:
            raise LookupError("no such number")

    with VirtualTimeBus(channel, clock=clock) as bus, VirtualTimeBus(channel) as peer:
        with serving(bus, handle) as raised:
            for can_id in range(5):
                peer.send(can.Message(arbitration_id=can_id, is_extended_id=False))
            assert bus.settle() is True
        assert [str(each) for each in raised] == ["no such number"]
    assert handled == list(range(5))


def test_only_frames_that_pass_a_filter_are_handled(channel: str) -> None:
    handled: list[int] = []
    with (
        VirtualTimeBus(channel, can_filters=[{"can_id": 7, "can_mask": 0x7FF}]) as bus,
        VirtualTimeBus(channel) as peer,
        serving(bus, lambda received: handled.extend(ids_of(received))),
    ):
        for can_id in (6, 7, 8):
            peer.send_data(can_id, [b"", b""], 0.0)
        bus.settle()
    assert handled == [7, 7]


def test_a_receiver_that_has_ended_is_missed(channel: str) -> None:
    with VirtualTimeBus(channel) as bus, VirtualTimeBus(channel) as peer:
        with serving(bus, lambda _: None):
            peer.send(FRAME)
            bus.settle()
        peer.send(FRAME)
        with pytest.raises(LinkClosed, match="the receive thread 'serving' has ended"):
            bus.settle()


def test_a_bus_with_a_reception_of_its_own_is_not_handled(channel: str) -> None:
    class Lossy(VirtualTimeBus):
        def recv(self, timeout: float | None = None) -> can.Message | None:
            return super().recv(timeout)

    with Lossy(channel) as lossy, VirtualTimeBus(channel, rx_queue_size=3) as bounded:
        assert not lossy.handle_with(lambda _: None)
        assert not bounded.handle_with(lambda _: None)


def test_frames_sent_at_once_come_one_by_one(channel: str, bus: VirtualTimeBus) -> None:
    with VirtualTimeBus(channel) as peer:
        peer.send_data(5, [b"\x01", b"\x02"], 0.0)
        peer.send(FRAME)
        received = [bus.recv(0.0) for _ in range(4)]
    assert [each and (each.arbitration_id, bytes(each.data)) for each in received] == [
        (5, b"\x01"),
        (5, b"\x02"),
        (0x181, b"\x01\x02"),
        None,
    ]
