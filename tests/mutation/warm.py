"""Runs of pytest that are forked from a process which has the large libraries imported already.

Those imports are most of the time of a run of a few quick tests. Nothing of the project is imported here: the
child takes it from the copy that it is told to test.
"""

from __future__ import annotations

import importlib
import multiprocessing
import os
import signal
import sys
import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

PROJECT = Path(__file__).parents[2]
_LIBRARIES = (
    "numba",
    "scipy.signal",
    "pyarrow.parquet",
    "pydantic",
    "canopen",
    "can",
    "serial",
    "matplotlib",
)
_FORK = multiprocessing.get_context("fork")


def warm_up() -> None:
    """Import what every test needs and no pytest plugin is."""
    for name in ("pytest", *_LIBRARIES):
        importlib.import_module(name)


def run_pytest(
    tree: Path, arguments: Sequence[str], limit_s: float, *, plain: bool
) -> tuple[int | None, str]:
    """Exit code and standard output of pytest in `tree`; None if it had not ended after `limit_s`.

    Args:
        plain: with numba's compiler switched off.
    """
    with tempfile.TemporaryFile() as output:
        child = _FORK.Process(target=_child, args=(tree, list(arguments), plain, output.fileno()))
        child.start()
        child.join(limit_s)
        code = child.exitcode
        assert child.pid is not None
        with suppress(ProcessLookupError):  # and whatever processes the tests left behind
            os.killpg(child.pid, signal.SIGKILL)
        child.join()
        output.seek(0)
        return code, output.read().decode(errors="replace")


def _child(tree: Path, arguments: list[str], plain: bool, output: int) -> None:
    os.setsid()
    os.chdir(tree)
    os.dup2(output, 1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    os.environ |= {"PYTHONPATH": str(tree), "NUMBA_DISABLE_JIT": str(int(plain))}
    for name in [name for name in sys.modules if name.partition(".")[0] in ("tests", "benchtool")]:
        del sys.modules[name]
    sys.path[:] = [
        str(tree),
        *(path for path in sys.path if Path(path or ".").resolve() not in (PROJECT, tree)),
    ]
    numba: Any = importlib.import_module("numba")
    numba.config.DISABLE_JIT = int(plain)
    pytest: Any = importlib.import_module("pytest")
    sys.stdout = os.fdopen(1, "w", closefd=False)
    code = int(pytest.main(arguments))
    sys.stdout.flush()
    os._exit(code)
