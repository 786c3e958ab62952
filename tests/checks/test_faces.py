"""A package is imported by its face: what its `__init__.pyi` names, and none of the files behind it."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SOURCES = sorted((ROOT / "benchtool").rglob("*.py"))
FACES = sorted((ROOT / "benchtool").rglob("__init__.pyi"))


def _module(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def _behind_a_face(imported: str) -> bool:
    """Whether this is a file within one of the packages, and not a package or a module beside them."""
    path = ROOT.joinpath(*imported.split("."))
    return path.with_suffix(".py").is_file() and path.parent != ROOT / "benchtool"


def _breaches(source: str, importer: str) -> Iterator[str]:
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            names = [str(node.module)]
        else:
            continue
        for name in names:
            is_elsewhere = name.split(".")[:2] != importer.split(".")[:2]
            if name.startswith("benchtool.") and is_elsewhere and _behind_a_face(name):
                yield f"line {node.lineno}: {name}"


@pytest.mark.parametrize("path", SOURCES, ids=_module)
def test_other_packages_are_imported_by_their_faces(path: Path) -> None:
    assert list(_breaches(path.read_text(encoding="utf-8"), _module(path))) == []


@pytest.mark.parametrize(
    "line",
    [
        "from benchtool.link.port import Port",
        "import benchtool.link.port",
        "def late():\n    from benchtool.protocol.canopen.sdo import ccs",
    ],
)
def test_a_file_behind_a_face_is_noticed(line: str) -> None:
    assert list(_breaches(line, "benchtool.drive.remote"))
    assert not list(_breaches("from benchtool.link import Port", "benchtool.drive.remote"))
    assert not list(_breaches("from benchtool.drive.states import States", "benchtool.drive.remote"))


@pytest.mark.parametrize("path", FACES, ids=_module)
def test_every_name_of_a_face_is_there(path: Path) -> None:
    """The stub is what types are checked by and what is loaded at run time: each name once."""
    face = importlib.import_module(_module(path))
    stated = [
        alias.asname
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    ]
    assert sorted(set(stated), key=str) == sorted(stated, key=str)
    assert sorted(face.__all__) == sorted(stated, key=str)
    for name in face.__all__:
        assert getattr(face, name) is not None
