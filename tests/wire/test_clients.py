"""Clients of a wire who come and go: the TCP port they do it at, and what the drive makes of it."""

from __future__ import annotations

import socket
import struct
import threading
from collections.abc import Iterator

import pytest

from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.ports.client import HungUp
from benchtool.emulator.ports.tcp import TcpPort
from benchtool.emulator.servers.transmitter import QueuedTransmitter
from benchtool.protocol import serial as wire
from benchtool.protocol.canopen.abort import Abort
from tests.wire.raw_host import TABLE, RawHost, mapping

READS = 200
STREAM = wire.Stream(1, stride=10, batch=4, mappings=(mapping("torque"),))


@pytest.fixture
def port() -> Iterator[TcpPort]:
    opened = TcpPort()
    yield opened
    opened.close()


def connect(port: TcpPort) -> socket.socket:
    client = socket.create_connection(port.address, 5.0)
    client.settimeout(5.0)
    return client


def received(port: TcpPort) -> bytes:
    """What comes next."""
    for _ in range(READS):
        if data := port.read():
            return data
    raise AssertionError("nothing came")


def hung_up(port: TcpPort) -> None:
    """Return when the port has told so."""
    with pytest.raises(HungUp):
        received(port)


class TestTcpPort:
    def test_it_is_for_this_computer_only_unless_told_otherwise(self, port: TcpPort) -> None:
        assert port.address[0] == "127.0.0.1"
        everywhere = TcpPort("0.0.0.0")
        assert everywhere.address[0] == "0.0.0.0"
        everywhere.close()

    def test_bytes_go_both_ways(self, port: TcpPort) -> None:
        with connect(port) as client:
            client.sendall(b"there")
            assert received(port) == b"there"
            port.write(b"and back")
            assert client.recv(100) == b"and back"

    def test_clients_come_and_go(self, port: TcpPort) -> None:
        for number in range(5):
            with connect(port) as client:
                client.sendall(bytes([number]))
                assert received(port) == bytes([number])
            hung_up(port)
            assert port.read() == b"", "it is told once"
            with pytest.raises(HungUp, match="no client"):
                port.write(b"without a client")

    def test_a_second_client_is_turned_away_and_the_first_does_not_notice(self, port: TcpPort) -> None:
        with connect(port) as client, connect(port) as second:
            client.sendall(b"first")
            assert received(port) == b"first"
            assert port.read() == b""
            assert second.recv(100) == b""
            client.sendall(b"still here")
            assert received(port) == b"still here"

    def test_one_that_comes_when_the_first_has_gone_is_taken(self, port: TcpPort) -> None:
        first = connect(port)
        first.sendall(b"first")
        assert received(port) == b"first"
        first.close()
        with connect(port) as second:
            second.sendall(b"second")
            hung_up(port)
            assert received(port) == b"second"

    def test_a_connection_that_breaks_is_a_client_that_hung_up(self, port: TcpPort) -> None:
        client = connect(port)
        client.sendall(b"x")
        received(port)
        # A linger time of zero resets the connection.
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        client.close()
        hung_up(port)

    @pytest.mark.parametrize("ending", ["the client goes", "the port is closed"])
    def test_a_write_to_one_who_does_not_read_ends(self, port: TcpPort, ending: str) -> None:
        client = connect(port)
        client.sendall(b"x")
        received(port)
        outcome: list[OSError] = []

        def write() -> None:
            try:
                while True:
                    port.write(bytes(1 << 20))
            except OSError as reason:
                outcome.append(reason)

        thread = threading.Thread(target=write)
        thread.start()
        if ending == "the client goes":
            client.close()
            hung_up(port)
        else:
            port.close()
        thread.join(5.0)
        client.close()
        assert isinstance(outcome[0], HungUp) == (ending == "the client goes")

    def test_a_closed_port_says_so(self, port: TcpPort) -> None:
        port.close()
        port.close()
        for use in (port.read, lambda: port.write(b"x")):
            with pytest.raises(OSError, match="was closed"):
                use()


class TestSerialServer:
    def test_the_stream_of_a_client_that_left_is_free_for_the_next(self, bench: EmulatedBench) -> None:
        one, other = RawHost(bench), RawHost(bench)
        assert one.ask(STREAM, wire.StreamReply).status == 0
        assert isinstance(other.tell(STREAM)[-1], wire.Reject)
        one.port.depart()
        assert other.ask(STREAM, wire.StreamReply).status == 0
        assert one.lost == [], "the line itself is there"
        assert isinstance(one.tell(STREAM)[-1], wire.Reject)

    def test_what_a_client_began_is_not_the_next_ones(self, bench: EmulatedBench) -> None:
        host = RawHost(bench)
        entry = TABLE.by_name["device_name"]
        opened = host.ask(wire.Open(1, entry.index, entry.sub), wire.OpenReply)
        host.port.depart()
        assert host.ask(wire.Chunks(2, opened.upload, 0, 1), wire.ChunkReply).status == Abort.DEVICE_STATE

    def test_setpoints_are_numbered_from_zero_after_a_client_left(self, bench: EmulatedBench) -> None:
        host = RawHost(bench)
        host.tell(wire.Nmt(1))
        host.tell(wire.Setpoint(1000, 0.0, 1.0))
        host.tell(wire.Setpoint(7, 0.0, 2.0))
        assert host.read("omega_m_command") == 1.0, "an old one"
        host.port.depart()
        host.tell(wire.Setpoint(7, 0.0, 2.0))
        assert host.read("omega_m_command") == 2.0


def test_frames_without_a_client_are_neither_sent_nor_dropped() -> None:
    written: list[bytes] = []
    there = threading.Event()
    lost: list[OSError] = []
    done = threading.Semaphore(0)

    def write(data: bytes) -> None:
        done.release()
        if not there.is_set():
            raise HungUp("no client")
        written.append(data)

    line = QueuedTransmitter(write, lost.append)
    assert line.send(b"lost")
    assert done.acquire(timeout=5.0)
    there.set()
    assert line.send(b"heard")
    assert done.acquire(timeout=5.0)
    line.close()
    assert (written, lost) == ([b"heard"], [])
    assert (line.sent, line.dropped) == (1, 0)
