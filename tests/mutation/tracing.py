"""A pytest plugin: which lines each test runs, and how long it takes.

Writes coverage data with a context for every test into the file of `TRACED`, and the seconds of those that
passed as JSON into the file of `TIMED`.
"""

from __future__ import annotations

import json
import os
from collections.abc import Generator
from pathlib import Path

import pytest
from coverage import Coverage

from tests.mutation.caches import clear_caches

_SETUP = ""  # the context of what runs outside of any test

_seconds: dict[str, float] = {}
_failed: set[str] = set()
_coverage = Coverage(
    data_file=os.environ["TRACED"], config_file=False, source=[str(Path.cwd() / "benchtool")]
)


def pytest_configure() -> None:
    """Begin before the tests import what is to be traced."""
    _coverage.start()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Give the test, its setup and its teardown one context; nothing is there that others had computed."""
    clear_caches()
    _coverage.switch_context(item.nodeid)
    try:
        return (yield)
    finally:
        _coverage.switch_context(_SETUP)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Note one phase of a test."""
    _seconds[report.nodeid] = _seconds.get(report.nodeid, 0.0) + report.duration
    if report.outcome != "passed":
        _failed.add(report.nodeid)


def pytest_sessionfinish() -> None:
    """Write what was found."""
    _coverage.stop()
    _coverage.save()
    passed = {test: round(seconds, 4) for test, seconds in _seconds.items() if test not in _failed}
    Path(os.environ["TIMED"]).write_text(json.dumps(passed), encoding="utf-8")
