"""The stream at the control rate over a serial line: every tick, the bits of a capture, nothing uncounted."""

from __future__ import annotations

import threading

import numpy as np
import pytest
import serial
from numpy.typing import NDArray

from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.core.stream_ring import RING_ROWS
from benchtool.emulator.firmware.objects import ObjectStore
from benchtool.emulator.servers.serial import MAX_REPLY
from benchtool.emulator.servers.serial_stream import ControlRateStream
from benchtool.emulator.servers.transmitter import CAPACITY, RESERVE
from benchtool.protocol import serial as wire
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.capture_data import HEADER_SIZE, decode_header
from benchtool.protocol.dictionary.objects import DataType
from tests.physics.paper_machine import make_core
from tests.wire.raw_host import TABLE, RawHost, mapping

START, STOP, PRE_OPERATIONAL, RESET_COMMUNICATION = 1, 2, 128, 130
OF_A_WORD = [e.name for e in TABLE if e.role == "signal" and e.type in (DataType.F32, DataType.U32)]
SIGNALS = ["tick", *(name for name in OF_A_WORD if name != "tick")][:16]


def _stream(
    host: RawHost, *names: str, stride: int = 1, batch: int = 10, scales: tuple[float, ...] = ()
) -> wire.StreamReply:
    mappings = tuple(map(mapping, names))
    return host.ask(
        wire.Stream(host.tag(), stride, batch, int(bool(scales)), mappings, scales), wire.StreamReply
    )


def _stop(host: RawHost) -> tuple[wire.StreamReply, list[wire.Batch]]:
    """The answer, and every batch since the last call."""
    replies = host.tell(wire.Stream(host.tag()))
    (answer,) = [each for each in replies if isinstance(each, wire.StreamReply)]
    assert isinstance(replies[-1], wire.StreamReply), "what was recorded comes before the answer"
    return answer, _batches(replies)


def _batches(replies: list[wire.Reply]) -> list[wire.Batch]:
    return [each for each in replies if isinstance(each, wire.Batch)]


def _words(batches: list[wire.Batch]) -> NDArray[np.uint32]:
    return np.concatenate([np.frombuffer(each.data, "<u4").reshape(each.n, -1) for each in batches])


def _ticks(batches: list[wire.Batch]) -> list[int]:
    return [each.first_tick + each.stride * row for each in batches for row in range(each.n)]


