"""Ports of the operating system: a pseudo-terminal and a socket, what they carry and how they go."""

from __future__ import annotations

import os
import pty
import socket
import tty
from collections.abc import Iterator

import pytest

from benchtool.clock import RealClock
from benchtool.errors import LinkClosed, LinkError
from benchtool.link.port import Port, PyserialPort, SocketPort, open_port
from benchtool.link.serial.link import SerialLink

EVERY_BYTE = bytes(range(256)) * 8


class Master:
    """The other end of a pseudo-terminal."""

    def __init__(self) -> None:
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        self.name = os.ttyname(self._slave)
        self._open = True

    def write(self, data: bytes) -> None:
        os.write(self._master, data)

    def read(self, size: int) -> bytes:
        return os.read(self._master, size)

    def hang_up(self) -> None:
        if self._open:
            self._open = False
            os.close(self._slave)
            os.close(self._master)


@pytest.fixture
def master() -> Iterator[Master]:
    opened = Master()
    yield opened
    opened.hang_up()


def _read(port: Port, size: int) -> bytes:
    data = b""
    while len(data) < size:
        data += port.read()
    return data


def test_a_terminal_carries_every_byte_both_ways(master: Master) -> None:
    port = open_port(master.name)
    try:
        master.write(EVERY_BYTE)
        assert _read(port, len(EVERY_BYTE)) == EVERY_BYTE
        assert port.read() == b""
        port.write(EVERY_BYTE[:1024])
        assert master.read(4096) == EVERY_BYTE[:1024]
    finally:
        port.close()
        port.close()


def test_a_read_returns_all_that_has_come(master: Master) -> None:
    port = PyserialPort(master.name)
    try:
        master.write(bytes(1000))
        assert len(_read(port, 1)) + len(port.read()) == 1000
    finally:
        port.close()


def test_a_terminal_that_hangs_up_is_gone(master: Master) -> None:
    port = PyserialPort(master.name)
    try:
        master.hang_up()
        with pytest.raises(OSError):  # noqa: PT011  the system's own words
            _read(port, 1)
        with pytest.raises(OSError):  # noqa: PT011
            port.write(b"x")
    finally:
        port.close()
    with pytest.raises(OSError):  # noqa: PT011
        port.read()


def test_a_link_says_that_its_terminal_is_gone(master: Master) -> None:
    clock = RealClock()
    with SerialLink(PyserialPort(master.name), 1, clock) as link:
        master.hang_up()
        with pytest.raises(LinkClosed, match="serial port of node 1 stopped working"):
            link.upload(0x2000, 1)


def test_a_write_to_an_unread_terminal_fails_after_a_second(master: Master) -> None:
    port = PyserialPort(master.name)
    try:
        with pytest.raises(OSError, match="timeout"):
            for _ in range(100):
                port.write(bytes(4096))
    finally:
        port.close()


def test_a_port_is_opened_once(master: Master) -> None:
    port = open_port(master.name)
    try:
        with pytest.raises(LinkError, match="another program has it open: close that program"):
            open_port(master.name)
    finally:
        port.close()


def test_a_socket_carries_bytes_and_its_end_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = open_port(f"socket://127.0.0.1:{server.getsockname()[1]}")
        assert isinstance(port, SocketPort)
        peer, _ = server.accept()
        with peer:
            peer.sendall(EVERY_BYTE)
            assert _read(port, len(EVERY_BYTE)) == EVERY_BYTE
            assert port.read() == b""
            port.write(b"answer")
            assert peer.recv(100) == b"answer"
        with pytest.raises(OSError, match="the other end closed the connection"):
            _read(port, 1)
        port.close()
        with pytest.raises(OSError, match="closed"):
            port.read()


def test_a_connection_that_is_closed_with_bytes_unread_is_told_alike() -> None:
    """The system then resets it."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = open_port(f"socket://127.0.0.1:{server.getsockname()[1]}")
        peer, _ = server.accept()
        port.write(b"unread")
        assert peer.recv(1, socket.MSG_PEEK) == b"u"
        peer.close()
        with pytest.raises(OSError, match="the other end closed the connection"):
            _read(port, 1)
        port.close()


@pytest.mark.parametrize(
    ("url", "remedy"),
    [
        ("/dev/ttyNOTHING9", "check that the adapter is plugged in and its name"),
        ("socket://127.0.0.1:1", "check that the serial server runs and its address"),
        ("socket://127.0.0.1", "check the address and the baud rate"),
        ("nonsense://x", "check the address and the baud rate"),
    ],
)
def test_a_port_that_cannot_be_opened_comes_with_a_remedy(url: str, remedy: str) -> None:
    with pytest.raises(LinkError, match=remedy) as refused:
        open_port(url)
    assert str(refused.value).startswith(f"cannot open {url}: ")
    assert "\n" not in str(refused.value)
