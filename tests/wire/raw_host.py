"""A raw host of an emulated drive on a serial line: sends given messages and keeps responses."""

from __future__ import annotations

import struct
import threading
from collections import deque
from collections.abc import Callable
from typing import TypeVar

from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.ports.client import HungUp
from benchtool.protocol import serial as wire
from benchtool.protocol.dictionary.objects import DataType, Entry, load_table
from benchtool.protocol.modes import Mode
from benchtool.shipped import shipped

TABLE = load_table(shipped("firmware_protocol") / "objects.toml")
HOST = 127
SUPERVISION = HOST << 16 | 500

R = TypeVar("R")


class HeldPort:
    """The drive's end of a line that a test holds in its hand."""

    def __init__(self) -> None:
        self.gone: OSError | None = None
        self.on_write: Callable[[bytes], None] = self.keep
        self.closed = threading.Event()
        self._changed = threading.Condition()
        self._arrived: deque[bytes] = deque()
        self._in_hand = self._departing = False
        self._written = bytearray()

    def read(self) -> bytes:
        with self._changed:
            self._in_hand = False
            self._changed.notify_all()
            if self._departing:
                self._departing, self._in_hand = False, True
                raise HungUp("the client hung up")
            if not self._arrived and self.gone is None:
                self._changed.wait(0.05)
            if self.gone is not None:
                raise self.gone
            self._in_hand = bool(self._arrived)
            return self._arrived.popleft() if self._in_hand else b""

    def write(self, data: bytes) -> None:
        self.on_write(data)

    def close(self) -> None:
        with self._changed:
            self.closed.set()
            self._changed.notify_all()

    def keep(self, data: bytes) -> None:
        """Take bytes of the drive."""
        with self._changed:
            self._written += data

    def deliver(self, data: bytes) -> None:
        """Deliver bytes to the drive, and return when they have been handled."""
        with self._changed:
            self._arrived.append(data)
            self._changed.notify_all()
            assert self._changed.wait_for(self._dealt_with, 5.0)

    def _dealt_with(self) -> bool:
        return self.closed.is_set() or not (self._arrived or self._in_hand or self._departing)

    def depart(self) -> None:
        """Disconnect the client but keep the port, and return when the drive has handled it."""
        with self._changed:
            self._departing = True
            assert self._changed.wait_for(self._dealt_with, 5.0)

    def hang_up(self) -> None:
        """Have the next read fail, and return when the drive has closed its end."""
        with self._changed:
            self.gone = OSError("unplugged")
            self._changed.notify_all()
        assert self.closed.wait(5.0)

    def taken(self) -> bytes:
        """What the drive has written since the last call."""
        with self._changed:
            data = bytes(self._written)
            self._written.clear()
            return data


class RawHost:
    """A host on a line of its own to a bench."""

    def __init__(self, bench: EmulatedBench, *, buffered: bool = False) -> None:
        self.bench = bench
        self.port = HeldPort()
        self.lost: list[OSError] = []
        self._splitter = wire.FrameSplitter()
        self._tag = 0
        bench.add_serial(self.port, self.lost.append, buffered=buffered)

    def tell(self, *messages: wire.Message | bytes) -> list[wire.Reply]:
        """Send messages, or bytes as they are; everything that came since the last call."""
        for message in messages:
            raw = message if isinstance(message, bytes) else wire.encode_frame(wire.encode_message(message))
            self.port.deliver(raw)
        return self.hear()

    def hear(self) -> list[wire.Reply]:
        """Everything that came since the last call."""
        payloads = self._splitter.feed(self.port.taken())
        assert self._splitter.dropped == 0
        messages = [wire.decode_reply(payload) for payload in payloads]
        assert None not in messages
        return [message for message in messages if message is not None]

    def ask(self, request: wire.Message, kind: type[R]) -> R:
        """The one answer of this kind."""
        (answer,) = [each for each in self.tell(request) if isinstance(each, kind)]
        return answer

    def read(self, name: str) -> float:
        """Raw value of an object."""
        entry = TABLE.by_name[name]
        answer = self.ask(wire.Read(self.tag(), entry.index, entry.sub), wire.ReadReply)
        assert answer.status == 0, hex(answer.status)
        value: float = _struct(entry).unpack(answer.data)[0]
        return value

    def write(self, name: str, raw: float) -> int:
        """Write an object; the status."""
        entry = TABLE.by_name[name]
        data = _struct(entry).pack(raw)
        return self.ask(wire.Write(self.tag(), entry.index, entry.sub, data), wire.WriteReply).status

    def tag(self) -> int:
        """A new tag."""
        self._tag = (self._tag + 1) & 0xFF
        return self._tag

    def enable(self, mode: int = Mode.VELOCITY) -> None:
        """To NMT state operational and operation enabled."""
        self.tell(wire.Nmt(1))
        assert self.write("mode_of_operation", mode) == 0
        for word in (6, 7, 15):
            assert self.write("controlword", word) == 0
        assert self.enabled()

    def enabled(self) -> bool:
        """Whether the power stage is on."""
        return int(self.read("statusword")) & 0x6F == 0x27


def mapping(name: str) -> int:
    """An object as a stream or a capture names it."""
    return TABLE.by_name[name].mapping


def _struct(entry: Entry) -> struct.Struct:
    codes = {
        DataType.I8: "b",
        DataType.U8: "B",
        DataType.I16: "h",
        DataType.U16: "H",
        DataType.I32: "i",
        DataType.U32: "I",
        DataType.F32: "f",
    }
    return struct.Struct("<" + codes[entry.type])
