"""A TCP port as a byte port, like a serial server on the network, for one client at a time."""

from __future__ import annotations

import select
import socket
import threading
from contextlib import suppress

from benchtool.emulator.ports.client import HungUp
from benchtool.emulator.ports.share import MOST_B, Share
from benchtool.link import READ_S

_WRITE_POLL_S = 0.05
_PATIENCE_s = 5


class TcpPort:
    """A listening socket and the connection of the client who is there.

    A second client is refused: its connection is accepted and closed. A client whose computer vanished is
    dropped after some seconds, where the system detects it.

    Args:
        host: address to listen at; loopback is not reached from other computers.
        port: number of the TCP port; 0 for one that is free.

    Raises:
        OSError: the address is not this computer's, or the port is taken.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0) -> None:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self._listener = socket.create_server((host, port), family=family)
        self._listener.setblocking(False)
        self._client: socket.socket | None = None
        self._closing = threading.Event()
        self._share = Share()
        self._reading = threading.Lock()
        self._writing = threading.Lock()
        self.address: tuple[str, int] = self._listener.getsockname()[:2]
        """Where it listens."""

    def read(self) -> bytes:
        """See `Port.read`.

        Raises:
            HungUp: once, for each client that has gone.
            OSError: the port is closed.
        """
        with self._reading:
            self._require_open()
            if pause_s := self._share.pause_s():
                self._closing.wait(min(pause_s, READ_S))
                return b""
            client = self._client
            watched = [self._listener] if client is None else [self._listener, client]
            ready, _, _ = select.select(watched, [], [], READ_S)
            # Read the data of the present client to the end before another is accepted.
            if client is not None and client in ready:
                return self._hear(client)
            if ready:
                self._accept()
            return b""

    def write(self, data: bytes) -> None:
        """See `Port.write`; waits for a client that does not read, until it does or hangs up.

        Raises:
            HungUp: there is no client; the data are lost.
            OSError: the port is closed.
        """
        with self._writing:
            self._require_open()
            client = self._client
            if client is None:
                raise HungUp("there is no client")
            left = memoryview(data)
            while left:
                self._require_open()
                _, ready, _ = select.select([], [client], [], _WRITE_POLL_S)
                try:
                    taken = client.send(left) if ready else 0
                except BlockingIOError:
                    continue
                except OSError as reason:
                    raise HungUp(f"the client hung up: {reason}") from reason
                left = left[taken:]

    def close(self) -> None:
        """See `Port.close`; waits for a read or write under way, which end at once."""
        self._closing.set()
        with self._reading, self._writing:
            self._listener.close()
            if self._client is not None:
                self._client.close()
                self._client = None

    def _accept(self) -> None:
        try:
            accepted, _ = self._listener.accept()
        except OSError:  # it has gone again
            return
        if self._client is not None:
            accepted.close()
            return
        accepted.setblocking(False)
        accepted.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        accepted.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        for name, value in (
            ("TCP_KEEPIDLE", _PATIENCE_s),
            ("TCP_KEEPINTVL", 1),
            ("TCP_KEEPCNT", _PATIENCE_s),
            ("TCP_USER_TIMEOUT", _PATIENCE_s * 1000),
        ):
            if (option := getattr(socket, name, None)) is not None:  # they are not of every system
                accepted.setsockopt(socket.IPPROTO_TCP, option, value)
        self._client = accepted

    def _hear(self, client: socket.socket) -> bytes:
        try:
            data = client.recv(MOST_B)
        except BlockingIOError:
            return b""
        except OSError:
            data = b""
        if data:
            self._share.handed_over()
            return data
        with suppress(OSError):
            client.shutdown(socket.SHUT_RDWR)  # a write under way ends
        with self._writing:
            self._client = None
            client.close()
        raise HungUp("the client hung up")

    def _require_open(self) -> None:
        if self._closing.is_set():
            raise OSError("the port was closed")
