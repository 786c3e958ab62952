"""numba's cache on disk, read without initialising the compiler.

Before it looks for a compiled function, numba imports its implementations of everything that Python and numpy
have and enters them in tables, which takes longer than the rest of loading. Machine code that is there needs
none of it; numba does the same by itself when it begins to compile.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba.core.caching import FunctionCache


class LoadedFirst(FunctionCache):
    """The cache of a function, whose code is loaded as it lies there.

    Code that refers to numba's runtime cannot be loaded so: it must be compiled without (`_nrt`).
    """

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the compiled function of a signature, None where it is not there."""
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)  # type: ignore[no-untyped-call]


def is_cached(compiled: Callable[..., Any]) -> bool:
    """Return whether an entry is compiled already, in this process or on disk.

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
