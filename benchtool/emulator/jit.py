"""Compilation: `njit` for the functions of the numerical core, `entry` for the few that Python calls.

Only entries are cached on disk. numba's cache looks at the file of the cached function alone, so an edit of a
function it calls would leave a stale entry behind; an entry therefore bears a fingerprint of all sources of
the core in its name, and an edit anywhere makes it another function with cache files of its own.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.extending import register_jitable

F = TypeVar("F", bound=Callable[..., Any])

# No fastmath: the same source gives the same bits. The numpy error model spares a branch at every division.
_OPTIONS: dict[str, Any] = {"error_model": "numpy"}


def njit(function: F) -> F:
    """Compile a function into the compiled functions that call it, where its arguments stay in registers.

    In Python it stays the plain function that it is.
    """
    register_jitable(forceinline=True, no_cfunc_wrapper=True, **_OPTIONS)(function)
    return function


def entry(function: F) -> F:
    """Compile a function that Python calls, and keep it on disk; `py_func` of it is the plain function.

    The cache lies beside the source, or in the user's cache directory when that is not writable; where
    neither is, every process compiles anew.
    """
    function.__qualname__ = f"{function.__name__}_{fingerprint():08x}"
    try:
        return cast(F, numba.njit(cache=True, nogil=True, **_OPTIONS)(function))
    except (RuntimeError, OSError):  # numba found no place to write to
        return cast(F, numba.njit(nogil=True, **_OPTIONS)(function))


def is_cached(compiled: Callable[..., Any]) -> bool:
    """Whether an entry is compiled already, in this process or on disk.

    Judged by the names of the cache files, so a cache of another kind of processor counts as well.
    """
    signatures, stats = getattr(compiled, "nopython_signatures", None), getattr(compiled, "stats", None)
    if signatures is None or stats is None:  # the compiler is switched off
        return True
    if signatures:
        return True
    return stats.cache_path is not None and any(
        Path(stats.cache_path).glob(f"*.{compiled.__qualname__}-*.nbc")
    )


@cache
def fingerprint(package: Path = Path(__file__).parent.parent) -> int:
    """CRC-32 over the compiled sources in a package's folder, and the compiler's version.

    Firmware, servers and ports are not compiled: an edit there leaves it as it is.
    """
    crc = zlib.crc32(numba.__version__.encode())
    for source in compiled_sources(package):
        crc = zlib.crc32(source.read_bytes(), crc)
    return crc


def compiled_sources(package: Path) -> list[Path]:
    """Files whose functions are compiled, or whose constants compiled functions hold, in order."""
    sources = [package / "emulator" / f"{name}.py" for name in ("jit", "memory", "rotation")]
    for room in ("machine", "control", "core"):
        sources += package.glob(f"emulator/{room}/*.py")
    return [*sorted(sources), package / "protocol" / "modes.py", package / "ticks.py"]
