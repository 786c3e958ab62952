"""Results that functions keep (`functools.cache`), cleared between tests.

What a function computes once, the first test that calls it would reach alone, and a mutant in it be met by no
other.
"""

from __future__ import annotations

import sys
from functools import cache
from typing import Any, Final

_KEEPING: Final[Any] = type(cache(lambda: None))
_COMPILED: Final = "benchtool.emulator."
"""Machine code takes seconds to load again, and is not traced."""


def clear_caches() -> None:
    """Clear what functions of the project and of its tests keep, but for the compiled core."""
    for name, module in list(sys.modules.items()):
        if name.partition(".")[0] in ("benchtool", "tests") and not name.startswith(_COMPILED):
            for each in list(vars(module).values()):
                if isinstance(each, _KEEPING):
                    each.cache_clear()
