"""The cache of compiled code: an edit of any source counts, and a place to write to is not needed."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from benchtool.emulator import jit
from benchtool.emulator.core.kernel import kernel_is_cached, run_ticks
from tests.physics.paper_machine import make_core

# A core of two files: the entry, and a function in another file that it calls.
CALLEE = """
from core_copy.jit import njit

@njit
def scaled(x):
    return {factor} * x
"""
ENTRY = """
from core_copy.callee import scaled
from core_copy.jit import entry, is_cached

@entry
def answer(x):
    return scaled(x)

cached = is_cached(answer)
print(answer(1.0), cached, answer.stats.cache_hits.total())
"""


def run_copy(folder: Path, factor: float, **environment: str) -> list[str]:
    package = folder / "core_copy"
    package.mkdir(exist_ok=True)
    shutil.copy(jit.__file__, package / "jit.py")
    (package / "callee.py").write_text(CALLEE.format(factor=factor))
    (package / "caller.py").write_text(ENTRY)
    done = subprocess.run(
        [sys.executable, "-m", "core_copy.caller"],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


def test_edit_of_a_called_file_recompiles_its_caller(tmp_path: Path) -> None:
    assert run_copy(tmp_path, 2.0) == ["2.0", "False", "0"]
    assert run_copy(tmp_path, 2.0) == ["2.0", "True", "1"]
    assert run_copy(tmp_path, 3.0) == ["3.0", "False", "0"]


def test_runs_without_any_place_to_cache(tmp_path: Path) -> None:
    """A file in the place of each cache folder keeps even the superuser from writing there."""
    package = tmp_path / "core_copy"
    package.mkdir()
    (package / "__pycache__").write_text("")
    (tmp_path / "no_home").write_text("")
    blocked = str(tmp_path / "no_home")
    assert run_copy(tmp_path, 2.0, HOME=blocked, XDG_CACHE_HOME=blocked, PYTHONDONTWRITEBYTECODE="1") == [
        "2.0",
        "False",
        "0",
    ]


def test_kernel_is_cached_once_it_ran() -> None:
    make_core().run(1)
    assert kernel_is_cached()
    assert f"{jit.fingerprint():08x}" in run_ticks.__qualname__
