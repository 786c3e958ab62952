"""The rules of the source, as tests: format, lint, types, layers, fresh generated files, module length."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BIN = Path(sys.executable).parent
LONGEST_MODULE_LINES = 500
MYPY_CACHE = () if (ROOT / ".mypy_cache").exists() else ("--cache-dir", os.devnull)
"""A cache that is read once, as in a fresh clone, takes a seventh of the time to write."""


@pytest.mark.parametrize(
    "command",
    [
        (BIN / "ruff", "format", "--check", "."),
        (BIN / "ruff", "check", "."),
        (sys.executable, "-m", "tests.few_collections", "mypy", *MYPY_CACHE),
        (BIN / "lint-imports", "--no-cache"),
        (sys.executable, "-m", "firmware_protocol.generate", "--check"),
        (BIN / "dcfchk", "-n", "5", "firmware_protocol/drive.eds"),
    ],
    ids=lambda command: " ".join(Path(str(part)).name for part in command[:4]),
)
def test_tool_is_content(command: tuple[str | Path, ...]) -> None:
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    if command[0] == BIN / "dcfchk":
        assert done.stdout + done.stderr == ""


def test_no_module_is_too_long() -> None:
    lengths = {
        path: len(path.read_text(encoding="utf-8").splitlines())
        for folder in ("benchtool", "firmware_protocol", "tests", "benchmarks", "docs")
        for path in (ROOT / folder).rglob("*.py")
    }
    assert {path: lines for path, lines in lengths.items() if lines > LONGEST_MODULE_LINES} == {}
