"""The host's serial link against a port whose other end answers as told, in virtual time: nothing waits."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Iterable, Iterator

import pytest
from hypothesis import given, settings, strategies as st

from benchtool.clock import VirtualClock
from benchtool.errors import IdentityMismatch, LinkClosed, LinkError, NoAnswer, SdoAbort, ValueRefused
from benchtool.link import BatchLink, FrameLink
from benchtool.link.serial.link import SerialLink
from benchtool.protocol import serial as wire
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.emcy import Emergency
from benchtool.protocol.canopen.nmt import NmtCommand, NmtState
from tests.wire.scripted_serial import IDENTITY, NODE, Objects, ScriptedPort, Step, frame

VALUE = bytes.fromhex("78563412")
# Tag 1: who is there, version 1. Tag 2: read 0x2003:1, and its answer.
IDENTIFY = "00 08 01 01 01 f2 b2 9f 90 00"
READ = "00 0a 02 02 03 20 01 9b c6 2e f6 00"
READ_REPLY = "00 03 82 02 01 01 01 0c 03 20 01 78 56 34 12 94 26 74 a6 00"
LONG = random.Random(1).randbytes(1000)


@pytest.fixture
def clock() -> VirtualClock:
    return VirtualClock()


@pytest.fixture
def port(clock: VirtualClock) -> ScriptedPort:
    return ScriptedPort(clock)


@pytest.fixture
def objects(port: ScriptedPort) -> Objects:
    served = Objects()
    served.values = {(0x2000, 1): VALUE, (0x2100, 0): LONG}
    port.answer = served
    return served


@pytest.fixture
def link(port: ScriptedPort, clock: VirtualClock) -> Iterator[SerialLink]:
    with SerialLink(port, NODE, clock) as opened:
        yield opened


def test_it_is_a_link_of_batches_and_not_of_frames(link: SerialLink) -> None:
    assert isinstance(link, BatchLink)
    assert not isinstance(link, FrameLink)


# ---- the bytes on the wire ---------------------------------------------------------------------------------


def test_a_read_is_these_bytes_both_ways(port: ScriptedPort, link: SerialLink) -> None:
    port.answer = lambda _: [bytes.fromhex(READ_REPLY)]
    assert link.upload(0x2003, 1) == VALUE
    assert port.sent.hex(" ") == f"{IDENTIFY} {READ}"


def test_every_message_without_an_answer(port: ScriptedPort, link: SerialLink) -> None:
    link.nmt(NmtCommand.START)
    link.send_heartbeat()
    link.send_setpoint(1.5, -20.0)
    link.send_setpoint(1.5, -20.0)
    assert port.requests == [
        wire.Nmt(1),
        wire.HostHeartbeat(127, 5),
        wire.Setpoint(1, 1.5, -20.0),
        wire.Setpoint(2, 1.5, -20.0),
    ]


# ---- transfers ---------------------------------------------------------------------------------------------


def test_values_are_read_and_written(port: ScriptedPort, objects: Objects, link: SerialLink) -> None:
    link.download(0x2000, 1, b"\x01\x02")
    assert link.upload(0x2000, 1) == b"\x01\x02"
    assert [type(request) for request in port.requests] == [wire.Write, wire.Read]
    counters = link.counters
    assert (counters.frames_received, counters.frames_dropped, counters.retries) == (3, 0, 0)


@pytest.mark.parametrize("size", [0, 1, 15, 16, 17, 1000, 9000, 60_000])
def test_every_size_is_read_in_chunks(objects: Objects, link: SerialLink, size: int) -> None:
    objects.values[0x2100, 0] = random.Random(size).randbytes(size)
    assert link.upload(0x2100, 0, block=True) == objects.values[0x2100, 0]
    assert link.counters.retries == 0


def test_an_object_too_long_for_one_answer_is_read_in_chunks(objects: Objects, link: SerialLink) -> None:
    assert link.upload(0x2100, 0) == LONG
    assert link.counters.sdo_aborts == 0


def test_chunks_under_way_at_a_time_are_few(port: ScriptedPort, objects: Objects, link: SerialLink) -> None:
    objects.chunk_size = 1024
    objects.values[0x2100, 0] = bytes(50_000)
    assert link.upload(0x2100, 0, block=True) == bytes(50_000)
    asked = [request for request in port.requests if isinstance(request, wire.Chunks)]
    assert [request.first for request in asked] == [0, 8, 16, 24, 32, 40, 48]
    assert asked[-1].count == 1


def test_a_refusal_names_node_object_code_and_remedy(port: ScriptedPort, link: SerialLink) -> None:
    port.answer = Objects()
    with pytest.raises(SdoAbort, match="node 5 refused reading 0x3000:2: 0x06020000 object does not exist: "):
        link.upload(0x3000, 2)
    port.answer = lambda _: [wire.WriteReply(3, 0x06010002, 0x1000, 0)]
    with pytest.raises(SdoAbort, match="node 5 refused writing 0x1000:0: 0x06010002 ") as refused:
        link.download(0x1000, 0, b"\x01")
    assert refused.value.code == Abort.READ_ONLY
    assert link.counters.sdo_aborts == 2


@pytest.mark.parametrize("size", [0, 124])
def test_a_write_that_does_not_fit_a_message_is_not_sent(
    port: ScriptedPort, objects: Objects, link: SerialLink, size: int
) -> None:
    with pytest.raises(ValueRefused, match=rf"{size} bytes for 0x2000:1, .* 1 to 123: nothing was sent"):
        link.download(0x2000, 1, bytes(size))
    assert port.requests == []


# ---- silence, lateness, damage -----------------------------------------------------------------------------


def test_a_read_is_asked_twice_and_then_given_up(port: ScriptedPort, link: SerialLink) -> None:
    said = r"^node 5 did not answer within 0.5 s when reading 0x6041:0, asked twice; check [^\n]*$"
    with pytest.raises(NoAnswer, match=said):
        link.upload(0x6041, 0)
    assert port.requests == [wire.Read(2, 0x6041, 0), wire.Read(3, 0x6041, 0)]
    assert link.counters.retries == 1


def test_a_write_is_sent_once(port: ScriptedPort, link: SerialLink) -> None:
    with pytest.raises(NoAnswer, match="when writing 0x2000:1, asked once"):
        link.download(0x2000, 1, b"\x01")
    assert port.requests == [wire.Write(2, 0x2000, 1, b"\x01")]
    with pytest.raises(NoAnswer, match="when starting the stream, asked once"):
        link.configure_stream([0x20300120], 1, 4)
    assert len(port.requests) == 2


def test_a_drive_that_does_not_say_who_it_is(port: ScriptedPort, objects: Objects, link: SerialLink) -> None:
    port.identity = None
    with pytest.raises(NoAnswer, match="when asking who is there, asked twice"):
        link.upload(0x2000, 1)
    port.identity = IDENTITY
    assert link.upload(0x2000, 1) == VALUE


def test_late_and_wrong_answers_are_passed_over_and_counted(port: ScriptedPort, link: SerialLink) -> None:
    wrong: list[Step] = [
        wire.ReadReply(1, 0, 0x2000, 1, b"late"),
        wire.ReadReply(2, 0, 0x2000, 2, b"another object"),
        wire.WriteReply(2, 0, 0x2000, 1),
        wire.ChunkReply(2, 0, 7, 0, b"chunk"),
        wire.Reject(1, 2, 1),
        wire.Reject(2, 3, 1),
        dataclasses.replace(IDENTITY, tag=2),
    ]
    port.answer = lambda _: [
        *wrong,
        wire.ReadReply(2, 0, 0x2000, 1, VALUE),
        wire.ReadReply(2, 0, 0x2000, 1, b"again"),
    ]
    assert link.upload(0x2000, 1) == VALUE
    port.answer = Objects()
    link.download(0x2000, 1, b"\x01")
    assert link.counters.stale_answers == len(wrong) + 1


def test_a_damaged_answer_is_silence(port: ScriptedPort, link: SerialLink) -> None:
    def answer(request: wire.Request) -> Iterable[Step]:
        good = frame(wire.ReadReply(len(port.requests) + 1, 0, 0x2000, 1, VALUE))
        return [good[:-3] + bytes([good[-3] ^ 1]) + good[-2:] if len(port.requests) == 1 else good]

    port.answer = answer
    assert link.upload(0x2000, 1) == VALUE
    assert (link.counters.retries, link.counters.frames_dropped) == (1, 1)


def test_garbage_between_frames_costs_nothing_but_itself(
    port: ScriptedPort, objects: Objects, link: SerialLink
) -> None:
    noise = random.Random(2)
    plain = port.answer
    port.answer = lambda request: [
        part for step in plain(request) for part in (noise.randbytes(40) + b"\0", step)
    ]
    assert link.upload(0x2100, 0, block=True) == LONG
    assert link.counters.frames_dropped > 60
    assert link.counters.retries == 0


@settings(max_examples=30)
@given(st.lists(st.binary(max_size=60), max_size=8))
def test_nothing_that_comes_ends_the_reception(pieces: list[bytes]) -> None:
    clock = VirtualClock()
    port = ScriptedPort(clock)
    port.answer = Objects()
    with SerialLink(port, NODE, clock) as link:
        port.say(*pieces, b"\0")
        link.download(0x2000, 1, VALUE)
        assert link.upload(0x2000, 1) == VALUE


# ---- chunks ------------------------------------------------------------------------------------------------


def test_lost_chunks_are_asked_for_again_by_themselves(
    port: ScriptedPort, objects: Objects, link: SerialLink
) -> None:
    lost = {3, 7, 62}

    def spoil(reply: wire.ChunkReply) -> Iterable[Step]:
        if reply.chunk in lost:
            lost.discard(reply.chunk)
            return []
        return [reply]

    objects.spoil = spoil
    assert link.upload(0x2100, 0, block=True) == LONG
    again = [request for request in port.requests if isinstance(request, wire.Chunks)][1:]
    assert [(request.first, request.count) for request in again] == [(3, 1), (7, 1), (62, 1)]
    assert link.counters.retries == 3


def test_damaged_and_alien_chunks_are_not_taken(
    port: ScriptedPort, objects: Objects, link: SerialLink
) -> None:
    spoilt = {4, 5, 6}

    def spoil(reply: wire.ChunkReply) -> Iterable[Step]:
        if reply.chunk not in spoilt:
            return [reply]
        spoilt.discard(reply.chunk)
        if reply.chunk == 4:
            whole = frame(reply)
            return [whole[:20] + bytes([whole[20] ^ 0xFF or 1]) + whole[21:]]
        if reply.chunk == 5:
            return [dataclasses.replace(reply, data=reply.data[:-1])]
        return [dataclasses.replace(reply, upload=8), dataclasses.replace(reply, chunk=900)]

    objects.spoil = spoil
    assert link.upload(0x2100, 0, block=True) == LONG
    assert link.counters.retries == 3
    assert link.counters.frames_dropped == 3, "the damaged one, the short one, the invalid one"
    assert link.counters.stale_answers == 1


def test_a_chunk_that_never_comes_ends_the_upload(
    port: ScriptedPort, objects: Objects, link: SerialLink
) -> None:
    objects.spoil = lambda reply: [] if reply.chunk == 9 else [reply]
    with pytest.raises(NoAnswer, match="did not send 1 of 63 chunks when reading 0x2100:0, each asked for 4"):
        link.upload(0x2100, 0, block=True)
    assert [r.first for r in port.requests if isinstance(r, wire.Chunks)] == [0, 9, 9, 9]


def test_data_that_change_meanwhile_are_refused(objects: Objects, link: SerialLink) -> None:
    objects.spoil = lambda reply: [dataclasses.replace(reply, status=0x08000022, data=b"")]
    with pytest.raises(SdoAbort, match="0x08000022"):
        link.upload(0x2100, 0, block=True)


def test_a_wrong_crc_is_read_again_and_then_an_error(
    port: ScriptedPort, objects: Objects, link: SerialLink
) -> None:
    bad = [4]

    def spoil(reply: wire.ChunkReply) -> Iterable[Step]:
        if reply.chunk == 5 and bad:
            bad.pop()
            return [dataclasses.replace(reply, data=bytes(16))]
        return [reply]

    objects.spoil = spoil
    assert link.upload(0x2100, 0, block=True) == LONG
    assert [type(request) for request in port.requests] == [wire.Open, wire.Chunks, wire.Open, wire.Chunks]
    objects.spoil = lambda reply: [dataclasses.replace(reply, data=bytes(len(reply.data)))]
    with pytest.raises(LinkError, match="the CRC of 1000 bytes is wrong"):
        link.upload(0x2100, 0, block=True)


# ---- who is there ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("version", "remedy"), [(0, "update the drive's firmware"), (2, "update benchtool")])
def test_another_version_of_the_protocol_is_named(
    port: ScriptedPort, link: SerialLink, version: int, remedy: str
) -> None:
    port.identity = dataclasses.replace(IDENTITY, version=version, status=0x08000020)
    with pytest.raises(LinkError, match=f"speaks version {version} .* this benchtool version 1: {remedy}"):
        link.upload(0x2000, 1)
    assert port.requests == []


def test_another_node_is_named(port: ScriptedPort, link: SerialLink) -> None:
    port.identity = dataclasses.replace(IDENTITY, node_id=9)
    with pytest.raises(IdentityMismatch, match=r"node 9, node 5 is expected: .* add node=9 to the address"):
        link.upload(0x2000, 1)


def test_a_reset_of_the_drive_makes_the_host_ask_again(
    port: ScriptedPort, objects: Objects, link: SerialLink, clock: VirtualClock
) -> None:
    assert link.upload(0x2000, 1) == VALUE
    port.identity = dataclasses.replace(IDENTITY, version=2)
    assert link.upload(0x2000, 1) == VALUE
    port.say(wire.Heartbeat(0, 0))
    clock.settle()
    with pytest.raises(LinkError, match="speaks version 2"):
        link.upload(0x2000, 1)


def test_a_request_the_drive_does_not_know(port: ScriptedPort, link: SerialLink) -> None:
    port.answer = lambda request: [wire.Reject(2, 2, 1)]
    with pytest.raises(LinkError, match="reading 0x2000:1: it rejects message type 0x02, unknown type; "):
        link.upload(0x2000, 1)


# ---- what comes unasked ------------------------------------------------------------------------------------


def test_heartbeats_and_events(port: ScriptedPort, link: SerialLink, clock: VirtualClock) -> None:
    assert link.heartbeat_state() is None
    fault = Emergency(0x2310, 3, bytes(5))
    port.say(
        wire.Heartbeat(127, 10),
        wire.Event(250, 11, fault),
        wire.Event(251, 12, fault),
        wire.Event(2, 13, fault),
    )
    port.say(wire.Heartbeat(99, 0))
    clock.settle()
    assert link.heartbeat_state() is NmtState.PRE_OPERATIONAL
    assert [alarm.emergency for alarm in link.emergencies()] == [fault, fault, fault]
    assert link.emergencies() == ()
    counters = link.counters
    assert (counters.heartbeats_received, counters.emcy_received, counters.emcy_lost) == (1, 3, 6)
    assert counters.frames_dropped == 1, "a state that there is not"


def test_events_after_a_reset_count_from_zero(
    port: ScriptedPort, link: SerialLink, clock: VirtualClock
) -> None:
    fault = Emergency(0x2310, 3, bytes(5))
    port.say(wire.Event(200, 1, fault), wire.Heartbeat(0, 0), wire.Event(0, 1, fault))
    clock.settle()
    assert link.counters.emcy_lost == 0


def test_no_heartbeat_is_an_error_after_its_time(link: SerialLink, clock: VirtualClock) -> None:
    with pytest.raises(NoAnswer, match=r"no heartbeat of node 5 within 0\.3 s"):
        link.wait_heartbeat(0.3)
    assert clock.now_s() == pytest.approx(0.3, abs=0.02)


def test_batches_go_to_who_takes_them_and_his_failure_ends_nothing(
    port: ScriptedPort, objects: Objects, link: SerialLink, clock: VirtualClock
) -> None:
    assert link.configure_stream([0x20300120], 1, 4).schema == 3
    assert port.requests == [wire.Stream(2, 1, 4, 0, (0x20300120,))]
    seen: list[tuple[wire.Batch, float]] = []
    batch = wire.Batch(3, 0, 100, 1, 2, bytes(8))
    port.say(batch)
    clock.settle()
    link.on_batch(lambda each, arrival_s: seen.append((each, arrival_s)))
    clock.wait(0.25)
    port.say(batch)
    clock.settle()
    assert seen == [(batch, 0.25)]

    def fail(each: wire.Batch, arrival_s: float) -> None:
        raise RuntimeError

    link.on_batch(fail)
    port.say(batch)
    assert link.upload(0x2000, 1) == VALUE
    assert link.counters.receive_errors == 1


def test_how_many_records_a_batch_holds(link: SerialLink) -> None:
    assert [link.batch_rows(channels) for channels in (1, 12, 13, 17)] == [12, 1, 0, 0]


# ---- the port goes -----------------------------------------------------------------------------------------


def test_a_port_that_hangs_up_is_told_to_every_caller(
    port: ScriptedPort, objects: Objects, link: SerialLink
) -> None:
    assert link.upload(0x2000, 1) == VALUE
    port.hang_up()
    for call in (
        lambda: link.upload(0x2000, 1),
        lambda: link.download(0x2000, 1, b"\x01"),
        lambda: link.nmt(NmtCommand.START),
        link.send_heartbeat,
        link.heartbeat_state,
        lambda: link.wait_heartbeat(1.0),
        link.emergencies,
        link.configure_stream,
        lambda: link.send_setpoint(0.0, 0.0),
    ):
        with pytest.raises(LinkClosed, match=r"port of node 5 stopped working: .*; check its cable"):
            call()


def test_a_port_that_takes_nothing_is_an_error_and_not_the_end(
    port: ScriptedPort, objects: Objects, link: SerialLink
) -> None:
    port.broken = OSError("write timeout")
    with pytest.raises(LinkError, match="sending to node 5 failed: write timeout; ") as failed:
        link.nmt(NmtCommand.START)
    assert not isinstance(failed.value, LinkClosed)
    port.broken = None
    assert link.upload(0x2000, 1) == VALUE


def test_a_closed_link_says_so(port: ScriptedPort, clock: VirtualClock) -> None:
    link = SerialLink(port, NODE, clock)
    link.close()
    link.close()
    assert port.closed == 1
    with pytest.raises(LinkClosed, match="the link to node 5 is closed"):
        link.upload(0x2000, 1)
