"""A pytest plugin: how long each test took and whether it passed, as JSON into the file of `TIMINGS`."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

_seconds: dict[str, float] = {}
_failed: set[str] = set()


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note one phase of a test."""
    _seconds[report.nodeid] = _seconds.get(report.nodeid, 0.0) + report.duration
    if report.outcome != "passed":
        _failed.add(report.nodeid)


def pytest_sessionfinish() -> None:
    """Write the tests that passed."""
    passed = {test: round(seconds, 4) for test, seconds in _seconds.items() if test not in _failed}
    Path(os.environ["TIMINGS"]).write_text(json.dumps(passed), encoding="utf-8")
