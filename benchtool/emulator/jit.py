"""What is compiled: `njit` for the functions of the numerical core, `entry` for the few that Python calls.

What a machine has not costs nothing. An optional part of a record is None where it is absent, and a function
that takes such a part as an argument asks first whether it is there:

    @njit
    def less_cogging(cogging: Cogging | None, rate: float, ...) -> float:
        if cogging is None:
            return rate
        ...

The type of None is a type like any other, so the kernel is compiled for the parts that are there, and the
rest of such a function is neither typed nor compiled for those that are not. `specialised` gives each set of
parts a kernel of its own, `separately` compiles what all of them share once.

Here functions are only noted. numba is imported when one is to be compiled (`emulator.compiler`); machine
code that is on disk is loaded and called without it (`emulator.machine_code`).

Only entries and what is compiled separately are kept on disk. Each bears a fingerprint of all sources of the
core in its name, so that an edit anywhere makes it another function with files of its own.
"""

from __future__ import annotations

import os
import zlib
from collections.abc import Callable, Iterator
from enum import Enum, auto
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, cast

from benchtool.emulator.machine_code import Entry

F = TypeVar("F", bound=Callable[..., Any])


class Manner(Enum):
    """How a function that compiled functions call gets into them."""

    INLINED = auto()
    CALLED = auto()
    SEPARATE = auto()


class Part(NamedTuple):
    """A function that compiled functions call."""

    function: Callable[..., Any]
    manner: Manner


PARTS: list[Part] = []
"""All of them, in the order of their definition."""


def njit(function: F) -> F:
    """Compile a function into the compiled functions that call it, where its arguments stay in registers.

    In Python it stays the plain function that it is.
    """
    PARTS.append(Part(function, Manner.INLINED))
    return function


def called(function: F) -> F:
    """Compile a function that compiled functions call: once, where `njit` repeats it at every call.

    It is for what is long and would be repeated often, which takes minutes to compile. In Python it stays the
    plain function that it is.
    """
    PARTS.append(Part(function, Manner.CALLED))
    return function


def separately(function: F) -> F:
    """Compile a function once for all the compiled functions that call it, and keep it on disk.

    In Python it stays the plain function that it is.
    """
    PARTS.append(Part(function, Manner.SEPARATE))
    return function


def entry(function: F) -> F:
    """Compile a function that Python calls, and keep it on disk.

    Arguments are integers, floating-point numbers, arrays, None, and tuples of these; results are a number or
    None.
    """
    source = Path(function.__code__.co_filename)
    name = f"{source.stem}.{function.__name__}_{fingerprint():08x}"
    return cast(F, _entry(lambda: function, name, source.parent))


@cache
def specialised(
    plain: Callable[[], Callable[..., Any]], source: Path, parts: frozenset[str]
) -> Callable[..., Any]:
    """`entry` of a plain function for one set of parts, with machine code of its own.

    Args:
        plain: gives the function; called when it is to be compiled.
        source: its file.
        parts: names of the parts.
    """
    crc = zlib.crc32(" ".join(sorted(parts)).encode())
    return _entry(plain, f"{source.stem}_{crc:08x}_{fingerprint():08x}", source.parent)


def _entry(plain: Callable[[], Callable[..., Any]], name: str, folder: Path) -> Callable[..., Any]:
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        return plain()
    return Entry(plain, name, folder)


def parts_of(record: Any, path: str = "") -> Iterator[str]:
    """Yield the names of the optional parts that a record of the kernel has, such as `machine.cogging`."""
    for name in record._fields:
        value = getattr(record, name)
        if hasattr(value, "_fields"):
            yield f"{path}{name}"
            yield from parts_of(value, f"{path}{name}.")


@cache
def fingerprint(package: Path = Path(__file__).parent.parent) -> int:
    """Return the CRC-32 over the compiled sources in a package's folder, and the compiler's version.

    Firmware, servers and ports are not compiled: an edit there leaves it as it is.
    """
    crc = zlib.crc32(version("numba").encode())
    for source in compiled_sources(package):
        crc = zlib.crc32(source.read_bytes(), crc)
    return crc


def compiled_sources(package: Path) -> list[Path]:
    """Return the files whose functions are compiled, or whose constants compiled functions hold, in order."""
    names = ("compiler", "in_place", "in_place_types", "jit", "lowering", "machine_code", "memory", "rotate")
    sources = [package / "emulator" / f"{name}.py" for name in names]
    for room in ("machine", "control", "core"):
        sources += package.glob(f"emulator/{room}/*.py")
    return [*sorted(sources), package / "protocol" / "modes.py", package / "ticks.py"]
