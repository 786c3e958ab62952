"""Failures within the wire of another package: told as such, and not as a defect of benchtool."""

from __future__ import annotations

import contextlib
import inspect
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import TracebackType
from typing import Final

from benchtool.bench.wires import registry
from benchtool.errors import BenchError, PlugInError

_OURS: Final = "benchtool"


@contextmanager
def naming_wires() -> Iterator[None]:
    """Turn what an installed wire raises when it is used into an error that names the wire.

    Raises:
        PlugInError: benchtool called code of an installed wire's package, which raised an exception of
            another kind than benchtool's errors.
    """
    try:
        yield
    except BenchError:
        raise
    except Exception as failure:
        for entry in registry.installed_entries():
            if _blamed(entry.module, [*_modules(failure.__traceback__)]):
                raise PlugInError(
                    f"the wire '{entry.name}' ({entry.value}) failed: {type(failure).__name__}: {failure}; "
                    f"repair or remove the package that brings it"
                ) from failure
        raise


def _blamed(module: str, trace: Sequence[str]) -> bool:
    """Return whether a failure is of a wire's module: called at once, or its package by benchtool.

    What a caller raises in a `with` block came through no code of benchtool, even if it is of that package.
    """
    package = module.rpartition(".")[0] or module
    ours = next((at for at, name in enumerate(trace) if _within(name, _OURS)), len(trace))
    return trace[:1] == [module] or any(_within(name, package) for name in trace[ours:])


def _modules(trace: TracebackType | None) -> Iterator[str]:
    """Yield modules that a failure went through, the outermost first, without the `with` blocks around it."""
    leading = True
    while trace is not None:
        code = trace.tb_frame.f_code
        leading = leading and bool(
            code.co_flags & inspect.CO_GENERATOR or code.co_filename == contextlib.__file__
        )
        if not leading:
            yield str(trace.tb_frame.f_globals.get("__name__", ""))
        trace = trace.tb_next


def _within(name: str, package: str) -> bool:
    return name == package or name.startswith(f"{package}.")
