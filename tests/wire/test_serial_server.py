"""The drive on a serial line: every message, invalid messages, and link supervision."""

from __future__ import annotations

import struct
import zlib

import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.servers.serial import MAX_REPLY, MAX_REQUEST
from benchtool.emulator.servers.upload import CHUNK_BYTES
from benchtool.protocol import serial as wire
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.capture_data import decode_header
from benchtool.protocol.modes import Mode
from tests.wire.raw_host import HOST, SUPERVISION, TABLE, RawHost, mapping

START, STOP, PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130
CAPTURE_DATA = TABLE.by_name["capture_data"]


def _heartbeats(replies: list[wire.Reply]) -> list[int]:
    return [each.nmt_state for each in replies if isinstance(each, wire.Heartbeat)]


# ---- requests --------------------------------------------------------------------------------------------


def test_a_drive_that_is_switched_on_announces_itself(bench: EmulatedBench) -> None:
    assert RawHost(bench).hear() == [wire.Heartbeat(0, 0)]
    bench.clock.wait(0.05)
    assert RawHost(bench).hear() == [wire.Heartbeat(127, 500)], "a line that comes later is told the state"


def test_identity_is_that_of_the_dictionary(raw: RawHost) -> None:
    expected = wire.Identity(
        tag=9,
        status=0,
        version=1,
        node_id=1,
        nmt_state=127,
        dictionary_hash=TABLE.hash,
        vendor_id=0xB7C,
        product_code=0x2011,
        revision_number=TABLE.device["revision"],
        serial_number=1,
        tick_period_ns=100_000,
        max_request=MAX_REQUEST,
        max_reply=MAX_REPLY,
        device_name="benchtool reference drive",
    )
    assert raw.tell(wire.Identify(9)) == [expected]
    other = raw.ask(wire.Identify(10, version=2), wire.Identity)
    assert (other.tag, other.status, other.version) == (10, Abort.NOT_STORED, 1)


@pytest.mark.parametrize(
    ("index", "sub", "status"),
    [
        (0x2000, 2, 0),
        (0x5555, 0, Abort.NO_OBJECT),
        (0x2000, 99, Abort.NO_SUB_INDEX),
        (0x2042, 0, Abort.DEVICE_STATE),
    ],
)
def test_reads_are_answered_by_bytes_or_by_the_reason(
    raw: RawHost, index: int, sub: int, status: int
) -> None:
    (answer,) = raw.tell(wire.Read(200, index, sub))
    data = struct.pack("<f", 0.123) if status == 0 else b""
    assert answer == wire.ReadReply(200, status, index, sub, data)


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (struct.pack("<f", 0.2), 0),
        (struct.pack("<f", 200.0), Abort.VALUE_HIGH),
        (struct.pack("<f", float("nan")), Abort.VALUE),
        (b"\x00\x00\x00", Abort.LENGTH_LOW),
        (bytes(5), Abort.LENGTH_HIGH),
    ],
)
def test_writes_are_taken_or_refused_with_the_reason(raw: RawHost, data: bytes, status: int) -> None:
    (answer,) = raw.tell(wire.Write(7, 0x2000, 2, data))
    assert answer == wire.WriteReply(7, status, 0x2000, 2)
    assert raw.read("R_s") == pytest.approx(0.123 if status else 0.2)
    assert raw.write("statusword", 0) == Abort.READ_ONLY


# ---- what is no message ----------------------------------------------------------------------------------

GOOD = wire.encode_frame(wire.encode_message(wire.Read(1, 0x2000, 2)))
LONG_REQUEST = wire.encode_message(wire.Write(1, 0x2000, 2, bytes(MAX_REQUEST)))


def _wrong_crc() -> bytes:
    damaged = bytearray(GOOD)
    damaged[-3] ^= 0x40
    return bytes(damaged)


