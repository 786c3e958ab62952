"""`benchtool analyze --csv` as a test calls it, and what it answers in JSON."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

from typer.testing import CliRunner, Result

from benchtool.cli import app

Invoke = Callable[..., Result]


def analyze(*arguments: str) -> Result:
    """Call the verb in the present folder."""
    return CliRunner().invoke(app, ("analyze", *arguments))


def measured(result: Result) -> dict[str, Any]:
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["verdict"] == "none"
    assert list(document["cases"]) == ["csv"]
    case: dict[str, Any] = document["cases"]["csv"]
    assert set(case) == {"source", "remarks", "measurements", "tables"}
    return case


def values(case: dict[str, Any]) -> dict[str, float | None]:
    return {name: each["value"] for name, each in case["measurements"].items()}
