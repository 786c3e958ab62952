"""One drive on several wires: the same values, one NMT state, one supervision, independent wires."""

from __future__ import annotations

import itertools
import struct
import threading
from collections.abc import Iterator

import can
import pytest

from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import LinkClosed
from benchtool.link.canopen.virtual import VirtualTimeBus
from benchtool.link.serial.link import SerialLink
from benchtool.profile import load_profile
from benchtool.protocol.canopen.nmt import NmtCommand
from benchtool.protocol.serial import Batch, Event, Heartbeat, HostHeartbeat, Nmt, Setpoint
from tests.wire.endpoints import frame
from tests.wire.raw_host import HOST, SUPERVISION, TABLE, RawHost

NODE = 1
_numbers = itertools.count()


class CanHost:
    """A plain python-can bus to a drive."""

    def __init__(self, bench: EmulatedBench, *, main: bool = True) -> None:
        self._clock = bench.clock
        channel = bench.channel if main else f"shared-{next(_numbers)}"
        if not main:
            drive_end = VirtualTimeBus(channel, clock=bench.clock, preserve_timestamps=True)
            bench.clock.register(drive_end.settle)
        self.bus = can.Bus(interface="virtual", channel=channel)
        if not main:
            bench.add_can(drive_end)

    def tell(self, can_id: int, data: str) -> list[tuple[int, str]]:
        self.bus.send(frame(can_id, data))
        return self.hear()

    def hear(self) -> list[tuple[int, str]]:
        self._clock.wait(0.0)
        seen = []
        while (got := self.bus.recv(0)) is not None:
            seen.append((got.arbitration_id, bytes(got.data).hex()))
        return seen


@pytest.fixture
def shared() -> Iterator[EmulatedBench]:
    bench = EmulatedBench(load_profile("zhu2011"))
    yield bench
    bench.close()


@pytest.fixture
def bus(shared: EmulatedBench) -> Iterator[CanHost]:
    host = CanHost(shared)
    yield host
    host.bus.shutdown()


@pytest.fixture
def line(shared: EmulatedBench) -> RawHost:
    host = RawHost(shared)
    host.hear()
    return host


def test_what_one_wire_writes_the_other_reads(bus: CanHost, line: RawHost) -> None:
    assert bus.tell(0x601, "2300200200004040") == [(0x581, "6000200200000000")]
    assert line.read("R_s") == 3.0
    line.write("R_s", 0.5)
    assert bus.tell(0x601, "4000200200000000") == [(0x581, "430020020000003f")]


def test_a_command_on_one_wire_is_seen_on_the_other(bus: CanHost, line: RawHost) -> None:
    assert bus.tell(0x000, "0101") == []
    assert line.hear() == [Heartbeat(5, 0)]
    line.write("producer_heartbeat", 10)
    line.tell(Nmt(2))
    assert bus.hear() == [], "CAN has time until the next heartbeat"
    line.bench.clock.wait(0.01)
    assert bus.hear() == [(0x701, "04")]
    assert line.tell(Nmt(129)) == [Heartbeat(4, 100), Heartbeat(0, 100)]
    assert bus.hear() == [(0x701, "00")]


@pytest.mark.parametrize("how", ["bus", "line"])
def test_either_wire_feeds_the_supervision_and_both_hear_of_its_end(
    bus: CanHost, line: RawHost, how: str
) -> None:
    line.write("host_heartbeat", SUPERVISION)
    line.tell(HostHeartbeat(HOST, 5))
    line.enable()
    for number in range(6):
        line.bench.clock.wait(0.3)
        if how == "bus":
            bus.tell(0x700 + HOST, "05")
        else:
            line.tell(Setpoint(number, 0.0, 0.0))
    assert line.enabled()
    bus.hear()
    line.bench.clock.wait(0.6)
    assert [data for can_id, data in bus.hear() if can_id == 0x081] == ["3081110000000000"]
    (event,) = [each for each in line.hear() if isinstance(each, Event)]
    assert event.emergency.code == 0x8130
    assert not line.enabled()


