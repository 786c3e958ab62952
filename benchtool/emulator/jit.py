"""Compilation: `njit` for the functions of the numerical core, `entry` for the few that Python calls.

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

Only entries and what is compiled separately are cached on disk. numba's cache looks at the file of the cached
function alone, so an edit of a function it calls would leave a stale entry behind; what is cached therefore
bears a fingerprint of all sources of the core in its name, and an edit anywhere makes it another function
with cache files of its own.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
from numba.core.typing.templates import infer_global
from numba.extending import register_jitable

from benchtool.emulator.cache import LoadedFirst
from benchtool.emulator.lowering import PartCompiler

F = TypeVar("F", bound=Callable[..., Any])

# Of fast arithmetic there is one thing: a product and a sum may be rounded once in place of twice, where the
# processor can. The numpy error model spares a branch at every division.
# Compiled code creates no arrays and keeps none. Without `nrt`, numba's runtime, references to them are not
# counted, which is an atomic operation wherever one is passed on: 50 ns in a tick with a capture.
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "_nrt": False, "fastmath": {"contract"}}

_SEPARATE: dict[Callable[..., Any], Any] = {}  # numba holds them by weak references only


def njit(function: F) -> F:
    """Compile a function into the compiled functions that call it, where its arguments stay in registers.

    In Python it stays the plain function that it is.
    """
    return _part(function, forceinline=True)


def called(function: F) -> F:
    """Compile a function that compiled functions call: once, where `njit` repeats it at every call.

    It is for what is long and would be repeated often, which takes minutes to compile. In Python it stays the
    plain function that it is.
    """
    return _part(function, forceinline=False)


def _part(function: F, *, forceinline: bool) -> F:
    """Compile a function that only compiled functions call.

    `forceinline` is stated either way: a function that leaves it open takes it over from what calls it.
    """
    register_jitable(
        forceinline=forceinline,
        no_cfunc_wrapper=True,
        no_cpython_wrapper=True,
        pipeline_class=PartCompiler,
        **_OPTIONS,
    )(function)
    return function


def entry(function: F) -> F:
    """Compile a function that Python calls, and keep it on disk; `py_func` of it is the plain function.

    The cache lies beside the source, or in the user's cache directory when that is not writable; where
    neither is, every process compiles again.
    """
    return cast(F, _compiled(function, f"{fingerprint():08x}"))


def separately(function: F) -> F:
    """Compile a function once for all the compiled functions that call it, and keep it on disk.

    In Python it stays the plain function that it is.
    """
    _SEPARATE[function] = _compiled(function, f"{fingerprint():08x}")
    infer_global(function, numba.types.Dispatcher(_SEPARATE[function]))
    return function


@cache
def specialised(function: Callable[..., Any], parts: frozenset[str]) -> Callable[..., Any]:
    """`entry` of a plain function for one set of parts, with cache files of its own."""
    crc = zlib.crc32(" ".join(sorted(parts)).encode())
    return cast(Callable[..., Any], _compiled(function, f"{crc:08x}_{fingerprint():08x}"))


def parts_of(record: Any, path: str = "") -> Iterator[str]:
    """Yield the names of the optional parts that a record of the kernel has, such as `machine.cogging`."""
    for name in record._fields:
        value = getattr(record, name)
        if hasattr(value, "_fields"):
            yield f"{path}{name}"
            yield from parts_of(value, f"{path}{name}.")


def _compiled(function: Callable[..., Any], suffix: str) -> Any:
    named = FunctionType(
        function.__code__,
        function.__globals__,
        function.__name__,
        function.__defaults__,
        function.__closure__,
    )
    named.__qualname__ = f"{function.__name__}_{suffix}"
    named.__doc__, named.__module__ = function.__doc__, function.__module__
    compiled = numba.njit(nogil=True, **_OPTIONS)(named)
    with suppress(RuntimeError, OSError):  # numba found no place to write to
        compiled._cache = LoadedFirst(named)  # type: ignore[no-untyped-call]
    return compiled


@cache
def fingerprint(package: Path = Path(__file__).parent.parent) -> int:
    """Return the CRC-32 over the compiled sources in a package's folder, and the compiler's version.

    Firmware, servers and ports are not compiled: an edit there leaves it as it is.
    """
    crc = zlib.crc32(numba.__version__.encode())
    for source in compiled_sources(package):
        crc = zlib.crc32(source.read_bytes(), crc)
    return crc


def compiled_sources(package: Path) -> list[Path]:
    """Return the files whose functions are compiled, or whose constants compiled functions hold, in order."""
    sources = [
        package / "emulator" / f"{name}.py" for name in ("in_place", "jit", "lowering", "memory", "rotate")
    ]
    for room in ("machine", "control", "core"):
        sources += package.glob(f"emulator/{room}/*.py")
    return [*sorted(sources), package / "protocol" / "modes.py", package / "ticks.py"]
