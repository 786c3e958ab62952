"""The cache of compiled code: an edit of any source counts, and a place to write to is not needed."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from benchtool.emulator import jit
from benchtool.emulator.core.core import truth_of
from benchtool.emulator.core.kernels import kernel_is_cached, kernel_of
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.emulator.machine_code import Entry
from tests.physics.paper_machine import MOTOR, make_core

# A core of two files: the entry, and a function in another file that it calls.
CALLEE = """
from core_copy.emulator.jit import njit

@njit
def scaled(x):
    return {factor} * x
"""
ENTRY = """
import sys
from core_copy.emulator.machine_code import is_cached
from core_copy.emulator.core.callee import scaled
from core_copy.emulator.jit import entry

@entry
def answer(x):
    return scaled(x)

cached = is_cached(answer)
print(answer(1.0), cached, answer.compilations, "numba" in sys.modules)
"""


def run_copy(folder: Path, factor: float, **environment: str) -> list[str]:
    package = folder / "core_copy"
    for source in jit.compiled_sources(package):  # every file that the fingerprint is of has to be there
        if source.parent.name != "core":
            source.parent.mkdir(parents=True, exist_ok=True)
            source.write_text("")
    for name in ("jit", "compiler", "machine_code"):
        source = Path(jit.__file__).with_name(f"{name}.py")
        text = re.sub(
            r"benchtool\.emulator\.(jit|compiler|machine_code)\b",
            r"core_copy.emulator.\1",
            source.read_text(),
        )
        (package / "emulator" / f"{name}.py").write_text(text)
    core = package / "emulator" / "core"
    core.mkdir(exist_ok=True)
    (core / "callee.py").write_text(CALLEE.format(factor=factor))
    (core / "caller.py").write_text(ENTRY)
    done = subprocess.run(
        [sys.executable, "-m", "core_copy.emulator.core.caller"],
        cwd=folder,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


def test_edit_of_a_called_file_recompiles_its_caller_and_the_compiler_rests_otherwise(tmp_path: Path) -> None:
    """What is on disk is loaded and called without numba."""
    assert run_copy(tmp_path, 2.0) == ["2.0", "False", "1", "True"]
    assert run_copy(tmp_path, 2.0) == ["2.0", "True", "0", "False"]
    assert run_copy(tmp_path, 3.25) == ["3.25", "False", "1", "True"]  # another size: within a second
    # Python takes a file of the same size for the same


def test_runs_without_any_place_to_cache(tmp_path: Path) -> None:
    """A file in the place of each cache folder keeps even the superuser from writing there."""
    core = tmp_path / "core_copy" / "emulator" / "core"
    core.mkdir(parents=True)
    (core / "__pycache__").write_text("")
    (tmp_path / "no_home").write_text("")
    blocked = str(tmp_path / "no_home")
    assert run_copy(tmp_path, 2.0, HOME=blocked, XDG_CACHE_HOME=blocked, PYTHONDONTWRITEBYTECODE="1") == [
        "2.0",
        "False",
        "1",
        "True",
    ]


def test_an_emulated_bench_imports_neither_the_compiler_nor_the_kernel_before_it_needs_them() -> None:
    loaded = "[name in sys.modules for name in ('numba', 'benchtool.emulator.core.kernel')]"
    code = f"import sys, benchtool.emulator.bench; print({loaded})"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[False, False]"


def test_kernel_is_cached_once_it_ran() -> None:
    core = make_core()
    core.run(1)
    kernel = kernel_of(core._truth)
    assert kernel_is_cached(core._truth)
    assert isinstance(kernel, Entry)
    assert f"{jit.fingerprint():08x}" in kernel.name


def test_each_set_of_parts_has_a_kernel_of_its_own() -> None:
    core = make_core()
    perfect = core._truth
    cogged = truth_of(MotorTruth(**MOTOR, cogging_Nm=0.1, cogging_order=6), core.inverter, core.sensors)
    stronger = truth_of(MotorTruth(**MOTOR, cogging_Nm=0.2, cogging_order=12), core.inverter, core.sensors)
    assert list(jit.parts_of(perfect)) == ["machine", "stage", "sensing", "sensing.encoder"]
    assert list(jit.parts_of(cogged)) == ["machine", "machine.cogging", "stage", "sensing", "sensing.encoder"]
    assert kernel_of(cogged) is kernel_of(stronger)
    names = {kernel.name for kernel in map(kernel_of, (cogged, perfect)) if isinstance(kernel, Entry)}
    assert len(names) == 2


PACKAGE = Path(jit.__file__).parent.parent


def fingerprint_after_an_edit(copy: Path, source: str) -> int:
    """That of a package in which one file has another comment than before."""
    path = copy / source
    before = path.read_bytes()
    path.write_bytes(before + b"# edited\n")
    try:
        return jit.fingerprint.__wrapped__(copy)
    finally:
        path.write_bytes(before)


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sources of the package, to be edited."""
    place = tmp_path_factory.mktemp("package") / "benchtool"
    for source in PACKAGE.rglob("*.py"):
        target = place / source.relative_to(PACKAGE)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source, target)
    return place


def test_an_edit_of_a_server_the_firmware_or_the_host_leaves_the_compiled_kernel_valid(copy: Path) -> None:
    assert jit.fingerprint.__wrapped__(copy) == jit.fingerprint()
    rooms = ("emulator/servers", "emulator/ports", "emulator/firmware", "bench", "link", "protocol/canopen")
    sources = [each.relative_to(copy) for room in rooms for each in (copy / room).rglob("*.py")]
    assert len(sources) > 40
    for source in [*sources, Path("emulator/bench.py")]:
        assert fingerprint_after_an_edit(copy, str(source)) == jit.fingerprint(), source


def test_an_edit_of_a_compiled_source_makes_another_kernel(copy: Path) -> None:
    """Whatever uses the compiler counts, and what it imports from elsewhere if that holds a constant."""
    compiled = [
        each.relative_to(PACKAGE)
        for each in PACKAGE.rglob("*.py")
        if "from benchtool.emulator.jit import" in each.read_text(encoding="utf-8")
    ]
    assert len(compiled) > 25
    for source in (*compiled, "emulator/jit.py", "emulator/memory.py", "protocol/modes.py", "ticks.py"):
        assert fingerprint_after_an_edit(copy, str(source)) != jit.fingerprint(), source