def test_three_seconds_of_sixteen_signals_are_every_tick_and_the_bits_of_a_capture(raw: RawHost) -> None:
    assert len(SIGNALS) == 16
    raw.enable()
    for number, name in enumerate(SIGNALS, start=1):
        raw.write(f"capture_channel_{number}", mapping(name))
    raw.write("capture_rows", 30_000)
    raw.write("capture_control", 1)
    raw.write("omega_m_command", 20.0)
    assert _stream(raw, *SIGNALS, batch=63).status == 0
    batches = []
    for _ in range(12):
        raw.bench.clock.wait(0.25)
        batches += _batches(raw.hear())
    answer, rest = _stop(raw)
    batches += rest
    assert (answer.sent, answer.dropped) == (30_000, 0)
    assert _ticks(batches) == list(range(1, 30_001))
    assert [each.sequence for each in batches] == list(range(len(batches)))
    assert {each.n for each in batches[:-1]} == {63}
    rows = _words(batches)
    assert rows[:, 0].tolist() == _ticks(batches)
    raw.bench.clock.wait(0.001)
    entry = TABLE.by_name["capture_data"]
    opened = raw.ask(wire.Open(1, entry.index, entry.sub), wire.OpenReply)
    count = -(-opened.size // opened.chunk_size)
    data = b"".join(
        each.data
        for each in raw.tell(wire.Chunks(1, opened.upload, 0, count))
        if isinstance(each, wire.ChunkReply)
    )
    header = decode_header(data)
    assert (header.first_tick, header.rows) == (1, 30_000)
    assert np.array_equal(rows, np.frombuffer(data, "<u4", offset=HEADER_SIZE).reshape(-1, 16))
    assert np.ptp(rows[:, SIGNALS.index("i_a")].view(np.float32)) > 0.1, "the motor turned"


def test_records_stand_on_the_grid_of_their_stride(raw: RawHost) -> None:
    raw.tell(wire.Nmt(START))
    raw.bench.clock.wait(0.0007)
    _stream(raw, "tick", stride=25, batch=4)
    raw.bench.clock.wait(0.05)
    answer, batches = _stop(raw)
    assert _ticks(batches) == list(range(25, 501, 25)) == _words(batches)[:, 0].tolist()
    assert [each.n for each in batches] == [4] * 5
    assert (answer.sent, {each.stride for each in batches}) == (20, {25})


def test_scaled_records_hold_steps_and_what_does_not_fit_is_marked(raw: RawHost) -> None:
    raw.tell(wire.Nmt(START))
    _stream(raw, "u_dc", "tick", "u_dc", scales=(0.01, 0.5, 1e-4))
    raw.bench.clock.wait(0.01)
    _, batches = _stop(raw)
    steps = np.concatenate([np.frombuffer(each.data, "<i2").reshape(each.n, 3) for each in batches])
    assert steps[:, 0] * 0.01 == pytest.approx(122.5, abs=0.5)
    assert np.abs(steps[:, 1] * 0.5 - _ticks(batches)).max() <= 0.25
    assert set(steps[:, 2]) == {-32768}


def test_streams_run_in_operational_only(raw: RawHost) -> None:
    assert _stream(raw, "tick", batch=10) == wire.StreamReply(raw._tag, 0, 1)
    raw.bench.clock.wait(0.01)
    assert _batches(raw.tell(wire.Nmt(START))) == []
    raw.bench.clock.wait(0.0015)
    batches = _batches(raw.tell(wire.Nmt(PRE_OPERATIONAL)))
    raw.bench.clock.wait(0.01)
    batches += _batches(raw.tell(wire.Nmt(START)))
    raw.bench.clock.wait(0.001)
    answer, rest = _stop(raw)
    assert _ticks(batches + rest) == [*range(101, 116), *range(216, 226)]
    assert [(each.sequence, each.n) for each in batches + rest] == [(0, 10), (1, 5), (2, 10)]
    assert answer.sent == 25


def test_every_accepted_configuration_is_another_schema_with_counts_of_its_own(raw: RawHost) -> None:
    raw.tell(wire.Nmt(START))
    assert _stop(raw)[0] == wire.StreamReply(raw._tag, 0, 0, 0, 0)
    assert _stream(raw, "tick").schema == 1
    raw.bench.clock.wait(0.002)
    second = _stream(raw, "i_a", "tick")
    assert (second.schema, second.sent) == (2, 20)
    raw.bench.clock.wait(0.001)
    replies = raw.tell(wire.Stream(1, 1, 1, 0, (mapping("law"),)))
    assert wire.StreamReply(1, Abort.NOT_MAPPABLE, 2, 10, 0) in replies
    raw.bench.clock.wait(0.001)
    answer, batches = _stop(raw)
    assert (answer.schema, answer.sent, answer.dropped) == (2, 20, 0)
    told = [(each.schema, each.sequence) for each in _batches(replies) + batches]
    assert told == [(2, 0), (2, 1)], "a refusal changes nothing"
    assert _stop(raw)[0] == wire.StreamReply(raw._tag, 0, 2, 20, 0), "of the last one"


@pytest.mark.parametrize(
    ("message", "status"),
    [
        (wire.Stream(1, 1, 0, 0, (mapping("tick"),)), Abort.VALUE_LOW),
        (wire.Stream(1, 1, 1, 0, ()), Abort.VALUE_LOW),
        (wire.Stream(1, 1, 1, 0, (mapping("tick"),) * 17), Abort.VALUE_HIGH),
        (wire.Stream(1, 1, 64, 0, (mapping("tick"),) * 16), Abort.MAPPING_TOO_LONG),
        (wire.Stream(1, 1, 63, 0, (mapping("tick"),) * 16), 0),
        (wire.Stream(1, 1, 127, 1, (mapping("tick"),) * 16, (1.0,) * 16), 0),
        (wire.Stream(1, 1, 128, 1, (mapping("tick"),) * 16, (1.0,) * 16), Abort.MAPPING_TOO_LONG),
        (wire.Stream(1, 1, 1, 1, (mapping("tick"),), (0.0,)), Abort.VALUE),
        (wire.Stream(1, 1, 1, 1, (mapping("tick"),), (float("nan"),)), Abort.VALUE),
        (wire.Stream(1, 1, 1, 0, (mapping("tick") ^ 0x30,)), Abort.NOT_MAPPABLE),
        (wire.Stream(1, 1, 1, 0, (0x55550020,)), Abort.NO_OBJECT),
        (wire.Stream(1, 1, 1, 0, (mapping("R_s"),)), Abort.NOT_MAPPABLE),
        (wire.Stream(1, 1, 1, 0, (mapping("velocity_actual"),)), Abort.NOT_MAPPABLE),
        (wire.Stream(1, 1, 1, 0, (mapping("torque_command"),)), 0),
    ],
)
def test_what_can_be_streamed(raw: RawHost, message: wire.Stream, status: int) -> None:
    raw.tell(wire.Nmt(START))
    assert raw.ask(message, wire.StreamReply).status == status
    raw.bench.clock.wait(0.03)
    batches = _batches(raw.hear())
    assert bool(batches) == (status == 0)
    assert all(len(each.data) + 14 <= MAX_REPLY for each in batches)


def test_there_is_one_stream_which_ends_with_its_line_or_a_reset(bench: EmulatedBench, raw: RawHost) -> None:
    other = RawHost(bench)
    raw.tell(wire.Nmt(START))
    _stream(raw, "tick")
    busy = other.ask(wire.Stream(9, 1, 1, 0, (mapping("tick"),)), wire.Reject)
    assert busy == wire.Reject(9, 0x06, 3)
    assert _stop(other)[0].status == 0
    bench.clock.wait(0.002)
    assert len(_batches(raw.hear())) == 2
    raw.tell(wire.Nmt(RESET_COMMUNICATION), wire.Nmt(START))
    bench.clock.wait(0.002)
    assert _batches(raw.hear()) == []
    _stream(raw, "tick")
    raw.port.hang_up()
    bench.clock.wait(0.001)
    assert _stream(other, "tick").status == 0
    bench.clock.wait(0.002)
    assert _ticks(_batches(other.hear())) == list(range(51, 71))


# ---- a line that does not keep up ------------------------------------------------------------------------


class Valve:
    """What holds a port's writes back until it is opened."""

    def __init__(self, host: RawHost) -> None:
        self.entered = threading.Event()
        self.opened = threading.Event()
        self._keep = host.port.keep
        host.port.on_write = self._write

    def _write(self, data: bytes) -> None:
        self.entered.set()
        assert self.opened.wait(5.0)
        self._keep(data)


def _until(host: RawHost, kind: type[wire.Reply], replies: list[wire.Reply]) -> list[wire.Reply]:
    """Everything that comes up to an answer of this kind from a line with a thread of its own."""
    pause = threading.Event()
    for _ in range(500):
        replies += host.hear()
        if any(isinstance(each, kind) for each in replies):
            return replies
        pause.wait(0.01)
    raise AssertionError(f"no {kind.__name__} came")


def test_a_line_that_is_held_up_loses_telemetry_counts_it_and_keeps_answers(bench: EmulatedBench) -> None:
    host = RawHost(bench, buffered=True)
    told = host.tell(wire.Nmt(START), wire.Stream(1, 1, 63, 0, (mapping("tick"),) * 16))
    replies = _until(host, wire.StreamReply, told)
    valve = Valve(host)
    try:
        bench.clock.wait(0.5)
        assert valve.entered.wait(5.0)
        replies += host.tell(wire.Read(7, 0x2000, 2))
        bench.clock.wait(0.5)
    finally:
        valve.opened.set()
    replies = _until(host, wire.ReadReply, replies)
    answers = _until(host, wire.StreamReply, host.tell(wire.Stream(2)))
    (answer,) = [each for each in answers if isinstance(each, wire.StreamReply)]
    batches = _batches(replies + answers)
    received = sum(each.n for each in batches)
    assert answer.sent == 10_000
    assert 0 < received <= 63 * ((CAPACITY - RESERVE) // 4000 + 4)
    assert answer.dropped == 10_000 - received
    ticks = _ticks(batches)
    assert ticks == sorted(set(ticks))
    assert _words(batches)[:, 0].tolist() == ticks
    sequences = [each.sequence for each in batches]
    assert sequences == sorted(set(sequences)) != list(range(len(sequences))), "the host sees who lost them"


CAPTURE = {"capture_channel_1": mapping("tick"), "capture_rows": 50_000, "capture_control": 1}


def test_chunks_wait_for_the_line_and_are_all_sent(bench: EmulatedBench) -> None:
    host = RawHost(bench, buffered=True)
    for name, number in CAPTURE.items():
        entry = TABLE.by_name[name]
        data = number.to_bytes(entry.type.bits // 8, "little")
        _until(host, wire.WriteReply, host.tell(wire.Write(1, entry.index, entry.sub, data)))
    bench.clock.wait(5.1)
    entry = TABLE.by_name["capture_data"]
    told = _until(host, wire.OpenReply, host.tell(wire.Open(1, entry.index, entry.sub)))
    (opened,) = [each for each in told if isinstance(each, wire.OpenReply)]
    assert opened.size > 2 * CAPACITY
    count = -(-opened.size // opened.chunk_size)
    chunks = host.tell(wire.Chunks(1, opened.upload, 0, count))
    pause = threading.Event()
    for _ in range(500):
        if len(chunks) >= count:
            break
        pause.wait(0.01)
        chunks += host.hear()
    numbers = [each.chunk for each in chunks if isinstance(each, wire.ChunkReply)]
    assert numbers == list(range(count))


@pytest.mark.parametrize("reason", [TimeoutError("full"), serial.SerialTimeoutException("full")])
def test_a_write_that_times_out_loses_its_bytes_alone(bench: EmulatedBench, reason: OSError) -> None:
    host = RawHost(bench, buffered=True)
    _until(host, wire.Heartbeat, [])
    tried = threading.Event()

    def give_up(_: bytes) -> None:
        host.port.on_write = host.port.keep
        tried.set()
        raise reason

    host.port.on_write = give_up
    host.tell(wire.Read(1, 0x2000, 2))
    assert tried.wait(5.0)
    told = _until(host, wire.ReadReply, host.tell(wire.Read(2, 0x2000, 2)))
    assert [each.tag for each in told if isinstance(each, wire.ReadReply)] == [2]
    bench.clock.wait(0.001)
    assert host.lost == []


def test_a_line_that_fails_on_writing_is_gone(bench: EmulatedBench) -> None:
    host = RawHost(bench, buffered=True)
    keeps = RawHost(bench)

    def fail(_: bytes) -> None:
        raise OSError("no such device")

    host.port.on_write = fail
    bench.clock.wait(0.1)
    assert host.port.closed.wait(5.0)
    bench.clock.wait(0.1)
    assert [str(each) for each in host.lost] == ["no such device"]
    assert keeps.read("tick") == 2000


def test_rows_that_the_ring_lost_count_as_a_batch_that_was_dropped() -> None:
    core = make_core()
    batches: list[wire.Batch] = []

    def take(batch: wire.Batch) -> bool:
        batches.append(batch)
        return True

    objects = ObjectStore(TABLE, core.memory, lambda: False)
    stream = ControlRateStream(objects, core.stream, take, MAX_REPLY)
    layout = stream.layout(wire.Stream(1, 2, 64, 0, (mapping("tick"),)))
    assert layout is not None
    stream.begin(layout)
    stream.resume()
    core.run(2 * RING_ROWS + 20)
    stream.end()
    assert (stream.sent, stream.dropped) == (RING_ROWS + 10, 10)
    assert _ticks(batches) == list(range(22, 2 * RING_ROWS + 21, 2)) == _words(batches)[:, 0].tolist()
    assert [each.sequence for each in batches] == list(range(1, 65))
