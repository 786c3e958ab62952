"""The procedures of `serial.md`, step by step, by a raw host; what the page says of old bytes."""

from __future__ import annotations

import dataclasses
import struct
import zlib
from pathlib import Path

import pytest

from benchtool.clock import VirtualClock
from benchtool.drive import RemoteDrive
from benchtool.emulator.bench import EmulatedBench
from benchtool.errors import DictionaryMismatch
from benchtool.link.serial.link import SerialLink
from benchtool.protocol import serial as wire
from benchtool.protocol.canopen.abort import Abort
from benchtool.protocol.canopen.nmt import NmtState
from benchtool.protocol.capture_data import decode_header
from benchtool.protocol.dictionary import Dictionary
from benchtool.shipped import shipped
from tests.wire.raw_host import HOST, SUPERVISION, TABLE, RawHost, mapping
from tests.wire.scripted_serial import IDENTITY, NODE, ScriptedPort

TARGETS = ("target_torque", "target_velocity", "torque_command", "omega_m_command")


def test_enabling_as_the_page_has_it(raw: RawHost) -> None:
    raw.tell(wire.Nmt(1))
    assert int(raw.read("statusword")) & 0x4F == 0x40
    assert raw.write("host_heartbeat", SUPERVISION) == 0
    for word in (0x06, 0x07):
        assert raw.write("controlword", word) == 0
    assert raw.write("controlword", 0x0F) == Abort.DEVICE_STATE, "supervision waits for a feed"
    raw.tell(wire.HostHeartbeat(HOST, 5))
    assert raw.read("link_state") == 2
    assert raw.write("mode_of_operation", 3) == 0
    for name in TARGETS:
        assert raw.write(name, 0) == 0
        assert raw.read(name) == 0
    for word, state in ((0x06, 0x21), (0x07, 0x23), (0x0F, 0x27)):
        assert raw.write("controlword", word) == 0
        assert int(raw.read("statusword")) & 0x6F == state
    for sequence in range(8):
        raw.tell(wire.Setpoint(sequence, 0.0, 20.0))
        raw.bench.clock.wait(0.1)
    assert raw.read("omega_m") == pytest.approx(20.0, abs=0.5)
    assert raw.write("controlword", 0x00) == 0
    assert int(raw.read("statusword")) & 0x4F == 0x40
    assert raw.read("omega_m_command") == 20.0, "targets outlive disabling"


@pytest.mark.parametrize("word", [0x00, 0x06, 0x07, 0x10F])
def test_a_setpoint_is_kept_in_every_state(raw: RawHost, word: int) -> None:
    raw.enable()
    raw.write("controlword", word)
    raw.tell(wire.Setpoint(1, 0.5, 20.0))
    assert (raw.read("torque_command"), raw.read("omega_m_command")) == (0.5, 20.0)
    raw.tell(wire.Nmt(2), wire.Nmt(1))
    assert (raw.read("torque_command"), raw.read("omega_m_command")) == (0.0, 0.0)


