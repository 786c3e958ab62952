"""A pseudo-terminal as a byte port, which clients open like the device file of a USB adapter."""

from __future__ import annotations

import errno
import os
import select
import termios
import threading
import tty

from benchtool.emulator.ports.client import HungUp
from benchtool.emulator.ports.share import MOST_B, Share
from benchtool.link import READ_S

__all__ = ["HungUp", "PtyPort"]

_NO_CLIENT_S = 0.01  # polled: the opening of the other end raises no event
_WRITE_POLL_ms = 50
_SETTLING_S = 0.02


class PtyPort:
    """The master's end of a pseudo-terminal; clients open `path` as they would a serial adapter.

    Raw from the start, so that nothing is echoed or translated. The kernel holds some 4 to 20 kB for a client
    that does not read; then `write` waits until it does, hangs up, or the port is closed.
    """

    def __init__(self) -> None:
        self._master, client = os.openpty()
        self.path = os.ttyname(client)
        os.close(client)
        os.set_blocking(self._master, False)
        self._renew()
        self._has_client = False
        self._clients = 0  # who have left
        self._closing = threading.Event()
        self._share = Share()
        self._reading = threading.Lock()
        self._writing = threading.Lock()

    def read(self) -> bytes:
        """See `Port.read`.

        Raises:
            HungUp: once, for each client that had sent something and has gone.
            OSError: the port is closed.
        """
        with self._reading:
            self._require_open()
            if pause_s := self._share.pause_s():
                self._closing.wait(min(pause_s, READ_S))
                return b""
            ready, _, _ = select.select([self._master], [], [], READ_S)
            if not ready:
                return b""
            try:
                data = os.read(self._master, MOST_B)
            except BlockingIOError:
                return b""
            except OSError as reason:
                if reason.errno != errno.EIO:  # EIO: the other end is not open
                    raise
                if self._has_client:
                    self._has_client = False
                    with self._writing:  # a write under way ends, as the other end is not open
                        self._clients += 1
                        self._renew()
                    raise HungUp(f"the client of {self.path} hung up") from None
                self._closing.wait(_NO_CLIENT_S)
                return b""
            self._has_client = True
            self._share.handed_over()
            return data

    def write(self, data: bytes) -> None:
        """See `Port.write`.

        Raises:
            HungUp: the other end is not open; the data are lost.
            OSError: the port is closed.
        """
        clients = self._clients
        with self._writing:
            self._require_open()
            if clients != self._clients:  # the lock was waited for, and it is another client's turn
                raise HungUp(f"the client of {self.path} hung up")
            poll = select.poll()
            poll.register(self._master, select.POLLOUT)
            left = memoryview(data)
            while left:
                self._require_open()
                events = dict(poll.poll(_WRITE_POLL_ms)).get(self._master, 0)
                if events & select.POLLHUP:
                    raise HungUp(f"{self.path} has no client")
                if events & select.POLLOUT:
                    with_room = os.write(self._master, left)
                    left = left[with_room:]

    def close(self) -> None:
        """See `Port.close`; waits for a read or write under way, which end at once."""
        self._closing.set()
        with self._reading, self._writing:
            if self._master >= 0:
                os.close(self._master)
                self._master = -1

    def _renew(self) -> None:
        """Prepare for the next client, who must not find what was meant for the one before."""
        client = os.open(self.path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        try:
            tty.setraw(client)
            # Flushing from the master's side would leave what the line discipline already holds, and the
            # kernel hands it more for a while.
            more = True
            while more:
                termios.tcflush(client, termios.TCIFLUSH)
                more = bool(select.select([client], [], [], _SETTLING_S)[0])
        finally:
            os.close(client)

    def _require_open(self) -> None:
        if self._closing.is_set():
            raise OSError(f"the port {self.path} was closed")
