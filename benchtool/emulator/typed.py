"""The machine code of a compiled function for arguments of the types that it is called with every time.

numba looks at the types of all arguments at each call, at every number of a record among them: 10 to 30 us
for the kernel, as long as 60 ticks take.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


def typed(compiled: Callable[..., Any], *arguments: Any) -> Callable[..., Any]:
    """Return what calls the machine code for arguments of these types, and looks at them no more.

    It must have been called with such arguments before. A plain function is returned as it is.
    """
    overloads = getattr(compiled, "overloads", None)
    if overloads is None:  # the compiler is switched off
        return compiled
    types = tuple(compiled.typeof_pyval(each) for each in arguments)  # type: ignore[attr-defined]
    called: Callable[..., Any] = overloads[types].entry_point
    return called
