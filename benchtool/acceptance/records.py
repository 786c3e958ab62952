"""A test of pytest's as a record of a session."""

from __future__ import annotations

import inspect
from collections.abc import Mapping, Sequence
from datetime import date
from typing import TYPE_CHECKING, Any

import pytest

from benchtool.acceptance.waivers import of_marker, waiver_of
from benchtool.errors import BenchError
from benchtool.results import Outcome, TestRecord, Waiver

if TYPE_CHECKING:
    from benchtool.acceptance.notes import Notes


def requirements_of(item: pytest.Item) -> tuple[str, ...]:
    """Return the requirements that a test is evidence for, each once."""
    found = [str(each) for marker in item.iter_markers("requirement") for each in marker.args]
    return tuple(dict.fromkeys(reversed(found)))


def waiver_for(item: pytest.Item, notes: Notes, waivers: Sequence[Waiver], today: date) -> Waiver | None:
    """Return the waiver that holds for a test today, of the session or of its own.

    Raises:
        UsageError: the marker states no reason, no name, or no date.
    """
    own = [of_marker(*marker.args, **marker.kwargs) for marker in item.iter_markers("waived")]
    return waiver_of((*waivers, *own), notes.name, requirements_of(item), today)


def record_of(
    item: pytest.Item,
    notes: Notes,
    stages: Mapping[str, pytest.TestReport],
    waiver: Waiver | None,
) -> TestRecord:
    """Return the record of a test whose stages are over; its log becomes a file."""
    outcome, reason = _outcome(stages)
    _keep_log(notes, stages, outcome)
    judged = {each.requirement: None for each in notes.judged if each.requirement}
    return TestRecord(
        name=notes.name,
        title=_title(item),
        outcome=outcome,
        reason=reason,
        requirements=tuple(dict.fromkeys((*requirements_of(item), *judged))),
        judged=tuple(notes.judged),
        attachments=tuple(notes.attachments),
        notes=tuple(notes.lines),
        waiver=waiver,
        duration_s=sum(each.duration for each in stages.values()),
    )


def _outcome(stages: Mapping[str, pytest.TestReport]) -> tuple[Outcome, str]:
    for stage in ("setup", "teardown"):
        if stage in stages and stages[stage].failed:
            return Outcome.ERROR, _reason(stages[stage])
    call = stages.get("call")
    if call is None or (call.skipped and not hasattr(call, "wasxfail")):
        return Outcome.NOT_RUN, _reason(call or stages["setup"])
    if call.failed:
        return Outcome.FAILED, _reason(call)
    if hasattr(call, "wasxfail"):
        return (Outcome.WAIVED, _reason(call)) if call.skipped else (Outcome.PASSED, "")
    return Outcome.PASSED, ""


def _reason(report: pytest.TestReport) -> str:
    """Return why a stage did not pass: the reason of a skip, or the message of the exception."""
    told: Any = report.longrepr
    if isinstance(told, tuple):
        return str(told[2]).removeprefix("Skipped: ")
    crash = getattr(told, "reprcrash", None)
    return str(crash.message) if crash is not None else report.longreprtext


def _title(item: pytest.Item) -> str:
    """Return the first sentence of the docstring of a test."""
    function = getattr(item, "function", None)
    told = inspect.getdoc(function) or "" if function is not None else ""
    return " ".join(told.partition("\n\n")[0].split()).removesuffix(".")


def _keep_log(notes: Notes, stages: Mapping[str, pytest.TestReport], outcome: Outcome) -> None:
    """Keep what the drive reported and what the test printed, unless the session is bare; a full disk keeps
    no session from its end."""
    if not notes.pictures:
        return
    parts = ["\n".join(notes.events)] if notes.events else []
    for stage, report in stages.items():
        parts += [f"---- {title}\n{content}" for title, content in report.sections]
        if not report.passed and outcome is not Outcome.NOT_RUN:
            parts.append(f"---- {stage}\n{report.longreprtext}")
    if parts:
        try:
            notes.keep("log", "log.txt", ("\n".join(parts) + "\n").encode("utf-8"))
        except BenchError as failed:
            notes.lines.append(f"its log was not kept: {failed}")
