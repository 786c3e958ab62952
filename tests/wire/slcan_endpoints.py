"""Ends of an slcan line for tests: a port that plays a script, a drive behind an adapter, a raw terminal."""

from __future__ import annotations

import queue
import socket
import threading
from collections.abc import Callable, Iterable

import can
from canopen.sdo.exceptions import SdoAbortedError

from benchtool.clock import RealClock
from benchtool.emulator.ports.pty import HungUp
from benchtool.emulator.servers.sdo_server import SdoServer
from benchtool.emulator.servers.slcan import SlcanAdapter
from benchtool.link.pipe import pipe
from benchtool.link.port import SocketPort
from tests.wire.endpoints import NODE

READS = 200


class ScriptedPort:
    """A port whose other end answers each line as told; an exception among the answers is raised by read."""

    def __init__(self, answer: Callable[[bytes], Iterable[bytes | OSError]] = lambda _: ()) -> None:
        self.answer = answer
        self.lines: list[bytes] = []
        self.arriving: queue.Queue[bytes | OSError] = queue.Queue()
        self.closed = 0
        self.write_error: OSError | None = None

    def read(self) -> bytes:
        try:
            step = self.arriving.get(timeout=0.01)
        except queue.Empty:
            return b""
        if isinstance(step, OSError):
            self.arriving.put(step)
            raise step
        return step

    def write(self, data: bytes) -> None:
        if self.write_error is not None:
            raise self.write_error
        for line in data.split(b"\r")[:-1]:
            self.lines.append(line)
            for step in self.answer(line):
                self.arriving.put(step)

    def close(self) -> None:
        self.closed += 1


class StuckPort:
    """A port that takes nothing until it is closed, and whose client hangs up at once."""

    def __init__(self) -> None:
        self.writing = threading.Event()
        self._closed = threading.Event()

    def read(self) -> bytes:
        raise HungUp("the client hung up")

    def write(self, data: bytes) -> None:
        self.writing.set()
        self._closed.wait()

    def close(self) -> None:
        self._closed.set()


class AcceptedPort(SocketPort):
    """The server's end of a TCP connection."""

    def __init__(self, accepted: socket.socket) -> None:
        accepted.settimeout(1.0)
        self._socket = accepted


class Terminal:
    """A host that types lines at an adapter and reads what comes back, all in the calling thread."""

    def __init__(self, *, acknowledge: bool = True, bitrate: int | None = None) -> None:
        self._host, device = pipe(RealClock())
        self.adapter = SlcanAdapter(device, acknowledge=acknowledge, bitrate=bitrate)

    def type(self, data: bytes) -> list[can.Message]:
        """Send bytes; the frames that the drive's end gets."""
        self._host.write(data)
        received = []
        while (frame := self.adapter.recv(0.0)) is not None:
            received.append(frame)
        return received

    def read(self, length: int) -> bytes:
        """As many bytes as the adapter sends, or what there is after a quiet interval."""
        data = b""
        while len(data) < length and (more := self._host.read()):
            data += more
        return data

    def ask(self, line: str) -> bytes:
        """What is answered to a line."""
        self.type(line.encode() + b"\r")
        answer = b""
        while not answer.endswith((b"\r", b"\a")) and (more := self._host.read()):
            answer += more
        return answer

    def hang_up(self) -> None:
        self._host.close()

    def close(self) -> None:
        self.adapter.shutdown()


class Drive:
    """An SDO server behind an adapter, on a thread of its own."""

    def __init__(self, adapter: SlcanAdapter) -> None:
        self.adapter = adapter
        self.objects: dict[tuple[int, int], bytes] = {}
        self.failure: Exception | None = None
        self._sdo = SdoServer(self._read, self._write, lambda data: self.send(0x580 + NODE, data))
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="drive")
        self._thread.start()

    def send(self, can_id: int, data: bytes) -> None:
        self.adapter.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.adapter.shutdown()

    def _run(self) -> None:
        try:
            while not self._stop.is_set():
                frame = self.adapter.recv(0.05)
                if frame is not None and frame.arbitration_id == 0x600 + NODE:
                    self._sdo.on_request(bytes(frame.data))
        except can.CanError as failure:
            self.failure = failure

    def _read(self, index: int, sub: int) -> bytes:
        if (index, sub) not in self.objects:
            raise SdoAbortedError(0x06020000)
        return self.objects[index, sub]

    def _write(self, index: int, sub: int, data: bytes) -> None:
        self.objects[index, sub] = data
