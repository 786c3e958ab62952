"""Endpoints of a CANopen wire for tests: a served dictionary, a plain peer, adapters with faults."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterable
from typing import Any

import can
from canopen.sdo.exceptions import SdoAbortedError

from benchtool.emulator.servers.sdo_server import SdoServer
from benchtool.link.canopen.virtual import VirtualTimeBus

NODE = 5


class Served:
    """An SDO server with a dictionary, on its own thread and bus."""

    def __init__(self, channel: str) -> None:
        self.channel = channel
        self.objects: dict[tuple[int, int], bytes] = {}
        self.writes: list[tuple[int, int, bytes]] = []
        self.bus = VirtualTimeBus(channel)
        self.sdo = SdoServer(self._read, self._write, self._send)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="served")
        self._thread.start()

    def close(self) -> None:
        self._stop.set()
        self._thread.join()
        self.bus.shutdown()

    def _run(self) -> None:
        while not self._stop.is_set():
            frame = self.bus.recv(0.005)
            if frame is not None and frame.arbitration_id == 0x600 + NODE:
                self.sdo.on_request(bytes(frame.data))

    def _read(self, index: int, sub: int) -> bytes:
        if (index, sub) not in self.objects:
            raise SdoAbortedError(0x06020000)
        return self.objects[index, sub]

    def _write(self, index: int, sub: int, data: bytes) -> None:
        if index == 0x1000:
            raise SdoAbortedError(0x06010002)
        self.writes.append((index, sub, data))
        self.objects[index, sub] = data

    def _send(self, data: bytes) -> None:
        self.bus.send(can.Message(arbitration_id=0x580 + NODE, data=data, is_extended_id=False))


class Wire:
    """A plain python-can bus beside a server, spoken to in hexadecimal."""

    def __init__(self, served: Served) -> None:
        self._served = served
        self.bus = can.Bus(interface="virtual", channel=served.channel)

    def ask(self, *requests: str) -> list[str]:
        """Send frames; everything that comes back, as upper-case hexadecimal."""
        for request in requests:
            data = bytes.fromhex(request)
            self.bus.send(can.Message(arbitration_id=0x600 + NODE, data=data, is_extended_id=False))
        self._served.bus.settle()
        answers = []
        while (frame := self.bus.recv(0)) is not None:
            assert frame.arbitration_id == 0x580 + NODE
            answers.append(bytes(frame.data).hex(" ").upper())
        return answers


Step = can.Message | Exception


class ScriptedBus(can.BusABC):
    """An adapter that answers each sent frame as told; an exception among the answers is raised by recv."""

    def __init__(self, answer: Callable[[can.Message], Iterable[Step]] = lambda _: ()) -> None:
        super().__init__(channel="scripted")
        self.answer = answer
        self.sent: list[can.Message] = []
        self.arriving: queue.Queue[Step] = queue.Queue()
        self.broken: Exception | None = None
        self.send_error: Exception | None = None

    @property
    def requests(self) -> list[str]:
        return [bytes(frame.data).hex(" ").upper() for frame in self.sent]

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if self.send_error is not None:
            raise self.send_error
        self.sent.append(msg)
        for step in self.answer(msg):
            self.arriving.put(step)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if self.broken is not None:
            raise self.broken
        try:
            step = self.arriving.get(timeout=timeout)
        except queue.Empty:
            return None, True
        if isinstance(step, Exception):
            raise step
        return step, True


class LossyBus(VirtualTimeBus):
    """An adapter that does not hear what `loses` says."""

    def __init__(self, channel: str) -> None:
        super().__init__(channel)
        self.loses: Callable[[can.Message], bool] = lambda _: False

    def recv(self, timeout: float | None = None) -> can.Message | None:
        received = super().recv(timeout)
        return None if received is not None and self.loses(received) else received


def frame(can_id: int, data: str, **flags: Any) -> can.Message:
    """A standard frame from hexadecimal."""
    return can.Message(
        **{"arbitration_id": can_id, "data": bytes.fromhex(data), "is_extended_id": False, **flags}
    )


def sdo(data: str) -> can.Message:
    return frame(0x580 + NODE, data)


def script(*answers: list[Step]) -> Callable[[can.Message], Iterable[Step]]:
    """Answer the n-th sent frame with the n-th list, later ones with nothing."""
    left = iter(answers)
    return lambda _: next(left, [])
