"""The relay to a viewer: forwards data, and can be cut."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import closing, suppress

import pytest

from benchtool.live.sinks.relay import Relay


@pytest.fixture
def there() -> Iterator[socket.socket]:
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.settimeout(10.0)
        yield server


def connected(relay: Relay, there: socket.socket) -> tuple[socket.socket, socket.socket]:
    here = socket.create_connection(("127.0.0.1", relay.port), 10.0)
    far, _ = there.accept()
    far.settimeout(10.0)
    return here, far


def received(end: socket.socket, count: int) -> bytes:
    got = b""
    while len(got) < count and (part := end.recv(1 << 16)):
        got += part
    return got


def test_bytes_pass_both_ways_in_their_order(there: socket.socket) -> None:
    data = bytes(range(256)) * 4000
    with closing(Relay("127.0.0.1", there.getsockname()[1])) as relay:
        here, far = connected(relay, there)
        with here, far:
            for source, sink in ((here, far), (far, here)):
                sending = threading.Thread(target=source.sendall, args=(data,))
                sending.start()
                assert received(sink, len(data)) == data
                sending.join()


def test_what_is_not_taken_is_held_up_and_cut(there: socket.socket) -> None:
    relay = Relay("127.0.0.1", there.getsockname()[1])
    here, far = connected(relay, there)
    with here, far:
        here.setblocking(False)
        sent = 0
        with pytest.raises(BlockingIOError):
            while sent < 1 << 30:
                sent += here.send(bytes(1 << 16))
                threading.Event().wait(0.001)
        relay.close()
        relay.close()
        here.settimeout(10.0)
        with pytest.raises(ConnectionError):
            here.sendall(bytes(1 << 24))
        with pytest.raises(ConnectionRefusedError), socket.create_connection(("127.0.0.1", relay.port), 10.0):
            pass


def test_the_end_of_one_side_is_that_of_the_other(there: socket.socket) -> None:
    with closing(Relay("127.0.0.1", there.getsockname()[1])) as relay:
        here, far = connected(relay, there)
        with here:
            far.close()
            assert received(here, 1) == b""
        here, far = connected(relay, there)
        with far:
            here.close()
            assert received(far, 1) == b""


def test_without_a_listener_a_connection_ends_at_once(there: socket.socket) -> None:
    port = there.getsockname()[1]
    there.close()
    with (
        closing(Relay("127.0.0.1", port)) as relay,
        socket.create_connection(("127.0.0.1", relay.port), 10.0) as here,
        suppress(ConnectionResetError),
    ):
        assert received(here, 1) == b""


def test_a_cut_relay_hangs_up_on_old_connections_and_on_new_ones(there: socket.socket) -> None:
    """A sender that had not connected yet must not be refused: it would try again for seconds."""
    with closing(Relay("127.0.0.1", there.getsockname()[1])) as relay:
        here, far = connected(relay, there)
        with here, far:
            relay.cut()
            relay.cut()
            with suppress(ConnectionResetError):
                assert received(far, 1) == b""
        with (
            socket.create_connection(("127.0.0.1", relay.port), 10.0) as late,
            suppress(ConnectionResetError),
        ):
            assert received(late, 1) == b""
        there.setblocking(False)
        with pytest.raises(BlockingIOError):
            there.accept()
