"""The lines of the README are those that CI runs."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_ci_runs_the_readmes_test_line() -> None:
    line = (ROOT / ".ci/run").read_text(encoding="utf-8").splitlines()[-1]
    assert line.endswith(".venv/bin/pytest -n 3")
    assert line in (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
