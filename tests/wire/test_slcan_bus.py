"""The host's bus over a serial CAN adapter: opening, receiving through noise, and a lost adapter."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

import can
import pytest
from hypothesis import given, strategies as st

from benchtool.clock import RealClock
from benchtool.errors import LinkClosed, LinkError
from benchtool.link.canopen.link import CanopenLink
from benchtool.link.canopen.slcan import SlcanBus, open_slcan
from benchtool.protocol.slcan import BITRATES_BIT_S, Cause
from tests.fuzz.slcan import fuzz
from tests.wire.endpoints import NODE, frame
from tests.wire.slcan_endpoints import ScriptedPort

CLOSE = [b"", b"", b"", b"C"]


def obedient(line: bytes) -> Iterable[bytes]:
    """Answers of an adapter that has no objections."""
    return {b"": [b"\a"], b"V": [b"V1013\r"], b"N": [b"NA123\r"], b"t": [b"z\r"], b"T": [b"Z\r"]}.get(
        line[:1], [b"\r"]
    )


def refusing(*refused: bytes) -> Callable[[bytes], Iterable[bytes]]:
    return lambda line: [b"\a"] if line in refused else obedient(line)


@pytest.fixture
def port() -> ScriptedPort:
    return ScriptedPort(obedient)


@pytest.fixture
def bus(port: ScriptedPort) -> Iterator[SlcanBus]:
    opened = SlcanBus(port, 500_000, now_s=lambda: 7.5, name="scripted")
    yield opened
    opened.shutdown()


def receive(bus: can.BusABC) -> list[can.Message]:
    received = []
    while (got := bus.recv(0.0)) is not None:
        received.append(got)
    return received


class TestOpening:
    @pytest.mark.parametrize("acknowledged", [None, True, False])
    def test_commands_come_in_the_manuals_order(self, port: ScriptedPort, acknowledged: bool | None) -> None:
        bus = SlcanBus(port, 500_000, acknowledged=acknowledged)
        assert port.lines == [*CLOSE, b"S6", b"O"]
        bus.shutdown()
        assert port.lines[6:] == [b"C"]
        bus.shutdown()
        assert (len(port.lines), port.closed) == (7, 1)

    @pytest.mark.parametrize(("number", "bitrate"), list(enumerate(BITRATES_BIT_S)))
    def test_every_bit_rate_has_its_command(self, port: ScriptedPort, number: int, bitrate: int) -> None:
        SlcanBus(port, bitrate).shutdown()
        assert port.lines[4] == b"S%d" % number

    def test_without_a_bit_rate_the_adapter_keeps_its_own(self, port: ScriptedPort) -> None:
        SlcanBus(port, listen_only=True).shutdown()
        assert port.lines == [*CLOSE, b"L", b"C"]

    @pytest.mark.parametrize("bitrate", [0, 300_000, 750_000, 83_300])
    def test_another_bit_rate_is_an_error_that_names_the_choices(
        self, port: ScriptedPort, bitrate: int
    ) -> None:
        with pytest.raises(can.CanInitializationError, match=f"{bitrate} bit/s .* 10000, 20000, .* 1000000"):
            SlcanBus(port, bitrate)
        assert (port.lines, port.closed) == ([], 1)

    @pytest.mark.parametrize("acknowledged", [None, False])
    def test_an_adapter_that_never_answers_is_opened_all_the_same(
        self, acknowledged: bool | None, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("benchtool.link.canopen.slcan._ANSWER_S", 0.02)
        port = ScriptedPort()
        bus = SlcanBus(port, 500_000, acknowledged=acknowledged, identify=True)
        assert [line for line in port.lines if line] == [b"C", b"V", b"N", b"S6", b"O"]
        assert (bus.version, bus.serial_number) == (None, None)
        port.arriving.put(b"t1230\r")
        assert len(receive(bus)) == 1
        bus.shutdown()

    def test_answers_that_are_insisted_on_are_waited_for_while_the_adapter_starts(self) -> None:
        port = ScriptedPort()
        port.answer = lambda line: obedient(line) if port.lines.count(b"C") > 1 else []
        SlcanBus(port, 500_000, acknowledged=True).shutdown()
        assert port.lines == [*CLOSE, *CLOSE, b"S6", b"O", b"C"]

    def test_answers_that_are_insisted_on_and_do_not_come_are_an_error(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("benchtool.link.canopen.slcan._READY_S", 0.1)
        port = ScriptedPort()
        with pytest.raises(can.CanInitializationError, match=r"answered no command within 0\.1 s; check"):
            SlcanBus(port, 500_000, acknowledged=True)
        assert port.closed == 1

    @pytest.mark.parametrize(
        ("refused", "message"),
        [(b"S6", "refused 500000 bit/s: choose"), (b"O", "refused to open its channel")],
    )
    def test_a_refusal_is_an_error(self, refused: bytes, message: str) -> None:
        port = ScriptedPort(refusing(refused))
        with pytest.raises(can.CanInitializationError, match=message):
            SlcanBus(port, 500_000)
        assert port.closed == 1

    def test_an_adapter_that_falls_silent_while_it_is_opened_is_an_error(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("benchtool.link.canopen.slcan._ANSWER_S", 0.02)
        port = ScriptedPort(lambda line: [] if line == b"S6" else obedient(line))
        with pytest.raises(can.CanInitializationError, match="did not answer the command S6 within"):
            SlcanBus(port, 500_000)

    def test_an_adapter_that_goes_while_it_is_opened_is_an_error(self) -> None:
        port = ScriptedPort(lambda line: [OSError("unplugged")] if line == b"S6" else obedient(line))
        with pytest.raises(can.CanInitializationError, match="adapter is gone: unplugged; check its cable"):
            SlcanBus(port, 500_000)
        assert port.closed == 1

    def test_it_is_asked_who_it_is(self, port: ScriptedPort) -> None:
        bus = SlcanBus(port, identify=True)
        assert (bus.version, bus.serial_number) == ("1013", "A123")
        bus.shutdown()

    def test_what_an_earlier_user_left_is_neither_received_nor_counted(self, port: ScriptedPort) -> None:
        for _ in range(5):
            port.arriving.put(b"t1230\rt12\r\a")
        bus = SlcanBus(port, 500_000)
        assert receive(bus) == []
        assert (bus.frames, bus.malformed, bus.refused) == (0, 0, 0)
        bus.shutdown()

    def test_a_frame_right_behind_the_answer_is_received(self) -> None:
        port = ScriptedPort(lambda line: [b"\rt1230\rt12", b"40\r"] if line == b"O" else obedient(line))
        bus = SlcanBus(port, 500_000)
        assert [each.arbitration_id for each in receive(bus)] == [0x123, 0x124]
        bus.shutdown()

    def test_babble_that_never_ends_does_not_hold_it_up(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("benchtool.link.canopen.slcan._BABBLE_S", 0.05)
        port = ScriptedPort()
        monkeypatch.setattr(port, "read", lambda: b"t1230\r")
        SlcanBus(port, 500_000).shutdown()
        assert port.lines == [*CLOSE, b"S6", b"O", b"C"]

    def test_a_port_that_is_not_there_is_a_link_error(self) -> None:
        with pytest.raises(LinkError, match="cannot open /dev/no-such-adapter: "):
            open_slcan("/dev/no-such-adapter@921600", 500_000)


class TestFrames:
    def test_frames_come_as_they_are_with_the_hosts_time(self, bus: SlcanBus, port: ScriptedPort) -> None:
        port.arriving.put(b"t1232ABcd\rT000001231FF0001\rr1234\rR000001238\r")
        received = receive(bus)
        assert [
            (f.arbitration_id, bytes(f.data), f.dlc, f.is_extended_id, f.is_remote_frame) for f in received
        ] == [
            (0x123, b"\xab\xcd", 2, False, False),
            (0x123, b"\xff", 1, True, False),
            (0x123, b"", 4, False, True),
            (0x123, b"", 8, True, True),
        ]
        assert {(f.timestamp, f.channel, f.is_rx) for f in received} == {(7.5, "scripted", True)}
        assert bus.frames == 4

    def test_noise_is_dropped_and_counted_by_cause(self, bus: SlcanBus, port: ScriptedPort) -> None:
        port.arriving.put(b"t12\rz\rt1230\r\xff\xfe\rt1239\rd1230\r")
        port.arriving.put(b"\a\rZ\rt1240\r")
        assert [each.arbitration_id for each in receive(bus)] == [0x123, 0x124]
        assert bus.malformed == 4
        assert bus.malformed_by_cause == {
            Cause.LENGTH: 1,
            Cause.LETTER: 1,
            Cause.DLC: 1,
            Cause.UNSUPPORTED: 1,
        }
        assert bus.refused == 1

    def test_every_frame_that_the_adapter_refused_is_counted(self, bus: SlcanBus, port: ScriptedPort) -> None:
        port.arriving.put(b"\a" * 40 + b"z\r" * 40)
        assert receive(bus) == []
        assert (bus.refused, bus.malformed) == (40, 0)

    @given(st.lists(st.binary(max_size=100)))
    def test_no_noise_keeps_the_next_frame_out(self, pieces: list[bytes]) -> None:
        port = ScriptedPort()
        bus = SlcanBus(port, acknowledged=False)
        for piece in [*pieces, b"\rt1230\r"]:
            if piece:
                port.arriving.put(piece)
        received: list[can.Message] = []
        while not received or not port.arriving.empty():
            received += receive(bus)
        assert received[-1].arbitration_id == 0x123
        bus.shutdown()

    def test_filters_of_python_can_are_heeded(self, bus: SlcanBus, port: ScriptedPort) -> None:
        bus.set_filters([{"can_id": 0x124, "can_mask": 0x7FF}])
        port.arriving.put(b"t1230\rt1240\rt1250\r")
        assert bus.recv(0.05).arbitration_id == 0x124  # type: ignore[union-attr]

    @pytest.mark.parametrize(
        ("sent", "line"),
        [
            (frame(0x601, "40 00 10 00"), b"t601440001000"),
            (frame(0x12345, "AB", is_extended_id=True), b"T000123451AB"),
            (can.Message(arbitration_id=0x7F, is_remote_frame=True, dlc=3, is_extended_id=False), b"r07F3"),
        ],
    )
    def test_frames_are_sent(self, bus: SlcanBus, port: ScriptedPort, sent: can.Message, line: bytes) -> None:
        bus.send(sent)
        assert port.lines[-1] == line

    @pytest.mark.parametrize(
        ("bad", "message"),
        [
            (can.Message(arbitration_id=1, data=bytes(12), dlc=12, is_fd=True), "no FD"),
            (can.Message(is_error_frame=True), "no error frames"),
            (can.Message(arbitration_id=0x800, is_extended_id=False), "identifier 0x800 is beyond"),
        ],
    )
    def test_what_no_line_can_say_is_an_error(self, bus: SlcanBus, bad: can.Message, message: str) -> None:
        with pytest.raises(can.CanOperationError, match=message):
            bus.send(bad)

    def test_a_listener_does_not_send(self, port: ScriptedPort) -> None:
        bus = SlcanBus(port, 500_000, listen_only=True)
        with pytest.raises(can.CanOperationError, match="only listens"):
            bus.send(frame(0x123, ""))
        bus.shutdown()

    def test_a_line_that_broke_off_is_not_continued_by_the_next(
        self, bus: SlcanBus, port: ScriptedPort
    ) -> None:
        port.write_error = OSError("write timeout")
        with pytest.raises(can.CanOperationError, match="takes nothing: write timeout; check its cable"):
            bus.send(frame(0x123, ""))
        port.write_error = None
        for _ in range(2):
            bus.send(frame(0x124, ""))
        assert port.lines[-3:] == [b"", b"t1240", b"t1240"]


class TestUnderALink:
    def test_a_vanished_adapter_is_a_closed_link(self, bus: SlcanBus, port: ScriptedPort) -> None:
        with CanopenLink(bus, NODE, RealClock(), sdo_timeout_s=0.05) as link:
            port.arriving.put(OSError("device unplugged"))
            port.write_error = OSError("device unplugged")
            with pytest.raises(LinkClosed, match="stopped working: the adapter is gone: device unplugged"):
                link.upload(0x1000, 0)

    def test_an_answer_amid_noise_is_read(self, bus: SlcanBus, port: ScriptedPort) -> None:
        def answer(line: bytes) -> list[bytes]:
            return (
                [b"z\r\xff\xfe#!t58\r", b"t5858430010000102", b"0304\rt12\r"] if line[:4] == b"t605" else []
            )

        port.answer = answer
        with CanopenLink(bus, NODE, RealClock()) as link:
            for _ in range(20):
                assert link.upload(0x1000, 0) == bytes([1, 2, 3, 4])
            assert link.counters.retries == 0
            assert link.counters.receive_errors == 0
            assert link.counters.frames_dropped == 40
        assert bus.malformed == 40


def test_random_streams_break_nothing() -> None:
    outcome = fuzz(seed=1, streams=150)
    assert outcome.frames > 1000
    assert outcome.malformed > 500
