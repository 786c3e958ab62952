"""The C library's drive and the emulated drive on a CAN bus each, both advanced tick by tick by a test."""

from __future__ import annotations

import ctypes
import threading
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import can
import numpy as np

from benchtool.emulator.bench import EmulatedBench
from benchtool.emulator.core import Trip
from benchtool.emulator.memory import new_memory
from benchtool.profile import load_profile
from benchtool.protocol.cia402 import State
from tests.device.c_drive import kept_words
from tests.wire.raw_host import TABLE

NODE = 1
TICK_NS = 100_000

Frames = list[tuple[int, bytes]]

# What a drive counts for itself; all other signals are what its control has measured.
_COUNTED = ("tick", "stream_sequence")
_MEASURED = [entry.name for entry in TABLE if entry.role == "signal" and entry.name not in _COUNTED]
_CODES = {0x2310: Trip.OVERCURRENT, 0x8400: Trip.OVERSPEED, 0x3220: Trip.UNDERVOLTAGE}

TRIPS = tuple(_CODES)


class HeldBus:
    """The drive's end of a bus: a test delivers frames, and sent frames are kept."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._arrived: deque[can.Message] = deque()
        self._in_hand = False
        self._ended = False
        self._sent: Frames = []

    def recv(self, timeout: float | None = None) -> can.Message | None:
        with self._changed:
            self._in_hand = False
            self._changed.notify_all()
            if not self._arrived and not self._ended:
                self._changed.wait(timeout)
            self._in_hand = bool(self._arrived)
            return self._arrived.popleft() if self._in_hand else None

    def send(self, message: can.Message, timeout: float | None = None) -> None:
        with self._changed:
            self._sent.append((message.arbitration_id, bytes(message.data)))

    def shutdown(self) -> None:
        """The receiving thread has ended."""

    def deliver(self, can_id: int, data: bytes) -> None:
        """Deliver a frame to the drive, and return when it has been handled."""
        with self._changed:
            self._arrived.append(can.Message(arbitration_id=can_id, data=data, is_extended_id=False))
            self._changed.notify_all()
            assert self._changed.wait_for(lambda: not (self._arrived or self._in_hand), 5.0)

    def taken(self) -> Frames:
        """Return the frames that the drive has sent since the last call."""
        with self._changed:
            sent, self._sent = self._sent, []
            return sent

    def end(self) -> None:
        """Wait for no further frame, for which the drive would wait before it ends."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()


class EmulatedEnd:
    """The emulated drive of the paper's bench."""

    def __init__(self, first_tick: int = 0) -> None:
        self._bus = HeldBus()
        begun: dict[str, Any] = {"first_tick": first_tick} if first_tick else {}
        self._bench = EmulatedBench(load_profile("zhu2011"), has_bus=False, **begun)
        self._ticks = 0
        self._node = self._bench._node
        self.memory = self._node.firmware.core.memory
        bus: Any = self._bus
        self._bench.add_can(bus)

    @property
    def state(self) -> State:
        return self._node.firmware.state

    @property
    def has_braked(self) -> bool:
        """Whether a quick stop has come to standstill: it has ended with that, or holds it."""
        return self.state is State.SWITCH_ON_DISABLED or bool(self._node.firmware.core.command.standstill)

    def send(self, can_id: int, data: bytes) -> Frames:
        self._bus.deliver(can_id, data)
        return self._bus.taken()

    def tick(self) -> Frames:
        self._ticks += 1
        self._node.advance_to(self._ticks * self._node.firmware.period_s)
        return self._bus.taken()

    def taken(self) -> Frames:
        """Return the frames that the drive has sent since the last call."""
        return self._bus.taken()

    def trip(self, code: int) -> None:
        self._node.firmware.core.command.trip = int(_CODES[code])

    def close(self) -> None:
        self._bus.end()
        self._bench.close()


class CEnd:
    """The C library's drive; its signals are those that a test writes into `memory`.

    `ranges` are what the sensors of current (A) and dc link (V) reach.
    """

    def __init__(
        self, library: Path, parameters: list[int], ranges: tuple[float, float], first_tick: int = 0
    ) -> None:
        self._functions = ctypes.CDLL(str(library))
        self._functions.can_variables.restype = ctypes.c_void_p
        self._functions.can_size_of_variables.restype = ctypes.c_size_t
        kept = kept_words(parameters)
        assert self._functions.can_power_up(
            ctypes.c_uint32(TICK_NS),
            ctypes.c_uint32(first_tick),
            ctypes.c_uint8(NODE),
            *map(ctypes.c_float, ranges),
            kept,
            ctypes.c_size_t(len(kept)),
        )
        layout = new_memory(TABLE).dtype
        assert self._functions.can_size_of_variables() == layout.itemsize
        raw = (ctypes.c_uint8 * layout.itemsize).from_address(self._functions.can_variables())
        self.memory = np.frombuffer(memoryview(raw), dtype=layout)

    def send(self, can_id: int, data: bytes) -> Frames:
        assert self._functions.can_receive(ctypes.c_uint16(can_id), data, ctypes.c_size_t(len(data)))
        return self.taken()

    def tick(self) -> Frames:
        self._functions.can_tick()
        return self.taken()

    def trip(self, code: int) -> None:
        self._functions.can_trip(ctypes.c_uint16(code))

    def arm_capture(self) -> None:
        """As over another line."""
        assert self._functions.can_arm_capture()

    def stand_still(self) -> None:
        self._functions.can_standstill()

    def taken(self) -> Frames:
        """Return the frames that the drive has sent since the last call."""
        frames: Frames = []
        can_id, data = ctypes.c_uint16(), (ctypes.c_uint8 * 8)()
        while (n := self._functions.can_transmit(ctypes.byref(can_id), data)) >= 0:
            frames.append((can_id.value, bytes(data)[:n]))
        return frames


