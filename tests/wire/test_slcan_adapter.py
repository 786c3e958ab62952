"""The emulated serial CAN adapter, line by line (LAWICEL CANUSB manual), and without a reader."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator

import can
import pytest
from hypothesis import given, strategies as st

from benchtool.emulator.ports.pty import HungUp, PtyPort
from benchtool.emulator.servers.acceptance import ACCEPT_ALL, accepts
from benchtool.emulator.servers.slcan import SlcanAdapter
from benchtool.link.port import PyserialPort
from benchtool.protocol.slcan import AdapterLines, Cause, SlcanFrame, parse_command
from tests.wire.endpoints import frame
from tests.wire.slcan_endpoints import READS, StuckPort, Terminal


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    opened = Terminal()
    yield opened
    opened.close()


@pytest.fixture
def channel(terminal: Terminal) -> Terminal:
    """A terminal with its channel open."""
    assert [terminal.ask("S6"), terminal.ask("O")] == [b"\r", b"\r"]
    return terminal


class TestCommands:
    def test_a_channel_opens_once_its_bit_rate_is_set(self, terminal: Terminal) -> None:
        assert terminal.ask("O") == b"\a"
        assert terminal.ask("L") == b"\a"
        assert terminal.ask("S6") == b"\r"
        assert terminal.adapter.bitrate == 500_000
        for line, answer, is_open in (("O", b"\r", True), ("C", b"\r", False), ("C", b"\a", False)):
            assert terminal.ask(line) == answer
            assert terminal.adapter.is_open is is_open

    def test_registers_set_the_bit_rate_as_well(self, terminal: Terminal) -> None:
        assert terminal.ask("s031C") == b"\r"
        assert terminal.ask("O") == b"\r"
        assert terminal.adapter.bitrate is None

    @pytest.mark.parametrize("line", ["S5", "s031C", "Z1", "O", "L", "M00000000", "m00000000"])
    def test_settings_are_refused_while_the_channel_is_open(self, channel: Terminal, line: str) -> None:
        assert channel.ask(line) == b"\a"
        assert channel.adapter.bitrate == 500_000
        assert channel.adapter.malformed == {}

    @pytest.mark.parametrize("line", ["F", "t1230", "T000001230", "r1230", "R000001230", "C"])
    def test_what_needs_an_open_channel_is_refused_while_it_is_closed(
        self, terminal: Terminal, line: str
    ) -> None:
        terminal.ask("S6")
        assert terminal.ask(line) == b"\a"
        assert terminal.adapter.malformed == {}

    def test_the_filter_is_refused_before_the_bit_rate(self, terminal: Terminal) -> None:
        assert terminal.ask("M00000000") == b"\a"
        terminal.ask("S6")
        assert terminal.ask("M00000000") == b"\r"

    def test_it_says_who_it_is_open_or_closed(self, terminal: Terminal) -> None:
        for _ in range(2):
            assert terminal.ask("V") == b"V1010\r"
            assert terminal.ask("N") == b"NBT01\r"
            terminal.ask("S6")
            terminal.ask("O")

    @pytest.mark.parametrize(
        ("line", "cause"),
        [
            ("t12", Cause.LENGTH),
            ("t1239" + "00" * 9, Cause.DLC),
            ("t8000", Cause.IDENTIFIER),
            ("d1230", Cause.UNSUPPORTED),
            ("A", Cause.LETTER),
            ("0" * 300, Cause.TOO_LONG),
        ],
    )
    def test_a_malformed_line_is_refused_and_counted(
        self, channel: Terminal, line: str, cause: Cause
    ) -> None:
        assert channel.ask(line) == b"\a"
        assert channel.adapter.malformed == {cause: 1}
        assert channel.ask("t1230") == b"z\r"

    def test_a_line_of_nothing_is_refused_and_no_error(self, terminal: Terminal) -> None:
        assert terminal.ask("") == b"\a"
        assert terminal.adapter.malformed == {}

    def test_an_adapter_that_never_answers(self) -> None:
        silent = Terminal(acknowledge=False)
        assert [silent.type(b"S6\rO\rV\rt12\r"), silent.read(1)] == [[], b""]
        assert [f.arbitration_id for f in silent.type(b"t1230\r")] == [0x123]
        silent.adapter.send(frame(0x181, "AB"))
        assert silent.read(7) == b"t1811AB\r"
        silent.close()

    def test_a_bit_rate_set_beforehand_needs_no_command(self) -> None:
        ready = Terminal(bitrate=250_000)
        assert ready.ask("O") == b"\r"
        assert ready.adapter.bitrate == 250_000
        ready.close()


class TestFrames:
    def test_the_hosts_frames_arrive_and_are_acknowledged_by_their_kind(self, channel: Terminal) -> None:
        got = channel.type(b"t1232ABcd\rT000001231FF\rr1234\rR000001238\n\r")
        assert channel.read(8) == b"z\rZ\rz\rZ\r"
        assert [
            (f.arbitration_id, bytes(f.data), f.dlc, f.is_extended_id, f.is_remote_frame) for f in got
        ] == [
            (0x123, b"\xab\xcd", 2, False, False),
            (0x123, b"\xff", 1, True, False),
            (0x123, b"", 4, False, True),
            (0x123, b"", 8, True, True),
        ]

    def test_the_drives_frames_go_nowhere_before_the_channel_is_open_and_after(
        self, terminal: Terminal
    ) -> None:
        terminal.adapter.send(frame(0x181, "01"))
        terminal.ask("S6")
        terminal.adapter.send(frame(0x181, "02"))
        assert terminal.ask("O") == b"\r"
        terminal.adapter.send(frame(0x181, "03"))
        assert terminal.read(8) == b"t181103\r"
        assert terminal.ask("C") == b"\r"
        terminal.adapter.send(frame(0x181, "04"))
        assert terminal.read(1) == b""
        assert terminal.adapter.dropped == 0

    def test_listening_only_takes_and_never_gives(self, terminal: Terminal) -> None:
        terminal.ask("S6")
        assert terminal.ask("L") == b"\r"
        assert terminal.type(b"t1230\r") == []
        assert terminal.read(1) == b"\a"
        terminal.adapter.send(frame(0x181, "03"))
        assert terminal.read(8) == b"t181103\r"

    def test_time_stamps_are_the_drives_time_modulo_a_minute(self, terminal: Terminal) -> None:
        assert [terminal.ask(line) for line in ("S6", "Z1", "O")] == [b"\r"] * 3
        for now_s, stamp in ((0.29, b"0122"), (59.999, b"EA5F"), (60.0, b"0000"), (3661.5, b"05DC")):
            terminal.adapter.send(frame(0x181, "AB", timestamp=now_s))
            assert terminal.read(12) == b"t1811AB" + stamp + b"\r"
        assert [terminal.ask(line) for line in ("C", "Z0", "O")] == [b"\r"] * 3
        terminal.adapter.send(frame(0x181, "AB", timestamp=1.0))
        assert terminal.read(8) == b"t1811AB\r"

    def test_the_acceptance_filter_holds_frames_back(self, terminal: Terminal) -> None:
        # Only 0x181: identifier in the upper 11 bits of both filters, everything below is irrelevant.
        assert [terminal.ask(line) for line in ("S6", "M30203020", "m001F001F", "O")] == [b"\r"] * 4
        terminal.adapter.send(frame(0x182, "01"))
        terminal.adapter.send(frame(0x181, "02"))
        assert terminal.read(8) == b"t181102\r"
        assert terminal.adapter.dropped == 0

    @pytest.mark.parametrize(
        "bad",
        [
            can.Message(arbitration_id=1, data=bytes(12), dlc=12, is_fd=True),
            can.Message(is_error_frame=True),
            can.Message(arbitration_id=0x800, is_extended_id=False),
        ],
    )
    def test_a_frame_that_no_line_can_say_is_an_error(self, channel: Terminal, bad: can.Message) -> None:
        with pytest.raises(can.CanOperationError):
            channel.adapter.send(bad)

    @given(st.lists(st.binary(max_size=60)))
    def test_nothing_that_is_typed_raises(self, pieces: list[bytes]) -> None:
        typed = Terminal(bitrate=500_000)
        try:
            for piece in pieces:
                typed.type(piece)
            typed.type(b"\r")
            typed.ask("C")
            typed.ask("O")
            assert [f.arbitration_id for f in typed.type(b"t1230\r")] == [0x123]
        finally:
            typed.close()


class TestAcceptance:
    @given(st.integers(0, 0x1FFFFFFF), st.binary(max_size=8), st.booleans(), st.booleans())
    def test_after_power_up_everything_passes(
        self, can_id: int, data: bytes, extended: bool, remote: bool
    ) -> None:
        can_id = can_id if extended else can_id & 0x7FF
        assert accepts(*ACCEPT_ALL, SlcanFrame(can_id, b"" if remote else data, len(data), extended, remote))

    @pytest.mark.parametrize(
        ("code", "mask", "candidate", "passes"),
        [
            (0x30203040, 0x000F000F, SlcanFrame(0x181, b"\x01", 1), True),  # first filter
            (0x30203040, 0x000F000F, SlcanFrame(0x182, b"\x01", 1), True),  # second filter
            (0x30203040, 0x000F000F, SlcanFrame(0x183, b"\x01", 1), False),
            (0x30203040, 0x000F000F, SlcanFrame(0x181, b"", 0, remote=True), False),  # remote bit
            (0x302A3045, 0x00000000, SlcanFrame(0x181, b"\xa5", 1), True),  # first data byte
            (0x302A3045, 0x00000000, SlcanFrame(0x181, b"\xa4", 1), False),
            (0x302A3045, 0x00000000, SlcanFrame(0x181, b"\x55", 1), False),
            (0x302A3045, 0x00000000, SlcanFrame(0x181, b"", 0), True),  # none there to compare
            (0x302A3045, 0x00000000, SlcanFrame(0x182, b"\x77", 1), True),  # not in the second filter
            (0x91A20000, 0x00000000, SlcanFrame(0x12345678, b"", 0, extended=True), True),
            (0x91A20000, 0x00000000, SlcanFrame(0x12347678, b"", 0, extended=True), False),
            (0x91A20000, 0x00000000, SlcanFrame(0x00000001, b"", 0, extended=True), True),
        ],
    )
    def test_two_filters_of_identifier_remote_bit_and_first_byte(
        self, code: int, mask: int, candidate: SlcanFrame, passes: bool
    ) -> None:
        assert accepts(code, mask, candidate) is passes


class TestWithoutAReader:
    """On a pseudo-terminal, whose buffer is the kernel's."""

    @pytest.fixture
    def port(self) -> PtyPort:
        return PtyPort()

    @pytest.fixture
    def adapter(self, port: PtyPort) -> Iterator[SlcanAdapter]:
        opened = SlcanAdapter(port, waiting=100)
        yield opened
        opened.shutdown()

    def open_channel(self, client: PyserialPort, adapter: SlcanAdapter) -> None:
        client.write(b"S6\rO\r")
        until(adapter, lambda: adapter.is_open)
        heard = b""
        while heard != b"\r\r":
            heard += client.read()

    def test_frames_are_dropped_counted_and_flagged_and_nothing_waits(
        self, port: PtyPort, adapter: SlcanAdapter
    ) -> None:
        client = PyserialPort(port.path)
        self.open_channel(client, adapter)
        for number in range(5000):
            adapter.send(frame(0x181, f"{number:08X}"))
        assert adapter.dropped > 3000
        lines = AdapterLines()
        received = []
        while data := client.read():
            received += lines.feed(data)[0]
        assert len(received) + adapter.dropped == 5000
        assert lines.malformed == {}
        numbers = [int.from_bytes(each.data, "big") for each in received]
        assert numbers == sorted(set(numbers))
        for flags in (b"F09\r", b"F00\r"):
            client.write(b"F\r")
            answer = b""
            while not answer:  # what is written to a pseudo-terminal takes its time to the other end
                assert adapter.recv(0.0) is None
                answer = client.read()
            assert answer == flags
        client.close()

    def test_answers_do_not_pile_up(self) -> None:
        port = PtyPort()
        adapter = SlcanAdapter(port, waiting=10)
        client = PyserialPort(port.path)
        for _ in range(200):
            client.write(b"V\r" * 200)
            until(adapter, lambda: True)
        assert len(adapter._outgoing) <= 10 + 64
        client.close()
        adapter.shutdown()

    def test_power_off_with_a_full_buffer_is_quick(self, port: PtyPort, adapter: SlcanAdapter) -> None:
        client = PyserialPort(port.path)
        self.open_channel(client, adapter)
        for _ in range(5000):
            adapter.send(frame(0x181, "00" * 8))
        adapter.shutdown()
        client.close()

    def test_a_client_that_hangs_up_closes_the_channel_and_leaves_nothing_to_the_next(
        self, port: PtyPort, adapter: SlcanAdapter
    ) -> None:
        client = PyserialPort(port.path)
        self.open_channel(client, adapter)
        for _ in range(5000):
            adapter.send(frame(0x181, "00" * 8))
        client.close()
        until(adapter, lambda: not adapter.is_open)
        assert adapter.bitrate is None
        adapter.send(frame(0x181, "00" * 8))
        # Not by pyserial, which empties the buffer when it opens.
        terminal = os.open(port.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        with pytest.raises(BlockingIOError):
            os.read(terminal, 1)
        os.write(terminal, b"V\r")
        until(adapter, lambda: True)
        os.set_blocking(terminal, True)
        assert os.read(terminal, 100) == b"V1010\r"
        os.close(terminal)

    def test_what_waits_for_a_client_is_gone_with_it(self) -> None:
        port = StuckPort()
        adapter = SlcanAdapter(port, bitrate=500_000)
        adapter._answer(adapter._handle(parse_command(b"O"), is_empty=False))
        assert port.writing.wait(5.0)
        for _ in range(100):
            adapter.send(frame(0x181, "00"))
        assert len(adapter._outgoing) == 100
        assert adapter.recv(0.0) is None
        assert len(adapter._outgoing) == 0
        adapter.shutdown()

    def test_half_a_line_is_gone_with_its_client(self, port: PtyPort, adapter: SlcanAdapter) -> None:
        client = PyserialPort(port.path)
        client.write(b"S6\rO\rt12")
        until(adapter, lambda: adapter.is_open)
        client.close()
        until(adapter, lambda: not adapter.is_open)
        client = PyserialPort(port.path)
        self.open_channel(client, adapter)
        assert adapter.malformed == {}
        client.close()

    def test_a_port_that_is_gone_ends_the_adapter_and_not_the_drive(self) -> None:
        terminal = Terminal(bitrate=500_000)
        terminal.ask("O")
        terminal.hang_up()
        with pytest.raises(can.CanOperationError, match="slcan adapter has lost its port: the other end"):
            terminal.adapter.recv(0.0)
        terminal.adapter.send(frame(0x181, "00"))
        assert terminal.adapter.dropped == 1
        with pytest.raises(can.CanOperationError, match="lost its port"):
            terminal.adapter.recv(0.0)
        terminal.close()
        terminal.close()

    def test_a_port_says_that_it_was_closed(self, port: PtyPort) -> None:
        port.close()
        port.close()
        for call in (port.read, lambda: port.write(b"x")):
            with pytest.raises(OSError, match="was closed"):
                call()

    def test_a_port_without_client_takes_nothing(self, port: PtyPort) -> None:
        with pytest.raises(HungUp):
            port.write(b"x")
        assert port.read() == b""
        port.close()


def until(adapter: SlcanAdapter, holds: Callable[[], bool]) -> None:
    """Have the adapter receive until something holds."""
    for _ in range(READS):
        adapter.recv(0.0)
        if holds():
            return
    raise AssertionError("it never came to pass")
