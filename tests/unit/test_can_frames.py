"""Frames of instruments: received data never raise, and every dropped frame is counted."""

from __future__ import annotations

import math
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

import can
import pytest
from hypothesis import given, strategies as st

from benchtool.bench.can_frames import BusListener, FrameCounters, MessageListener
from benchtool.clock import VirtualClock
from benchtool.errors import LinkClosed, NoAnswer
from benchtool.link import Frame
from benchtool.link.canopen.timestamps import AdapterTimestamps
from benchtool.protocol.dbc import DbcMessage

DBC = """VERSION ""
NS_ :
BS_:
BU_: Sensor

BO_ 801 Torque: 4 Sensor
 SG_ torque : 0|32@1- (1,0) [-20|20] "Nm" Sensor

SIG_VALTYPE_ 801 torque : 1;
"""


@pytest.fixture(scope="module")
def message(tmp_path_factory: pytest.TempPathFactory) -> DbcMessage:
    path = tmp_path_factory.mktemp("dbc") / "torque.dbc"
    path.write_text(DBC, encoding="utf-8")
    return DbcMessage(path, "Torque", ("torque",))


def _frame(value: float, at_s: float) -> Frame:
    return Frame(801, struct.pack("<f", value), at_s)


@given(payloads=st.lists(st.binary(max_size=12), max_size=30))
def test_every_frame_is_kept_or_counted(message: DbcMessage, payloads: list[bytes]) -> None:
    listener = MessageListener(message, 1000.0, VirtualClock(), most=10)
    listener.start()
    for payload in payloads:
        listener.on_frame(Frame(801, payload, 0.0))
    kept, counters = listener.stop(), listener.counters
    assert counters.received == len(payloads)
    assert len(kept) + counters.dropped == len(payloads)
    assert counters.malformed == sum(len(payload) < 4 for payload in payloads)
    assert all(-20.0 <= each.values["torque"] <= 20.0 for each in kept)


def test_what_is_dropped_is_told_apart(message: DbcMessage) -> None:
    listener = MessageListener(message, 1000.0, VirtualClock(), most=3)
    listener.start()
    for value in (1.0, math.nan, 2.0, math.inf, -20.1, 3.0, 4.0):
        listener.on_frame(_frame(value, 0.0))
    listener.on_frame(Frame(801, b"\0\0\0", 0.0))
    assert listener.counters == FrameCounters(received=8, malformed=1, out_of_range=3, overflow=1)
    assert [each.values["torque"] for each in listener.stop()] == [1.0, 2.0, 3.0]
    assert listener.stop() == [], "given away"


def test_a_recording_begins_before_it_is_started(message: DbcMessage) -> None:
    listener = MessageListener(message, 100.0, VirtualClock())
    for number in range(50):
        listener.on_frame(_frame(number % 20, number / 100.0))
    listener.start()
    assert [each.arrival_s for each in listener.stop()] == [number / 100.0 for number in range(40, 50)]


def test_silence_is_told_in_the_time_of_the_clock(message: DbcMessage) -> None:
    clock = VirtualClock()
    listener = MessageListener(message, 1000.0, clock)
    with pytest.raises(NoAnswer, match=r"no frame of 'Torque' \(identifier 0x321\) for 0.1 s; 0 frames came"):
        listener.require_alive()
    assert 0.1 <= clock.now_s() < 0.2, "it was given its time"
    listener.on_frame(_frame(30.0, clock.now_s()))
    listener.require_alive()  # out of range is no silence
    with pytest.raises(NoAnswer, match="1 of them damaged or out of range"):
        listener.latest()
    listener.on_frame(_frame(3.0, clock.now_s()))
    assert listener.latest() == {"torque": 3.0}
    clock.wait(0.11)
    with pytest.raises(NoAnswer):
        listener.require_still_alive()


class _Bus(can.BusABC):
    """A bus that gives what a script says: frames, or errors of its driver."""

    def __init__(self, script: Iterator[can.Message | Exception | None]) -> None:
        super().__init__(channel="scripted")
        self.channel_info = "scripted"
        self.ended = threading.Event()
        self._script = script

    def recv(self, timeout: float | None = None) -> can.Message | None:
        item = next(self._script, self)
        if isinstance(item, Exception):
            raise item
        if item is self:
            self.ended.wait(0.001)
            self.ended.set()
            return None
        assert not isinstance(item, _Bus)
        return item

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        raise AssertionError("nothing is sent to instruments")


