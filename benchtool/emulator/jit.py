"""Compilation: one `njit` for every function of the numerical core, one `entry` for those Python calls.

Only entries are cached on disk. numba's cache looks at the file of the cached function alone, so an edit of a
function it calls would leave a stale entry behind; an entry therefore bears a fingerprint of all sources of
the core in its name, and an edit anywhere makes it another function with a file of its own.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])

# No fastmath: the same source gives the same bits. The numpy error model spares a branch at every division.
_OPTIONS = {"error_model": "numpy", "nogil": True}


def njit(function: F) -> F:
    """Compile a function of the core, as part of the entry that calls it."""
    return cast(F, numba.njit(**_OPTIONS)(function))


def entry(function: F) -> F:
    """Compile a function that Python calls, and keep it on disk.

    The cache lies beside the source, or in the user's cache directory when that is not writable; where
    neither is, every process compiles anew.
    """
    function.__qualname__ = f"{function.__name__}_{fingerprint():08x}"
    try:
        return cast(F, numba.njit(cache=True, **_OPTIONS)(function))
    except RuntimeError:  # numba found no place to write to
        return njit(function)


def is_cached(compiled: Callable[..., Any]) -> bool:
    """Whether an entry is compiled already, in this process or on disk.

    Judged by the names of the cache files, so a cache of another processor counts as well.
    """
    if not hasattr(compiled, "stats"):  # the compiler is switched off
        return True
    if compiled.nopython_signatures:
        return True
    folder = compiled.stats.cache_path
    return folder is not None and any(Path(folder).glob(f"*.{compiled.__qualname__}-*.nbc"))


@cache
def fingerprint() -> int:
    """CRC-32 over the sources of the core and the compiler's version."""
    folder = Path(__file__).parent
    crc = zlib.crc32(numba.__version__.encode())
    for source in sorted([*folder.glob("*.py"), *folder.glob("control/*.py")]):
        crc = zlib.crc32(source.read_bytes(), crc)
    return crc
