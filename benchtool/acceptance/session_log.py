"""The record of a session in the process that collects the results: JUnit properties, report, trend."""

from __future__ import annotations

import json
import sys
from datetime import datetime
from functools import cached_property
from pathlib import Path
from typing import Any

import pytest

from benchtool.acceptance.settings import Settings
from benchtool.errors import BenchError
from benchtool.profile import profile_path
from benchtool.recording import enlist, software_versions, writing
from benchtool.results import (
    Outcome,
    SessionRecord,
    TestRecord,
    earlier_sessions,
    write_session,
)


class SessionLog:
    """Gathers the records of tests, from this process or from workers, and writes what a session leaves.

    Args:
        settings: of the session.
        config: of pytest.
    """

    def __init__(self, settings: Settings, config: pytest.Config) -> None:
        self._settings = settings
        self._config = config
        self._begun = datetime.now().astimezone()
        self._tests: dict[str, TestRecord] = {}
        self._facts: dict[str, Any] = {}
        self.report: Path | None = None

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: Any) -> None:
        """Tell a worker of pytest-xdist the folder of the session."""
        node.workerinput["benchtool_out"] = str(self._settings.out)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Take the record of a test from its last report."""
        told = getattr(report, "benchtool", None)
        if told is None:
            return
        content = json.loads(told)
        record = TestRecord.model_validate(content["test"])
        self._tests[record.name] = record
        self._facts = {**content["facts"], **self._facts}

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session, exitstatus: int) -> None:
        """Give JUnit XML its properties, and write record and report."""
        record = self.record(interrupted=_interruption(exitstatus))
        for plugin in self._config.pluginmanager.get_plugins():
            if (add := getattr(plugin, "add_global_property", None)) is not None:  # of pytest's JUnit XML
                for name, value in properties(record):
                    add(name, value)
        if self._settings.bare or not self._tests:
            return
        try:
            self.report = self._write(record)
        except BenchError as failed:
            sys.stderr.write(f"benchtool: no report of the session: {failed}\n")
            session.exitstatus = max(exitstatus, pytest.ExitCode.TESTS_FAILED)

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say where the report is, and what was not run or waived."""
        if not self._tests:
            return
        record = self.record()
        counts = ", ".join(f"{count} {outcome}" for outcome, count in record.counts.items() if count)
        terminalreporter.write_line(f"verdict: {record.verdict} ({counts})")
        for each in record.tests:
            if each.outcome in (Outcome.NOT_RUN, Outcome.WAIVED):
                terminalreporter.write_line(f"{each.outcome}: {each.name}: {each.reason}")
        if self.report is not None:
            terminalreporter.write_line(f"report: {self.report}")

    def record(self, interrupted: str = "") -> SessionRecord:
        """Return the record of the session until now."""
        from benchtool.acceptance.scores import shipped_score, suite_hash

        settings = self._settings
        tests = tuple(sorted(self._tests.values(), key=lambda each: each.name))
        profile = self._facts.get("profile_toml") or profile_path(settings.profile).read_text(
            encoding="utf-8"
        )
        return SessionRecord(
            when=self._begun.isoformat(timespec="seconds"),
            profile_name=settings.profile,
            profile_toml=profile,
            link=settings.link,
            identity=self._facts.get("identity", {}),
            versions=self._versions,
            conditions=settings.conditions,
            sensors=tuple(self._facts.get("sensors", ())),
            seed=settings.seed,
            emulator=dict(settings.alter),
            command_line=tuple(self._config.invocation_params.args),
            suite=suite_hash(),
            score=shipped_score(),
            tests=tests,
            interrupted=interrupted,
        )

    @cached_property
    def _versions(self) -> dict[str, str]:
        return software_versions()

    def _write(self, record: SessionRecord) -> Path:
        from benchtool.report import write_report
        from benchtool.report.assembly import session_report

        out = self._settings.out
        with writing(out):
            out.mkdir(parents=True, exist_ok=True)
        files = [write_session(out, record)]
        earlier = earlier_sessions(out, record, self._settings.history)
        page, document = write_report(
            session_report(out, record, earlier), out / "report.html", pdf=self._settings.pdf
        )
        files += [page] if document is None else [page, document]
        attached = {out / each.path for test in record.tests for each in test.attachments}
        enlist(out, [*files, *sorted(path for path in attached if path.exists())])
        return page


def properties(record: SessionRecord) -> list[tuple[str, str]]:
    """Return what JUnit XML says of a session, by name."""
    identity = record.identity
    numbers = ("vendor_id", "product_code", "revision_number", "serial_number")
    pairs = {
        "drive": str(identity.get("device_name", "")),
        **{name: str(identity[name]) for name in numbers if name in identity},
        "hardware": str(identity.get("hardware_version", "")),
        "firmware": str(identity.get("firmware_version", "")),
        "profile": record.profile_name,
        "bench": record.link,
        "operator": record.conditions.operator,
        "test object": record.conditions.test_object_serial_number,
        "commit": record.versions.get("commit", ""),
        "benchtool": record.versions.get("benchtool", ""),
        "suite": record.suite,
        "seed": str(record.seed),
    }
    found = [(name, value) for name, value in pairs.items() if value]
    found += [(f"sensor {each.partition(':')[0]}", each.partition(": ")[2]) for each in record.sensors]
    return [*found, *(("instrument", each) for each in record.conditions.instruments)]


def _interruption(exitstatus: int) -> str:
    if exitstatus == pytest.ExitCode.INTERRUPTED:
        return "the session was interrupted"
    return "pytest failed" if exitstatus == pytest.ExitCode.INTERNAL_ERROR else ""
