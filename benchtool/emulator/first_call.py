"""The first call of a compiled function in a process: compiled once for all processes, and without pauses.

Compiling takes seconds, so that processes that need the same function at the same time wait for the first of
them and load what it leaves on disk; what is there already is loaded by all at once. The compiler makes
millions of objects and hardly any rubbish; to look for rubbish among them takes a fifth of its time, so that
the collector rests meanwhile.
"""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from benchtool.emulator.machine_code import is_cached

try:
    import fcntl
except ImportError:  # Windows: each process compiles by itself
    fcntl = None  # type: ignore[assignment]


def call_first(
    compiled: Callable[..., Any], call: Callable[[], Any], *, on_compiling: Callable[[], None] = lambda: None
) -> None:
    """Run `call`, a call of `compiled` that does nothing, unless the process has compiled or loaded it.

    `on_compiling` is called before, if that compiles for some seconds or waits for a process that does.
    """
    if getattr(compiled, "loaded", True):  # a plain function is: the compiler is switched off
        return
    folder: Path | None = getattr(compiled, "folder", None)
    compiles = not is_cached(compiled)
    if compiles:
        on_compiling()
    alone = _one_process(folder) if folder is not None and compiles else nullcontext()
    with alone, _uncollected():
        call()


@contextmanager
def _one_process(folder: Path) -> Iterator[None]:
    """Hold a lock on a folder of the cache; where it cannot be had there is none."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        lock = (folder / "compiling.lock").open("w")
    except OSError:
        yield
        return
    with lock:
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_EX)  # falls with the file, whatever ends the process
        yield


@contextmanager
def _uncollected() -> Iterator[None]:
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