@pytest.mark.parametrize(
    "data",
    [
        _wrong_crc(),
        b"\x00\x09\x01\x00",
        b"\x00\x04\x01\x02\x03\x00",
        wire.encode_frame(LONG_REQUEST),
        wire.encode_frame(b"\x13\x00"),
        wire.encode_frame(b"\x10\x00"),
        wire.encode_frame(b"\x12\x01\x02"),
        wire.encode_frame(wire.encode_message(wire.Heartbeat(5, 0))),
    ],
    ids=["crc", "stuffing", "too short", "too long", "unknown", "setpoint", "nmt", "of a drive"],
)
def test_what_is_damaged_or_unknown_is_dropped_and_counted(raw: RawHost, data: bytes) -> None:
    assert raw.tell(data) == []
    assert raw.read("serial_dropped") == 1
    assert raw.tell(data + GOOD) != [], "the next frame is understood"
    assert raw.read("serial_dropped") == 2


@pytest.mark.parametrize(
    ("payload", "reject"),
    [
        (b"\x07\x2a", wire.Reject(0x2A, 0x07, 1)),
        (b"\x0f", wire.Reject(0, 0x0F, 1)),
        (b"\x02\x2a\x00\x20", wire.Reject(0x2A, 0x02, 2)),
        (b"\x03\x2a\x00\x20\x02", wire.Reject(0x2A, 0x03, 2)),
        (b"\x01", wire.Reject(0, 0x01, 2)),
        (b"\x06\x2a\x01\x00\x01\x00\x02\x00\x00\x00\x00", wire.Reject(0x2A, 0x06, 2)),
    ],
)
def test_a_whole_request_that_makes_no_sense_is_rejected(
    raw: RawHost, payload: bytes, reject: wire.Reject
) -> None:
    assert raw.tell(wire.encode_frame(payload)) == [reject]
    assert raw.read("serial_dropped") == 1


def test_frames_come_together_from_pieces(raw: RawHost) -> None:
    assert raw.tell(*(bytes([byte]) for byte in GOOD[:-1])) == []
    assert raw.tell(GOOD[-1:] + GOOD[1:] + GOOD[1:5]) == raw.tell(GOOD[5:]) * 2
    assert raw.read("serial_dropped") == 0


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300)
@given(
    st.lists(
        st.binary(max_size=80) | st.builds(wire.encode_frame, st.binary(min_size=1, max_size=40)), max_size=5
    )
)
def test_nothing_that_is_sent_ends_the_server(raw: RawHost, noise: list[bytes]) -> None:
    raw.tell(*noise, b"\x00", wire.encode_frame(wire.encode_message(wire.Nmt(PRE_OPERATIONAL))))
    assert raw.ask(wire.Identify(77), wire.Identity).status == 0
    raw.bench.clock.wait(0.001)


# ---- long objects ----------------------------------------------------------------------------------------


def _capture(host: RawHost, rows: int) -> None:
    host.write("capture_channel_1", mapping("tick"))
    host.write("capture_channel_2", mapping("i_a"))
    host.write("capture_channel_3", 0)
    host.write("capture_rows", rows)
    host.write("capture_control", 1)
    host.bench.clock.wait(rows * 1e-4 + 0.01)


def _open(host: RawHost) -> wire.OpenReply:
    return host.ask(wire.Open(host.tag(), CAPTURE_DATA.index, CAPTURE_DATA.sub), wire.OpenReply)


def _chunks(host: RawHost, upload: int, first: int, count: int) -> list[wire.ChunkReply]:
    return [
        each
        for each in host.tell(wire.Chunks(host.tag(), upload, first, count))
        if isinstance(each, wire.ChunkReply)
    ]


