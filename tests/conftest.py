"""Fixtures of all tests: no thread outlives its test. And how the suite is spread over its workers."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
from collections import Counter
from collections.abc import Generator, Iterator
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Final

import pytest
from hypothesis import HealthCheck, settings
from hypothesis.internal.conjecture import providers

# As in the command line, before numpy is imported, here and in the workers: further threads of linear algebra
# take the processor from the other tests.
os.environ.setdefault("OMP_NUM_THREADS", "1")
# What one process has compiled, the other workers and some hundred child processes read.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.pop("COLUMNS", None)  # of the shell, by which tables would be laid out

from benchtool.cli.exit_codes import OBJECTS
from benchtool.link import import_can_without_mdf

sys.dont_write_bytecode = False
# A background job of a shell ignores Ctrl-C, and so would the workers and what they start.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Generated examples are the same in every run, and a busy machine fails no test. Others, and more of them, by
# `--hypothesis-profile=thorough`.
settings.register_profile(
    "reproducible",
    derandomize=True,
    max_examples=50,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.register_profile(
    "thorough", max_examples=1000, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("reproducible")

import_can_without_mdf()


def _not_flushed(fd: object) -> None:
    """Take the place of `os.fsync`: a test survives no loss of power, and flushing waits for the disk."""


os.fsync = _not_flushed

LONGEST_FIRST: Final = (
    "tests/checks/test_source.py",
    "tests/docs/test_blocks.py",
    "tests/packaging/test_wheel.py",
    "tests/docs/test_build.py",
    "tests/device/test_library.py",
    "tests/physics/test_every_part.py",
    "tests/emulated/test_report.py",
    "tests/emulated/test_emulate.py",
    "tests/unit/analysis/steps/test_step.py",
    "tests/unit/analysis/torque/test_ripple_numbers.py",
    "tests/emulated/test_analyze_csv.py",
    "tests/emulated/test_verify.py",
    "tests/device/test_can_drive.py",
    "tests/emulated/test_runs.py",
    "tests/unit/analysis/torque/test_slow_lines.py",
    "tests/device/test_posix_drive.py",
    "tests/physics/test_flange.py",
    "tests/unit/analysis/quantisation/test_few_steps.py",
    "tests/emulated/test_live.py",
    "tests/emulated/test_control_rates.py",
    "tests/unit/analysis/test_coverage.py",
    "tests/emulated/test_paper.py",
    "tests/emulated/test_command_line.py",
    "tests/unit/live/test_viewer.py",
    "tests/unit/analysis/responses/test_frequency_response.py",
    "tests/unit/analysis/steps/test_step_rest.py",
    "tests/emulated/test_commission_saving.py",
    "tests/unit/tables/test_names_between.py",
    "tests/physics/test_compilation.py",
    "tests/emulated/test_verdict_lines.py",
    "tests/emulated/test_analyze_csv_sensors.py",
    "tests/emulated/test_index.py",
    "tests/unit/acceptance/test_suite.py",
    "tests/device/test_can_checks.py",
    "tests/unit/analysis/spectra/test_close_lines.py",
    "tests/emulated/test_record.py",
    "tests/emulated/api/test_examples.py",
    "tests/emulated/test_terminal.py",
    "tests/docs/test_json_documents.py",
    "tests/unit/report/test_figures.py",
    "tests/unit/results/test_calibration.py",
    "tests/unit/analysis/test_steady_state.py",
    "tests/emulated/test_junit.py",
    "tests/unit/analysis/lines/test_lines.py",
    "tests/emulated/api/test_runs.py",
    "tests/emulated/test_commission.py",
    "tests/unit/recording/test_integrity.py",
    "tests/emulated/test_motors.py",
)
"""Files that take seven seconds and more. A worker takes file after file: one of these at the end, and the
others wait. Kernels are compiled one at a time: what needs none begins beside what compiles the first."""


@pytest.hookimpl(wrapper=True, trylast=True)
def pytest_collection(session: pytest.Session) -> Generator[None, object, object]:
    """Collect without Python's collector, and keep it from what was imported: it would look through some
    millions of objects that all stay, again and again."""
    gc.disable()
    try:
        whole = session.config.args_source is pytest.Config.ArgsSource.TESTPATHS
        if whole and hasattr(session.config, "workerinput"):
            _import_tests(session.config.rootpath, **session.config.workerinput)
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(OBJECTS)
        gc.enable()


def pytest_configure(config: pytest.Config) -> None:
    """Keep hypothesis from constants of the modules that happen to be imported: examples would differ between
    a file alone and the suite, and a worker parses all sources for them. Thorough runs have them."""
    if config.getoption("--hypothesis-profile") is None:
        providers._get_local_constants = lambda: providers._local_constants


def _import_tests(root: Path, workerid: str, workercount: int, **_: object) -> None:
    """Import all tests, each worker from another one on: to compile them takes longer than to import them,
    and what a worker has compiled the others read."""
    files = sorted((root / "tests").rglob("test_*.py"))
    begin = len(files) * int(workerid.removeprefix("gw")) // workercount
    for file in files[begin:] + files[:begin]:
        with suppress(Exception, pytest.skip.Exception):  # pytest imports the file again, and tells it
            import_module(".".join(file.relative_to(root).with_suffix("").parts))


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Put long files first, then those of many tests; within a file nothing changes."""
    if not hasattr(config, "workerinput"):
        return
    files = {item: item.nodeid.partition("::")[0] for item in items}
    places = {file: place for place, file in enumerate(LONGEST_FIRST)}
    tests = Counter(files.values())
    items.sort(key=lambda item: (places.get(files[item], len(places)), -tests[files[item]], files[item]))


@pytest.fixture(autouse=True)
def _no_leaked_threads() -> Iterator[None]:
    before = set(threading.enumerate())
    yield
    leaked = [thread for thread in threading.enumerate() if thread not in before and thread.is_alive()]
    assert not leaked, f"threads outlive the test: {', '.join(thread.name for thread in leaked)}"
