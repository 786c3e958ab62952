"""The face of the package: what it promises, what it imports, and when."""

from __future__ import annotations

import inspect
import json
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import benchtool

HEAVY = frozenset(
    (
        "scipy",
        "matplotlib",
        "numba",
        "asammdf",
        "rerun",
        "pyarrow",
        "pandas",
        "can",
        "canopen",
        "pydantic",
    )
)


def _loaded(code: str) -> set[str]:
    """The top-level packages, and those of benchtool, that a fresh interpreter has after some code."""
    tell = "import json, sys; print(json.dumps(sorted(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", f"{code}; {tell}"], capture_output=True, text=True, check=True
    )
    return set(json.loads(done.stdout))


def test_a_name_is_imported_when_it_is_used_and_nothing_heavy_with_the_bench() -> None:
    code = "import benchtool; before = [each for each in __import__('sys').modules if 'benchtool.' in each]; "
    loaded = _loaded(code + "assert not before, before; benchtool.open_bench; dir(benchtool)")
    assert "benchtool.api.bench" in loaded
    assert not loaded & HEAVY


@pytest.mark.parametrize("name", benchtool.__all__)
def test_a_name_is_there_and_documented(name: str) -> None:
    found = getattr(benchtool, name)
    assert inspect.getdoc(found)
    assert found.__name__ == name
    assert name in dir(benchtool)


def test_types_are_shipped() -> None:
    for name in ("py.typed", "__init__.pyi"):
        assert (Path(benchtool.__file__).parent / name).is_file()


def test_no_name_is_that_of_a_module_which_would_take_its_place() -> None:
    modules = {each.name for each in pkgutil.iter_modules(benchtool.__path__)}
    assert not modules & set(benchtool.__all__)


def test_another_name_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(AttributeError, match="open_bench"):
        getattr(benchtool, "open_" + "bnch")
