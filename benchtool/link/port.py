"""Byte ports, which carry a serial protocol."""

from __future__ import annotations

import os
import select
import socket
from typing import Protocol
from urllib.parse import urlsplit

import serial

from benchtool.errors import LinkError

DEFAULT_BAUDRATE = 921_600
"""The fastest that common USB adapters and microcontrollers both have; ports without a line ignore it."""

READ_S = 0.05
_WRITE_S = 1.0
_CONNECT_S = 3.0
_MOST = 1 << 16


class Port(Protocol):
    """A stream of bytes both ways; one thread reads, and one at a time writes."""

    def read(self) -> bytes:
        """Return the received bytes; wait up to 50 ms for the first, and return none if none comes.

        Raises:
            OSError: the port is gone.
        """

    def write(self, data: bytes) -> None:
        """Send all of it.

        Raises:
            OSError: the port is gone, or takes nothing for a second.
        """

    def close(self) -> None:
        """Close the port; a second call does nothing."""


class PyserialPort:
    """A serial adapter, a pseudo-terminal or any other URL of pyserial, locked against a second opener.

    Args:
        url: as `serial.serial_for_url` takes it: `/dev/ttyUSB0`, `COM3`, `/dev/pts/4`, `rfc2217://...`.
        baudrate: in bit/s; 8 data bits, no parity, 1 stop bit, no flow control.

    Raises:
        OSError: it cannot be opened.
        ValueError: the URL or the baud rate cannot be.
    """

    def __init__(self, url: str, baudrate: int = DEFAULT_BAUDRATE) -> None:
        self._serial = serial.serial_for_url(
            url, baudrate=baudrate, timeout=READ_S, write_timeout=_WRITE_S, exclusive=True
        )

    def read(self) -> bytes:
        """See `Port.read`."""
        try:
            # By itself, read(n) would wait for all n.
            data: bytes = self._serial.read(self._serial.in_waiting or 1)
            if len(data) == 1 and (more := self._serial.in_waiting):
                data += self._serial.read(more)
        except TypeError as reason:  # pyserial's word for a descriptor that was closed meanwhile
            raise OSError("the port was closed") from reason
        return data

    def write(self, data: bytes) -> None:
        """See `Port.write`."""
        try:
            self._serial.write(data)
        except TypeError as reason:
            raise OSError("the port was closed") from reason

    def close(self) -> None:
        """See `Port.close`."""
        self._serial.close()


class SocketPort:
    """Raw bytes over TCP, as serial servers offer them.

    pyserial's own `socket://` tells whether something waits, not how much, and would be read byte by byte.

    Args:
        host: name or address.
        port: number of the TCP port.

    Raises:
        OSError: the connection is refused.
    """

    def __init__(self, host: str, port: int) -> None:
        self._socket = socket.create_connection((host, port), _CONNECT_S)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._socket.settimeout(_WRITE_S)

    def read(self) -> bytes:
        """See `Port.read`."""
        try:
            ready, _, _ = select.select([self._socket], [], [], READ_S)
        except ValueError as reason:  # the descriptor of a closed socket is -1
            raise OSError("the connection was closed") from reason
        if not ready:
            return b""
        try:
            data = self._socket.recv(_MOST)
        except ConnectionResetError:  # closed while bytes of this end were on their way
            data = b""
        if not data:
            raise OSError("the other end closed the connection")
        return data

    def write(self, data: bytes) -> None:
        """See `Port.write`."""
        self._socket.sendall(data)

    def close(self) -> None:
        """See `Port.close`."""
        self._socket.close()


def open_port(url: str, baudrate: int = DEFAULT_BAUDRATE) -> Port:
    """Return the port behind a URL: `socket://HOST:PORT`, or one of pyserial's.

    Raises:
        LinkError: it cannot be opened.
    """
    try:
        if url.startswith("socket://"):
            place = urlsplit(url)
            if not place.hostname or place.port is None:
                raise ValueError("socket://HOST:PORT is expected")
            return SocketPort(place.hostname, place.port)
        return PyserialPort(url, baudrate)
    except (OSError, ValueError) as reason:
        raise LinkError(f"cannot open {url}: {_cause(reason)}; {_remedy(url, reason)}") from None


def _cause(reason: Exception) -> str:
    """Return the system's words for a failure once: pyserial repeats them, with the port and the number."""
    if isinstance(reason, OSError) and reason.errno and "could not open port" in str(reason):
        return os.strerror(reason.errno)
    return str(reason)


def _remedy(url: str, reason: Exception) -> str:
    text = str(reason)
    if isinstance(reason, ValueError):
        return "check the address and the baud rate"
    if url.startswith("socket://"):
        return "check that the serial server runs and its address"
    if "Permission" in text or "denied" in text:
        return "your user needs access to it: join its group (often dialout), or close what else has it open"
    if "lock" in text or "busy" in text:
        return "another program has it open: close that program"
    return "check that the adapter is plugged in and its name"
