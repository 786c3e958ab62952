"""numba's cache on disk, read without initialising the compiler.

Before it looks for a compiled function, numba imports its implementations of everything that Python and numpy
have and enters them in tables, which takes longer than the rest of loading. Machine code that is there needs
none of it; numba does the same by itself when it begins to compile.
"""

from __future__ import annotations

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