def test_a_capture_as_the_page_has_it(raw: RawHost) -> None:
    assert raw.write("capture_control", 1) == Abort.PARAMETER_INCOMPATIBLE, "no channel"
    data = TABLE.by_name["capture_data"]
    refused = raw.ask(wire.Open(raw.tag(), data.index, data.sub), wire.OpenReply)
    assert refused.status == Abort.DEVICE_STATE
    for name, value in (("capture_channel_1", mapping("tick")), ("capture_channel_2", 0)):
        assert raw.write(name, value) == 0
    assert raw.write("capture_rows", 50) == raw.write("capture_stride", 3) == 0
    assert raw.write("capture_pretrigger", 50) == 0
    assert raw.write("capture_control", 1) == Abort.PARAMETER_INCOMPATIBLE, "as many rows before as there are"
    assert raw.write("capture_pretrigger", 10) == 0
    assert raw.write("capture_trigger", 1) == 0
    assert raw.write("capture_control", 1) == 0
    sequence = raw.read("capture_sequence")
    raw.bench.clock.wait(0.02)
    assert raw.read("capture_state") == 1
    raw.write("omega_m_command", 1.0)
    raw.bench.clock.wait(0.005)
    assert raw.read("capture_state") == 2
    raw.bench.clock.wait(0.02)
    assert raw.read("capture_state") == 3
    opened = raw.ask(wire.Open(raw.tag(), data.index, data.sub), wire.OpenReply)
    replies = raw.tell(wire.Chunks(raw.tag(), opened.upload, 0, -(-opened.size // opened.chunk_size)))
    held = b"".join(each.data for each in replies if isinstance(each, wire.ChunkReply))
    assert zlib.crc32(held) == opened.crc
    header = decode_header(held)
    assert (header.sequence, header.rows, header.stride) == (sequence, 50, 3)
    ticks = struct.unpack("<50L", held[-200:])
    assert ticks == tuple(range(header.first_tick, header.first_tick + 150, 3))


@pytest.mark.parametrize(
    ("upload", "first", "count", "status"),
    [
        (1, 0, 0, Abort.DEVICE_STATE),
        (1, 2**32 - 1, 0xFFFF, Abort.DEVICE_STATE),
        (0, 2**32 - 1, 0, Abort.VALUE_LOW),
        (0, 0, 0, Abort.VALUE_LOW),
        (0, 1, 1, Abort.VALUE_HIGH),
        (0, 0, 2, Abort.VALUE_HIGH),
        (0, 2**32 - 1, 0xFFFF, Abort.VALUE_HIGH),
        (0, 0, 1, 0),
    ],
)
@pytest.mark.parametrize("nmt", [1, 2, 128])
def test_of_several_errors_in_chunks_the_first_of_the_page_is_told(
    raw: RawHost, upload: int, first: int, count: int, status: int, nmt: int
) -> None:
    name = TABLE.by_name["device_name"]
    opened = raw.ask(wire.Open(raw.tag(), name.index, name.sub), wire.OpenReply)
    raw.tell(wire.Nmt(nmt))
    request = wire.Chunks(raw.tag(), opened.upload + upload, first, count)
    answer = raw.ask(request, wire.ChunkReply)
    assert (answer.status, answer.chunk) == (status, first)
    short = wire.encode_frame(wire.encode_message(request)[:-1])
    assert raw.tell(short) == [wire.Reject(request.tag, 0x05, 2)]


class TestOldBytes:
    """What a buffer held back is older than IDENTITY."""

    @pytest.fixture
    def clock(self) -> VirtualClock:
        return VirtualClock()

    @pytest.fixture
    def port(self, clock: VirtualClock) -> ScriptedPort:
        return ScriptedPort(clock)

    def test_the_state_in_identity_is_newer_than_heartbeats_before(
        self, port: ScriptedPort, clock: VirtualClock
    ) -> None:
        port.say(wire.Heartbeat(NmtState.OPERATIONAL, 5), wire.Heartbeat(NmtState.BOOT_UP, 6))
        port.answer = lambda request: (
            [wire.ReadReply(request.tag, 0, request.index, request.sub, b"\x01")]
            if isinstance(request, wire.Read)
            else []
        )
        with SerialLink(port, NODE, clock) as link:
            assert link.upload(0x2000, 1) == b"\x01"
            assert link.heartbeat_state() is NmtState.PRE_OPERATIONAL
            assert link.upload(0x2000, 1) == b"\x01"
            port.say(wire.Heartbeat(NmtState.OPERATIONAL, 7))
            clock.wait(0.01)
            assert link.heartbeat_state() is NmtState.OPERATIONAL

    @pytest.mark.parametrize(("version", "state"), [(9, 5), (1, 77)])
    def test_an_identity_that_cannot_be_read_tells_no_state(
        self, port: ScriptedPort, clock: VirtualClock, version: int, state: int
    ) -> None:
        with SerialLink(port, NODE, clock) as link:
            port.say(dataclasses.replace(IDENTITY, version=version, nmt_state=state))
            clock.wait(0.01)
            assert link.heartbeat_state() is None


def test_a_host_with_another_dictionary_reads_and_does_no_more(bench: EmulatedBench) -> None:
    text = (shipped("firmware_protocol") / "drive.eds").read_text(encoding="utf-8")
    ours = Dictionary.from_bytes(text.encode(), 1, "drive.eds")
    other = Dictionary.from_bytes(text.replace(str(ours.hash), str(1234)).encode(), 1, "other.eds")
    assert ours.hash != other.hash == 1234
    sent: list[wire.Request | wire.Reject | None] = []
    port = bench.host_port()
    heard, write = wire.FrameSplitter(), port.write

    def noting(data: bytes) -> None:
        sent.extend(wire.decode_request(payload) for payload in heard.feed(data))
        write(data)

    port.write = noting  # type: ignore[method-assign]  # a tap
    with SerialLink(port, 1, bench.clock) as link:
        drive = RemoteDrive(link, other, "other.eds", bench.clock)
        with pytest.raises(DictionaryMismatch, match="0x000004D2"), drive:
            drive.connect()
    assert {type(each) for each in sent} == {wire.Identify, wire.Read}
    allowed = {0x1008, 0x1009, 0x100A, 0x1018, 0x2060}
    assert {each.index for each in sent if isinstance(each, wire.Read)} <= allowed


def test_the_page_names_every_part_of_the_vectors() -> None:
    import json

    folder = Path(shipped("firmware_protocol"))
    page = (folder / "serial.md").read_text(encoding="utf-8")
    section = page[page.index("## The vectors") : page.index("## Versions")]
    vectors = json.loads((folder / "serial_vectors.json").read_text(encoding="utf-8"))
    for key, entries in vectors.items():
        assert f"| `{key}` |" in section
        for entry in entries if isinstance(entries, list) else ():
            assert all(f"`{name}`" in section or key == "lines" for name in entry), (key, entry)
