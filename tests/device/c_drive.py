"""The C library as a drive controlled by a test: built once, in its own time, addressed in bytes."""

from __future__ import annotations

import ctypes
import os
import shutil
import struct
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from benchtool.profile import load_profile
from benchtool.protocol.dictionary.objects import DataType
from tests.wire.raw_host import TABLE, HeldPort, RawHost

FOLDER = Path(__file__).parents[2] / "firmware_protocol" / "c"
TICK_NS = 100_000
_AT_ONCE = 100
_CAPACITY = 1 << 18


@contextmanager
def lasting(*command: str | Path) -> Iterator[str]:
    """The link of a drive in a process of its own, as its first line tells it; it must not end by itself."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as child:
        try:
            assert child.stdout is not None
            yield child.stdout.readline().strip()
            assert child.poll() is None, "the drive has ended by itself"
        finally:
            child.kill()


def make(build: Path, *targets: str, **variables: str) -> str:
    """Return the output of make; skips the test without a compiler, and fails if make fails."""
    missing = [tool for tool in ("make", "python3") if shutil.which(tool) is None]
    if not (shutil.which("gcc") or shutil.which("clang")):
        missing.append("gcc or clang")
    if missing:
        pytest.skip(f"the C library needs {' and '.join(missing)}, not installed here")
    settings = [f"{key}={value}" for key, value in {"BUILD": str(build), **variables}.items()]
    # A make above this one must not share its jobs: without it there is no warning either.
    environment = {key: value for key, value in os.environ.items() if key not in ("MAKEFLAGS", "MFLAGS")}
    done = subprocess.run(
        ["make", "-C", FOLDER, *settings, *targets],
        capture_output=True,
        text=True,
        check=False,
        timeout=600,
        env=environment,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


class Library:
    """Functions of the shared object, typed."""

    def __init__(self, path: Path) -> None:
        self._functions = ctypes.CDLL(str(path))

    def call(self, name: str, *arguments: object, result: Any = ctypes.c_uint32) -> Any:
        """Call a function of C."""
        function = getattr(self._functions, name)
        function.restype = result
        return function(*arguments)

    def power_up(self, parameters: list[int], first_tick: int = 0) -> None:
        """A drive just switched on, with these stored raw parameters in the order of the table.

        Its sensors are those of the emulated bench that the parameters are of.
        """
        words = kept_words(parameters)
        emulator = load_profile("zhu2011").emulator
        assert emulator is not None
        ranges = (
            ctypes.c_float(emulator.sensors.i_full_scale_A),
            ctypes.c_float(emulator.sensors.u_full_scale_V),
        )
        settings = TICK_NS, ctypes.c_uint32(first_tick), *ranges, words, ctypes.c_size_t(len(words))
        assert self.call("shared_power_up", *settings, result=ctypes.c_int)

    def run(self, ticks: int) -> None:
        self.call("shared_run", ctypes.c_uint32(ticks), result=None)

    def receive(self, data: bytes) -> None:
        """Have the drive receive and handle bytes."""
        assert self.call("shared_receive", data, ctypes.c_size_t(len(data)), result=ctypes.c_size_t) == len(
            data
        )

    def transmitted(self) -> bytes:
        """Return the bytes sent since the last call."""
        buffer = ctypes.create_string_buffer(_CAPACITY)
        taken = b""
        while n := self.call("shared_transmit", buffer, ctypes.c_size_t(_CAPACITY), result=ctypes.c_size_t):
            taken += buffer.raw[:n]
        return taken


class CPort(HeldPort):
    """The drive's end of the line."""

    def __init__(self, library: Library) -> None:
        super().__init__()
        self._library = library

    def deliver(self, data: bytes) -> None:
        self._library.receive(data)
        self.keep(self._library.transmitted())


class CClock:
    """The drive's time."""

    def __init__(self, library: Library, keep: Callable[[bytes], None]) -> None:
        self._library = library
        self._keep = keep
        self._now_s = 0.0
        self._ticks = 0

    def wait(self, duration_s: float) -> None:
        """Let time pass, with a line that takes the drive's bytes."""
        self._now_s += duration_s
        end = int(self._now_s / (TICK_NS * 1e-9) + 1e-6)
        while (left := end - self._ticks) > 0:
            step = min(left, _AT_ONCE)
            self._library.run(step)
            self._keep(self._library.transmitted())
            self._ticks += step


class _CBench:
    def __init__(self, clock: CClock) -> None:
        self.clock = clock


class CHost(RawHost):
    """A host on the line of a drive of the C library."""

    def __init__(self, library: Library, parameters: list[int], first_tick: int = 0) -> None:
        library.power_up(parameters, first_tick)
        port = CPort(library)

        def add_serial(_: object, *__: object, **___: object) -> None:
            """The line is there already."""

        bench: Any = _CBench(CClock(library, port.keep))
        bench.add_serial = add_serial
        super().__init__(bench)
        self.port = port
        port.keep(library.transmitted())


def kept_words(parameters: list[int]) -> ctypes.Array[ctypes.c_uint32]:
    """Stored parameters of a drive of the C library, after the hash of their dictionary."""
    words = [TABLE.hash, *parameters]
    return (ctypes.c_uint32 * len(words))(*words)


def raw_parameters(host: RawHost) -> list[int]:
    """Parameters of another drive, raw and in the order of the table."""
    return [_word(entry.type, host.read(entry.name)) for entry in TABLE if entry.role == "parameter"]


def _word(type_: DataType, value: float) -> int:
    if type_ is DataType.F32:
        return int(struct.unpack("<I", struct.pack("<f", value))[0])
    return int(value) & 0xFFFFFFFF