@dataclass(frozen=True)
class Frame:
    """A step of a transcript: a frame of the host."""

    can_id: int
    data: bytes


@dataclass(frozen=True)
class Ticks:
    """A step: time passes."""

    count: int


@dataclass(frozen=True)
class Tripped:
    """A step: the measurements of the next tick raise a trip."""

    code: int


Step = Frame | Ticks | Tripped


class Pair:
    """Both drives just switched on, with the same parameters; the C library's sees the other's signals."""

    def __init__(self, library: Path, parameters: list[int], first_tick: int = 0) -> None:
        self.emulated = EmulatedEnd(first_tick)
        memory = self.emulated.memory
        ranges = float(memory["i_full_scale"][0]), float(memory["u_dc_full_scale"][0])
        self.c = CEnd(library, parameters, ranges, first_tick)
        self._copy_signals()
        booted = self.emulated.taken()
        assert self.c.taken() == booted == [(0x700 + NODE, b"\x00")]

    def play(self, steps: Iterable[Step]) -> Frames:
        """What both drives answer.

        Raises:
            AssertionError: it is not the same.
        """
        return [frame for step in steps for frame in self._play(step)]

    def ask(self, request: str) -> list[str]:
        """The answers of the SDO servers to a request, in hexadecimal."""
        answers = self.play([sdo(request)])
        assert all(can_id == 0x580 + NODE for can_id, _ in answers)
        return [data.hex(" ").upper() for _, data in answers]

    def close(self) -> None:
        self.emulated.close()

    def _play(self, step: Step) -> Frames:
        match step:
            case Frame(can_id, data):
                expected, seen = self.emulated.send(can_id, data), self.c.send(can_id, data)
            case Ticks(count):
                return [frame for _ in range(count) for frame in self._tick()]
            case Tripped(code):
                self.emulated.trip(code)
                self.c.trip(code)
                expected, seen = self._tick(), []
                return expected
        assert seen == expected, f"{step}: {_text(seen)}, the emulated drive {_text(expected)}"
        return expected

    def _tick(self) -> Frames:
        was = self.emulated.state
        # In the order in which a bus would let them pass.
        expected = sorted(self.emulated.tick(), key=lambda frame: frame[0])
        self._copy_signals()
        if was is State.QUICK_STOP_ACTIVE and self.emulated.has_braked:
            self.c.stand_still()
        seen = sorted(self.c.tick(), key=lambda frame: frame[0])
        tick = int(self.emulated.memory["tick"][0])
        assert seen == expected, f"tick {tick}: {_text(seen)}, the emulated drive {_text(expected)}"
        return expected

    def _copy_signals(self) -> None:
        for name in _MEASURED:
            self.c.memory[name] = self.emulated.memory[name]


def sdo(request: str) -> Frame:
    """A request to the SDO server, in hexadecimal."""
    return Frame(0x600 + NODE, bytes.fromhex(request))


def write(name: str, raw: float) -> Frame:
    """The request that writes an object, expedited."""
    entry = TABLE.by_name[name]
    data = np.asarray(raw).astype(entry.type.numpy).tobytes()
    return download(entry.index, entry.sub, data)


def download(index: int, sub: int, data: bytes) -> Frame:
    """An expedited download of 1 to 4 bytes, whatever the object takes."""
    head = bytes([0x23 | (4 - len(data)) << 2, *index.to_bytes(2, "little"), sub])
    return Frame(0x600 + NODE, (head + data).ljust(8, b"\0"))


def upload(name: str) -> Frame:
    """The request that reads an object, expedited or in segments."""
    entry = TABLE.by_name[name]
    return Frame(0x600 + NODE, bytes([0x40, *entry.index.to_bytes(2, "little"), entry.sub, 0, 0, 0, 0]))


def nmt(command: int) -> Frame:
    return Frame(0x000, bytes([command, NODE]))


def set_up_pdo(name: str, can_id: int, mapped: Sequence[str], timer_ms: int | None = None) -> list[Step]:
    """The writes that put a PDO into use, in their order."""
    mappings = [TABLE.by_name[each].mapping for each in mapped]
    return [
        write(f"{name}_cob_id", 1 << 31 | can_id),
        *([] if timer_ms is None else [write(f"{name}_event_timer", timer_ms)]),
        write(f"{name}_mapping_count", 0),
        *(write(f"{name}_mapping_{place}", mapping) for place, mapping in enumerate(mappings, start=1)),
        write(f"{name}_mapping_count", len(mappings)),
        write(f"{name}_cob_id", can_id),
    ]


def _text(frames: Frames) -> str:
    return ", ".join(f"{can_id:03X} {data.hex(' ').upper()}" for can_id, data in frames) or "nothing"


HOST = 127
HEARD = Frame(0x700 + HOST, b"\x05")
START, STOP, PRE_OPERATIONAL, RESET, RESET_COMMUNICATION = 1, 2, 128, 129, 130
ENABLE: list[Step] = [nmt(START), *(write("controlword", word) for word in (6, 7, 15))]