@contextmanager
def _listening(
    message: DbcMessage, script: list[can.Message | Exception | None]
) -> Iterator[tuple[BusListener, MessageListener, _Bus]]:
    bus = _Bus(iter(script))
    clock = VirtualClock()
    listener = BusListener(bus, lambda frame: frame.timestamp)
    torque = MessageListener(message, 1000.0, clock, check=listener.check)
    listener.listen(message.can_id, torque.on_frame, extended=message.extended)
    try:
        yield listener, torque, bus
    finally:
        listener.close()


def _sent(value: float = 1.0, **options: bool) -> can.Message:
    return can.Message(
        arbitration_id=801, data=struct.pack("<f", value), **{"is_extended_id": False, **options}
    )


def _until(condition: Callable[[], bool], patience: threading.Event) -> None:
    for _ in range(5000):
        if condition():
            return
        patience.wait(0.001)
    raise AssertionError("it never came")


def test_a_driver_that_raises_ends_nothing(message: DbcMessage) -> None:
    quiet: list[can.Message | Exception | None] = [None] * 5
    script = [
        *quiet,
        *[can.CanError("noise")] * 50,
        _sent(),
        ValueError("driver"),
        _sent(is_extended_id=True),
    ]
    script += [_sent(is_error_frame=True), can.Message(arbitration_id=802), _sent(2.0)]
    with _listening(message, [*[None] * 200, *script]) as (listener, torque, bus):
        torque.start()
        _until(bus.ended.is_set, bus.ended)
        listener.check()
        assert [each.values["torque"] for each in torque.stop()] == [1.0, 2.0]


def test_an_adapter_that_has_gone_is_the_reason_of_the_silence(message: DbcMessage) -> None:
    unplugged: list[can.Message | Exception | None] = [can.CanError("unplugged")] * 1000
    with _listening(message, unplugged) as (_, torque, bus), pytest.raises(LinkClosed, match="unplugged"):
        for _ in range(1000):
            bus.ended.wait(0.001)
            with suppress(NoAnswer):
                torque.require_alive()


# ---- stamps of adapters ------------------------------------------------------------------------------------


def _stamped(
    stamps: AdapterTimestamps, clock: VirtualClock, sent_s: float, late_s: float, origin_s: float
) -> float:
    """When a frame that the adapter saw at `sent_s` is said to have come, handled `late_s` after."""
    clock.wait(sent_s + late_s - clock.now_s())
    return stamps(can.Message(timestamp=origin_s + sent_s))


def test_stamps_are_even_where_the_host_was_late() -> None:
    clock = VirtualClock()
    stamps = AdapterTimestamps(clock)
    late = [0.0001, 0.0009, 0.0003, 0.004, 0.0001, 0.0008]
    found = [_stamped(stamps, clock, 0.01 * n, s, 1.7e9) for n, s in enumerate(late, start=1)]
    for number, at_s in enumerate(found, start=1):
        assert at_s == pytest.approx(0.01 * number + 0.0001, abs=2e-5)


def test_an_adapter_that_does_not_stamp_is_taken_at_the_hosts_word() -> None:
    clock = VirtualClock()
    stamps = AdapterTimestamps(clock)
    clock.wait(0.5)
    assert stamps(can.Message(timestamp=0.0)) == 0.5
    assert stamps(can.Message(timestamp=math.nan)) == 0.5


def test_an_adapters_clock_may_jump() -> None:
    clock = VirtualClock()
    stamps = AdapterTimestamps(clock)
    assert _stamped(stamps, clock, 1.0, 0.0, 100.0) == pytest.approx(1.0)
    assert _stamped(stamps, clock, 2.0, 0.0, 5.0) == pytest.approx(2.0)
    assert _stamped(stamps, clock, 3.0, 0.002, 5.0) == pytest.approx(3.0, abs=3e-4)
