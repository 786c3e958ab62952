"""The stream over a serial line: what may come before its schema is known, and what is not ours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from benchtool.block import Block
from benchtool.clock import Clock, VirtualClock
from benchtool.errors import StateError, ValueRefused
from benchtool.link.interface import BatchReceiver, LinkCounters, ReceivedEmergency
from benchtool.link.process_data import Sent
from benchtool.link.serial.batch_source import BatchSource, TimedBatch
from benchtool.link.serial.process_data import BatchProcessData
from benchtool.protocol.canopen.nmt import NmtCommand, NmtState
from benchtool.protocol.dictionary import Dictionary
from benchtool.protocol.dictionary.variable import Value
from benchtool.protocol.serial import Batch, StreamReply
from benchtool.shipped import shipped
from benchtool.telemetry import Sink, TelemetryStream

DICTIONARY = Dictionary.from_eds(shipped("firmware_protocol") / "drive.eds", 1)
SCHEMA = 7


def batch(schema: int, sequence: int, *values: float) -> Batch:
    data = np.array(values, dtype="<f4").tobytes()
    return Batch(schema, sequence, 100 + sequence * len(values), 1, len(values), data)


class Link:
    """A `BatchLink` whose drive streams before it has answered."""

    node_id = 1
    counters = LinkCounters()
    clock: Clock = VirtualClock()

    def __init__(self, room: int, early: Sequence[Batch] = ()) -> None:
        self.room = room
        self.early = early
        self.asked: list[tuple[Sequence[int], int, int]] = []
        self.receiver: BatchReceiver | None = None

    @property
    def process_data(self) -> BatchProcessData:
        return BatchProcessData(self)

    def batch_rows(self, channels: int) -> int:
        return self.room

    def configure_stream(self, mappings: Sequence[int] = (), stride: int = 0, batch: int = 1) -> StreamReply:
        self.asked.append((mappings, stride, batch))
        for each in self.early if stride else ():
            self.say(each)
        return StreamReply(0, 0, SCHEMA, 30, 2)

    def say(self, each: Batch) -> None:
        if self.receiver is not None:
            self.receiver(each, 0.5)

    def on_batch(self, receiver: BatchReceiver | None) -> None:
        self.receiver = receiver

    def send_setpoint(self, torque_Nm: float, omega_m_rad_s: float) -> None: ...
    def upload(self, index: int, sub: int, *, block: bool = False, length: int | None = None) -> bytes:
        return b""

    def download(self, index: int, sub: int, data: bytes, *, block: bool = False) -> None: ...
    def nmt(self, command: NmtCommand) -> None: ...
    def send_heartbeat(self) -> None: ...
    def heartbeat_state(self) -> NmtState | None:
        return None

    def wait_heartbeat(self, timeout_s: float) -> NmtState:
        return NmtState.OPERATIONAL

    def emergencies(self) -> tuple[ReceivedEmergency, ...]:
        return ()

    def close(self) -> None: ...


class Node:
    """A drive with a control period of 100 us."""

    dictionary = DICTIONARY
    clock: Clock = VirtualClock()
    supervisor = None

    def __init__(self, link: Link) -> None:
        self.link = link

    def tick_now(self) -> int | None:
        return None

    def number(self, name: str) -> float:
        return 9.9999997e-05  # as a float32 holds it

    def write(self, name: str, value: Value) -> None: ...


def source(link: Link, rate_Hz: float = 10_000.0) -> BatchSource:
    return BatchSource(Node(link), link, ("torque",), rate_Hz)


def test_batches_that_come_before_the_answer_are_kept_and_others_are_not() -> None:
    early = [batch(SCHEMA - 1, 40, 9.0), batch(SCHEMA, 0, 1.0, 2.0), batch(SCHEMA, 1, 3.0, 4.0)]
    link = Link(20, early)
    made = source(link)
    received: list[TimedBatch] = []
    made.start(received.append)
    link.say(batch(SCHEMA - 1, 41, 9.0))
    link.say(batch(SCHEMA, 2, 5.0, 6.0))
    assert [made.feed(each) for each in received] == [True, True, True]
    block = made.decoder.pop_block()
    assert block is not None
    assert block.data[:, 0].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert (block.first_tick, block.stride, block.tick_s, block.gaps) == (100, 1, 1e-4, ())
    assert made.decoder.counters.off_grid == made.decoder.counters.malformed == 0
    assert made.stop() == Sent(30, 2)
    made.detach()
    link.say(batch(SCHEMA, 3, 7.0))
    assert len(received) == 3


@pytest.mark.parametrize(
    ("rate_Hz", "room", "expected"),
    [
        (10_000.0, 255, (1, 200)),
        (10_000.0, 20, (1, 20)),
        (1000.0, 255, (10, 20)),
        (1.0, 255, (10_000, 1)),
    ],
)
def test_a_batch_is_full_within_a_fiftieth_of_a_second(
    rate_Hz: float, room: int, expected: tuple[int, int]
) -> None:
    link = Link(room)
    source(link, rate_Hz).start(lambda _: None)
    assert link.asked == [([DICTIONARY["torque"].mapping], *expected)]


def test_a_record_that_fits_no_message_is_refused() -> None:
    with pytest.raises(ValueRefused, match="too long for this drive's messages"):
        source(Link(0)).start(lambda _: None)


@pytest.mark.parametrize("first_tick", [0, 2**32 - 30])
@pytest.mark.parametrize("away", [10, 2**31 - 8, 2**31 + 2, 2**32 - 16])
def test_what_was_missed_while_the_link_was_gone_is_a_gap_of_its_ticks(first_tick: int, away: int) -> None:
    """Up to 119 hours at 10 kHz, past the wrap of the drive's counter or not."""
    link, node, blocks = Link(room=30), Node(Link(room=30)), list[Block]()
    node.link, node.clock = link, VirtualClock()
    row = np.zeros(2, dtype="<f4").tobytes()
    with TelemetryStream(node, [Sink("kept", blocks.append, lossless=True)], ("torque",), 5_000.0) as stream:
        for tick in (first_tick, first_tick + 2 + away):
            if tick != first_tick:
                stream.resume()
            assert link.receiver is not None
            link.receiver(Batch(SCHEMA, 0, tick % 2**32, 2, 2, row), 1.0 + (tick - first_tick) * 1e-4)
    expected = [first_tick, first_tick + 2, first_tick + 2 + away, first_tick + 4 + away]
    assert [tick for block in blocks for tick in block.ticks()] == expected
    assert [gap.missing_rows for gap in stream.report().gaps] == [away // 2 - 1]


def test_a_drive_that_restarted_while_its_link_was_gone_ends_the_stream() -> None:
    link, node = Link(room=30), Node(Link(room=30))
    node.link, node.clock = link, VirtualClock()
    row = np.zeros(1, dtype="<f4").tobytes()
    with (
        pytest.raises(StateError, match="restarted while its link was lost: tick 100000 was followed by 50"),
        TelemetryStream(node, [], ("torque",), 5_000.0) as stream,
    ):
        for tick, arrival_s in ((100_000, 1.0), (50, 5.0)):
            if tick == 50:
                stream.resume()
            assert link.receiver is not None
            link.receiver(Batch(SCHEMA, 0, tick, 2, 1, row), arrival_s)
