"""A relay to a viewer, whose connections this process can cut.

The SDK waits without end for a viewer that takes nothing, even on the way out of the program, and offers no
way to give up: only the loss of the connection ends that.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from typing import Final

_HERE: Final = "127.0.0.1"
_AT_ONCE: Final = 1 << 16
_STARTING_S: Final = 10.0


class Relay:
    """Forwards connections to a port of this machine in both directions until it is closed.

    Args:
        host, port: where it goes.
    """

    def __init__(self, host: str, port: int) -> None:
        self._there = (host, port)
        self._ready = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._cut = asyncio.Event()
        self._over = asyncio.Event()
        self._passing: set[asyncio.Future[None]] = set()
        self.port = 0
        self._thread = threading.Thread(target=self._run, name="benchtool-live-relay", daemon=True)
        self._thread.start()
        self._ready.wait(_STARTING_S)

    def cut(self) -> None:
        """Cut every connection, and each new one as soon as it is made.

        The SDK looks for an address that refuses it for eleven seconds; one that hangs up it leaves at once.
        """
        self._set(self._cut)

    def close(self) -> None:
        """Cut every connection and take no more; a second call does nothing."""
        self.cut()
        self._set(self._over)
        self._thread.join()

    def _set(self, event: asyncio.Event) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended
            self._loop.call_soon_threadsafe(event.set)

    # ---- the relay's thread -----------------------------------------------------------------------------

    def _run(self) -> None:
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._relay())

    async def _relay(self) -> None:
        server = await asyncio.start_server(self._connect, _HERE, 0)
        self.port = server.sockets[0].getsockname()[1]
        self._ready.set()
        await self._over.wait()
        server.close()
        await asyncio.gather(*self._passing)

    async def _connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        passing = asyncio.ensure_future(self._both_ways(reader, writer))
        self._passing.add(passing)
        passing.add_done_callback(self._passing.discard)

    async def _both_ways(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Forward data until either end closes, or the relay cuts them off."""
        there = None
        if not self._cut.is_set():
            with contextlib.suppress(OSError):
                there = await asyncio.open_connection(*self._there)
        if there is None:
            writer.transport.abort()
            return
        there_reader, there_writer = there
        ways = (_pass_on(reader, there_writer), _pass_on(there_reader, writer), self._cut.wait())
        _, left = await asyncio.wait(map(asyncio.ensure_future, ways), return_when=asyncio.FIRST_COMPLETED)
        for way in left:
            way.cancel()
        await asyncio.gather(*left, return_exceptions=True)
        for end in (writer, there_writer):
            end.transport.abort()


async def _pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    """Read only as fast as the other side takes the data."""
    with contextlib.suppress(OSError):
        while data := await reader.read(_AT_ONCE):
            writer.write(data)
            await writer.drain()
