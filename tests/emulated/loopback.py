"""A wire of another package: messages of the serial line, each in a packet of a socket pair with its time."""

from __future__ import annotations

import select
import socket
import struct
import threading
from collections.abc import Callable

from benchtool.bench.wires import Offered, Opening, Wire
from benchtool.clock import Clock
from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.servers.drive_node import OnGone
from benchtool.emulator.servers.serial import SerialServer
from benchtool.link import Link
from benchtool.link.port import READ_S, Port
from benchtool.link.serial.link import SerialLink

_TIME_S = struct.Struct("<d")
_MOST = 1 << 17


class LoopbackPort:
    """One end: a `Port` that knows when its reader has dealt with every packet that was sent to it."""

    peer: LoopbackPort

    def __init__(self, end: socket.socket, clock: Clock) -> None:
        self._socket, self._clock = end, clock
        self._changed = threading.Condition()
        self._waiting = 0
        self._in_hand = self._closed = False

    def read_timed(self) -> tuple[bytes, float]:
        """See `PipePort.read_timed`; a reader that comes back has dealt with what it took before."""
        with self._changed:
            self._waiting -= int(self._in_hand)
            self._in_hand = False
            self._changed.notify_all()
        if not select.select([self._socket], [], [], READ_S)[0]:
            return b"", self._clock.now_s()
        packet = self._socket.recv(_MOST)
        if not packet:
            raise OSError("the other end hung up")
        self._in_hand = True
        return packet[_TIME_S.size :], _TIME_S.unpack_from(packet)[0]

    def read(self) -> bytes:
        return self.read_timed()[0]

    def write_at(self, data: bytes, now_s: float) -> None:
        with self.peer._changed:
            self.peer._waiting += 1
        self._socket.sendall(_TIME_S.pack(now_s) + data)

    def write(self, data: bytes) -> None:
        self.write_at(data, self._clock.now_s())

    def close(self) -> None:
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._socket.close()

    def settle(self) -> bool:
        """See `Clock.register`."""
        with self._changed:
            busy = bool(self._waiting) and not self._closed
            self._changed.wait_for(lambda: self._closed or not self._waiting)
        return busy


def _host_link(bench: EmulatedBench, opening: Opening) -> Callable[[], Link]:
    def open_link() -> Link:
        pair = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        drive, host = (LoopbackPort(end, bench.clock) for end in pair)
        drive.peer, host.peer = host, drive
        for end in (drive, host):
            bench.clock.register(end.settle)
        bench.add(lambda node: SerialServer(drive, node, buffered=False))
        return SerialLink(host, opening.node_id, bench.clock)

    return open_link


def _offer(bench: EmulatedBench, port: Port, place: str, _node_id: int, on_gone: OnGone) -> Offered:
    server = bench.add_serial(port, on_gone)
    return Offered(f"elsewhere:{place}", lambda: server.traffic)


WIRE = Wire("loopback", host_link=_host_link, offers={"loopback-serial": _offer})