def test_two_can_buses_do_not_share_a_transfer_but_the_process_data(
    bus: CanHost, shared: EmulatedBench
) -> None:
    second = CanHost(shared, main=False)
    try:
        assert second.hear() == [(0x701, "00")]
        # Two segmented uploads of the device name, taken in turns.
        assert bus.tell(0x601, "4008100000000000")[0][1].startswith("41081000")
        assert second.tell(0x601, "4008100000000000")[0][1].startswith("41081000")
        name = {"bus": b"", "second": b""}
        for turn in range(4):
            for key, host in (("bus", bus), ("second", second)):
                ((_, data),) = host.tell(0x601, f"{0x60 | turn % 2 << 4:02x}00000000000000")
                unused = int(data[:2], 16) >> 1 & 7
                name[key] += bytes.fromhex(data)[1 : 8 - unused]
        assert name == dict.fromkeys(name, b"benchtool reference drive")
        tick = TABLE.by_name["tick"].mapping
        for request in (
            f"23001a01{tick.to_bytes(4, 'little').hex()}",
            "2f001a0001000000",
            "2b00180501000000",
        ):
            assert bus.tell(0x601, request)[0][1].startswith("60")
        assert bus.tell(0x601, "2300180181010000")[0][1].startswith("60")
        second.tell(0x000, "0100")
        shared.clock.wait(0.002)
        assert bus.hear() == second.hear() == [(0x181, "0a000000"), (0x181, "14000000")]
    finally:
        second.bus.shutdown()


class BrokenBus(VirtualTimeBus):
    """An adapter that can be unplugged."""

    unplugged = False

    def recv(self, timeout: float | None = None) -> can.Message | None:
        if self.unplugged:
            raise can.CanOperationError("unplugged")
        return super().recv(0.01)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if self.unplugged:
            raise can.CanOperationError("unplugged")
        super().send(msg, timeout)


def test_an_adapter_that_is_unplugged_takes_no_other_wire_with_it(
    shared: EmulatedBench, line: RawHost
) -> None:
    reasons: list[OSError] = []
    told = threading.Event()
    adapter = BrokenBus(f"shared-{next(_numbers)}")

    def gone(reason: OSError) -> None:
        reasons.append(reason)
        told.set()

    shared.add_can(adapter, gone)
    adapter.unplugged = True
    for _ in range(500):
        shared.clock.wait(0.001)
        if told.wait(0.01):
            break
    assert [str(each) for each in reasons] == ["the adapter stopped working: unplugged"]
    assert line.read("tick") > 0


def test_a_defect_of_a_server_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    monkeypatch.setattr("benchtool.emulator.servers.serial.decode_request", lambda _: 1 / 0)
    host = RawHost(bench)
    host.tell(Nmt(1))
    assert host.port.closed.wait(5.0)
    with pytest.raises(LinkClosed, match="ZeroDivisionError"):
        bench.clock.wait(0.001)
    with pytest.raises(LinkClosed, match="ZeroDivisionError"):
        bench.close()


def test_a_bench_without_a_can_bus_has_none() -> None:
    bench = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    host = CanHost(bench)
    bench.clock.wait(0.2)
    assert host.tell(0x601, "4000200200000000") == []
    host.bus.shutdown()
    bench.close()


def test_the_line_of_a_bench_is_in_its_time() -> None:
    bench = EmulatedBench(load_profile("zhu2011"), has_bus=False)
    with SerialLink(bench.host_port(), NODE, bench.clock) as link:
        assert link.upload(0x2000, 2) == struct.pack("<f", 0.123)
        batches: list[tuple[Batch, float]] = []
        link.nmt(NmtCommand.START)
        link.on_batch(lambda batch, arrival_s: batches.append((batch, arrival_s)))
        assert link.configure_stream([TABLE.by_name["tick"].mapping], 1, 50).schema == 1
        bench.clock.wait(1.0)
        ended = link.configure_stream()
        assert (ended.sent, ended.dropped) == (10_000, 0)
    bench.close()
    assert [batch.first_tick for batch, _ in batches] == list(range(1, 10_001, 50))
    late_s = [arrival_s - (batch.first_tick + 49) * 1e-4 for batch, arrival_s in batches]
    assert late_s == pytest.approx([0.0] * 200, abs=1e-9), (
        "batches bear the time of the tick that filled them"
    )