def test_a_long_object_is_read_in_chunks_of_one_moment(raw: RawHost) -> None:
    _capture(raw, 1000)
    refused = raw.ask(wire.Read(1, CAPTURE_DATA.index, CAPTURE_DATA.sub), wire.ReadReply)
    assert (refused.status, refused.data) == (Abort.OUT_OF_MEMORY, b"")
    opened = _open(raw)
    assert (opened.status, opened.size, opened.chunk_size) == (0, 32 + 8000, CHUNK_BYTES)
    count = -(-opened.size // CHUNK_BYTES)
    (missing,) = _chunks(raw, opened.upload, 3, 1)
    _capture(raw, 10)  # the object is another now
    chunks = _chunks(raw, opened.upload, 0, count)
    assert [each.chunk for each in chunks] == list(range(count))
    assert {each.status for each in chunks} == {0}
    data = b"".join(each.data for each in chunks)
    assert (len(data), zlib.crc32(data)) == (opened.size, opened.crc)
    assert decode_header(data).rows == 1000
    assert missing.data == chunks[3].data
    again = _open(raw)
    assert (again.upload, again.size) == (opened.upload + 1, 32 + 80)
    (stale,) = _chunks(raw, opened.upload, 0, 1)
    assert (stale.status, stale.data) == (Abort.DEVICE_STATE, b"")


@pytest.mark.parametrize(
    ("first", "count", "status"),
    [
        (0, 9, Abort.VALUE_HIGH),
        (8, 1, Abort.VALUE_HIGH),
        (2**32 - 1, 1, Abort.VALUE_HIGH),
        (0, 0, Abort.VALUE_LOW),
    ],
)
def test_chunks_beyond_the_end_are_refused_with_one_message(
    raw: RawHost, first: int, count: int, status: int
) -> None:
    _capture(raw, 1000)
    opened = _open(raw)
    (refusal,) = _chunks(raw, opened.upload, first, count)
    assert (refusal.status, refusal.chunk, refusal.data) == (status, first, b"")
    assert len(_chunks(raw, opened.upload, 7, 1)) == 1


def test_an_object_that_cannot_be_read_is_not_opened_and_a_reset_forgets_an_upload(raw: RawHost) -> None:
    assert _open(raw) == wire.OpenReply(raw._tag, Abort.DEVICE_STATE, CAPTURE_DATA.index, CAPTURE_DATA.sub)
    (refusal,) = _chunks(raw, 0, 0, 1)
    assert refusal.status == Abort.DEVICE_STATE
    _capture(raw, 10)
    opened = _open(raw)
    raw.tell(wire.Nmt(RESET_COMMUNICATION))
    (refusal,) = _chunks(raw, opened.upload, 0, 1)
    assert refusal.status == Abort.DEVICE_STATE


# ---- network state, heartbeat, events --------------------------------------------------------------------


def test_every_command_is_confirmed_at_once(raw: RawHost) -> None:
    told = [
        _heartbeats(raw.tell(wire.Nmt(each)))
        for each in (START, START, STOP, PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION)
    ]
    assert told == [[5], [5], [4], [127], [0], [0]]
    assert raw.tell(wire.Nmt(3)) == []
    assert raw.ask(wire.Identify(1), wire.Identity).nmt_state == 127


def test_heartbeats_follow_the_drives_time(raw: RawHost) -> None:
    raw.write("producer_heartbeat", 50)
    raw.bench.clock.wait(0.2)
    assert raw.hear() == [wire.Heartbeat(127, tick) for tick in (500, 1000, 1500, 2000)]
    raw.write("producer_heartbeat", 0)
    raw.bench.clock.wait(0.2)
    assert raw.hear() == []


def test_a_stopped_drive_says_so(raw: RawHost) -> None:
    raw.tell(wire.Nmt(STOP))
    assert raw.write("R_s", 0.2) == Abort.DEVICE_STATE
    assert raw.ask(wire.Read(1, 0x2000, 2), wire.ReadReply) == wire.ReadReply(
        1, Abort.DEVICE_STATE, 0x2000, 2
    )
    assert raw.ask(wire.Stream(1, 1, 1, 0, (mapping("tick"),)), wire.StreamReply).status == Abort.DEVICE_STATE
    assert raw.ask(wire.Identify(1), wire.Identity).nmt_state == 4
    raw.tell(wire.Nmt(PRE_OPERATIONAL))
    assert raw.read("R_s") == pytest.approx(0.123)


@pytest.mark.parametrize("command", [STOP, RESET_NODE])
def test_a_command_that_ends_operation_switches_the_power_stage_off(raw: RawHost, command: int) -> None:
    raw.enable()
    raw.write("omega_m_command", 15.0)
    raw.bench.clock.wait(0.2)
    raw.tell(wire.Nmt(command), wire.Nmt(PRE_OPERATIONAL))
    assert not raw.enabled()
    assert raw.read("omega_m_command") == 0.0
    _is_still(raw)


def _is_still(host: RawHost) -> None:
    """No switch moves."""
    host.bench.clock.wait(0.01)
    switched = host.read("switching_count")
    host.bench.clock.wait(0.02)
    assert host.read("switching_count") == switched


def test_a_fault_is_an_event_with_its_tick(raw: RawHost) -> None:
    raw.enable(Mode.TORQUE)
    raw.write("torque_command", 2.0)
    raw.bench.clock.wait(0.02)
    raw.write("i_trip", 1.0)  # the references keep below a level that was there before them
    raw.bench.clock.wait(0.03)
    (event,) = [each for each in raw.hear() if isinstance(each, wire.Event)]
    assert (event.sequence, event.emergency.code) == (0, 0x2310)
    assert 0 < event.tick < 500
    raw.write("controlword", 0x80)
    raw.bench.clock.wait(0.01)
    raw.write("i_trip", 0.0)
    assert not raw.enabled()


# ---- setpoints -------------------------------------------------------------------------------------------


def _commands(host: RawHost) -> tuple[float, float]:
    return host.read("torque_command"), host.read("omega_m_command")


def test_setpoints_are_taken_in_their_order_and_never_twice(raw: RawHost) -> None:
    raw.tell(wire.Nmt(START))
    raw.tell(wire.Setpoint(0xFFFFFFFE, 0.25, 1.0))
    assert _commands(raw) == (0.25, 1.0)
    raw.tell(wire.Setpoint(1, 0.5, 2.0))
    assert _commands(raw) == (0.5, 2.0), "the sequence wraps"
    for replayed in (1, 0, 0xFFFFFFFE, (1 + 2**31) % 2**32):
        raw.tell(wire.Setpoint(replayed, 0.75, 3.0))
    assert _commands(raw) == (0.5, 2.0)
    assert raw.read("rpdo_dropped") == 4
    raw.tell(wire.Setpoint(2**31, 0.75, 3.0))
    assert _commands(raw) == (0.75, 3.0), "the farthest that is ahead"


def test_a_new_host_starts_afresh(raw: RawHost) -> None:
    raw.tell(
        wire.Nmt(START),
        wire.Setpoint(1000, 0.25, 1.0),
        wire.Identify(1, version=9),
        wire.Setpoint(5, 0.5, 2.0),
    )
    assert _commands(raw) == (0.25, 1.0), "a host of another version is none"
    raw.tell(wire.Identify(1), wire.Setpoint(5, 0.5, 2.0))
    assert _commands(raw) == (0.5, 2.0)


@pytest.mark.parametrize("torque_command", [float("nan"), float("inf"), 0.5])
def test_a_setpoint_is_taken_whole_or_not_at_all(raw: RawHost, torque_command: float) -> None:
    raw.tell(wire.Nmt(START), wire.Setpoint(1, 0.25, 1.0))
    omega_m_command = float("nan") if torque_command == 0.5 else 5.0
    raw.tell(wire.Setpoint(2, torque_command, omega_m_command))
    assert _commands(raw) == (0.25, 1.0)
    assert raw.read("rpdo_dropped") == 1
    raw.tell(wire.Setpoint(2, 0.5, 2.0))
    assert _commands(raw) == (0.5, 2.0), "the number of one that was dropped is not used up"


def test_setpoints_count_in_operational_only(raw: RawHost) -> None:
    raw.tell(
        wire.Setpoint(1, 0.25, 1.0),
        wire.Nmt(START),
        wire.Nmt(STOP),
        wire.Setpoint(2, 0.25, 1.0),
        wire.Nmt(PRE_OPERATIONAL),
    )
    assert _commands(raw) == (0.0, 0.0)
    assert raw.read("rpdo_dropped") == 0
    raw.tell(wire.Nmt(START), wire.Setpoint(1, 0.25, 1.0))
    assert _commands(raw) == (0.25, 1.0)


# ---- link supervision ------------------------------------------------------------------------------------


def _supervised(host: RawHost) -> None:
    host.write("host_heartbeat", SUPERVISION)
    host.tell(wire.HostHeartbeat(HOST, 5))
    host.enable()
    host.write("omega_m_command", 15.0)


@pytest.mark.parametrize("how", ["heartbeat", "setpoint"])
def test_a_host_that_is_heard_keeps_the_motor_running(raw: RawHost, how: str) -> None:
    _supervised(raw)
    for number in range(8):
        raw.bench.clock.wait(0.3)
        raw.tell(wire.HostHeartbeat(HOST, 5) if how == "heartbeat" else wire.Setpoint(number, 0.0, 15.0))
    assert raw.enabled()
    assert raw.read("omega_m") == pytest.approx(15.0, abs=1.0)


OMEGA_M_COMMAND = TABLE.by_name["omega_m_command"]
WRITE_SETPOINT = wire.Write(1, OMEGA_M_COMMAND.index, OMEGA_M_COMMAND.sub, struct.pack("<f", 15.0))


@pytest.mark.parametrize(
    "messages",
    [
        pytest.param((), id="silence"),
        pytest.param((wire.Read(1, 0x2000, 2),), id="reads"),
        pytest.param((WRITE_SETPOINT,), id="writes"),
        pytest.param((wire.Open(1, 0x1008, 0), wire.Chunks(1, 1, 0, 1)), id="uploads"),
        pytest.param((wire.Identify(1, version=2),), id="identify"),
        pytest.param((wire.Nmt(START),), id="nmt"),
        pytest.param((wire.Stream(1, 1, 8, 0, (mapping("tick"),)),), id="stream"),
        pytest.param((wire.HostHeartbeat(HOST - 1, 5),), id="another host"),
        pytest.param((wire.HostHeartbeat(0, 5),), id="host zero"),
        pytest.param((wire.Setpoint(100, 0.0, 15.0),), id="replay"),
        pytest.param((wire.Setpoint(101, 0.0, float("nan")),), id="no number"),
        pytest.param((_wrong_crc(),), id="noise"),
    ],
)
def test_nothing_else_keeps_it_running(raw: RawHost, messages: tuple[wire.Message | bytes, ...]) -> None:
    _supervised(raw)
    raw.tell(wire.Setpoint(100, 0.0, 15.0))
    for _ in range(49):
        raw.bench.clock.wait(0.01)
        raw.tell(*messages)
    assert raw.enabled(), "half a second has not passed"
    for _ in range(3):
        raw.bench.clock.wait(0.01)
        raw.tell(*messages)
    assert not raw.enabled()
    assert raw.read("link_state") == 3
    _is_still(raw)


# ---- a line that ends ------------------------------------------------------------------------------------


def test_a_line_that_is_gone_leaves_the_drive_running_until_the_supervision_ends_it(
    bench: EmulatedBench, raw: RawHost
) -> None:
    observer = RawHost(bench)
    _supervised(raw)
    raw.port.hang_up()
    bench.clock.wait(0.1)
    assert [str(each) for each in raw.lost] == ["unplugged"]
    assert observer.enabled()
    bench.clock.wait(0.5)
    assert not observer.enabled()
    assert observer.lost == []
