"""What examples and documentation import is what is promised to others."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import benchtool

ROOT = Path(__file__).parents[2]
PROMISED = frozenset(("benchtool", "benchtool.errors", "benchtool.analysis", "benchtool.bench.wires"))
"""The API, and what a package takes that brings an analysis or a wire."""


FENCED = re.compile(r"^```(?:python|py)\n(.*?)^```", re.MULTILINE | re.DOTALL)


def _sources() -> Iterator[tuple[str, str]]:
    """Examples, code cells of notebooks and Python blocks of the documentation, each with its place."""
    for path in sorted((ROOT / "examples").rglob("*.py")):
        yield str(path.relative_to(ROOT)), path.read_text(encoding="utf-8")
    for path in sorted((ROOT / "examples").rglob("*.ipynb")):
        cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
        code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        yield str(path.relative_to(ROOT)), "\n".join(code)
    for path in sorted((*(ROOT / "docs").rglob("*.md"), ROOT / "README.md")):
        for number, found in enumerate(FENCED.finditer(path.read_text(encoding="utf-8")), start=1):
            yield f"{path.relative_to(ROOT)}, block {number}", found[1]


SOURCES = dict(_sources())


def beyond_the_promise(source: str) -> list[str]:
    """Modules and names of benchtool that a source uses and that are not promised."""
    found: list[str] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [each.name for each in node.names if each.name.partition(".")[0] == "benchtool"]
        elif isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "benchtool":
            found.append(str(node.module))
            if node.module == "benchtool":
                found += [f"benchtool.{each.name}" for each in node.names]
        elif isinstance(node, ast.Attribute) and ast.unparse(node.value) == "benchtool":
            found.append(f"benchtool.{node.attr}")
    names = {f"benchtool.{name}" for name in (*benchtool.__all__, "__version__")}
    return [each for each in found if each not in PROMISED | names]


@pytest.mark.parametrize("place", SOURCES)
def test_a_user_imports_what_is_promised(place: str) -> None:
    assert beyond_the_promise(SOURCES[place]) == []


def test_what_is_not_promised_is_found() -> None:
    source = (
        "import benchtool.run\nfrom benchtool.drive import Mode\nfrom benchtool import run\nbenchtool.live()"
    )
    found = ["benchtool.run", "benchtool.drive", "benchtool", "benchtool.run", "benchtool.live"]
    assert beyond_the_promise(source) == [each for each in found if each != "benchtool"]
