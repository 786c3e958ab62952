"""Recorded runs as JUnit XML, which CI servers show: a suite for each plan, a test for each limit of a case.

The elements are those of the schema that Jenkins' xunit plug-in publishes (junit-10.xsd), which GitLab and
GitHub's reporters read too. A limit that is missed or undecided is a failure, a case that broke off an error,
a case of the plan without a recording skipped. A run that ended with an error has a suite of that beside.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from benchtool.plan import JudgedLimit
from benchtool.recording import writing
from benchtool.report.provenance import run_facts
from benchtool.results import Disagreement, RecordedCase, RecordedRun, judged_together

_NOT_IN_XML: Final = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


@dataclass(frozen=True)
class BrokenOff:
    """The error that ended the run of a plan; the first line of `reason` says what it is."""

    plan: str
    reason: str


def write_junit(runs: Sequence[RecordedRun], path: Path, broken_off: BrokenOff | None = None) -> None:
    """Write the document; its folder is made.

    Raises:
        RecordingError: it cannot be written.
    """
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(junit(runs, broken_off))


def junit(runs: Sequence[RecordedRun], broken_off: BrokenOff | None = None) -> bytes:
    """Return the document, in UTF-8; the same for the same recordings."""
    root = ElementTree.Element("testsuites", name="benchtool")
    for run in runs:
        root.append(_suite(run))
    if broken_off is not None:
        root.append(_suite_of_error(broken_off))
    for count in ("tests", "failures", "errors", "skipped"):
        root.set(count, str(sum(int(suite.get(count, "0")) for suite in root)))
    ElementTree.indent(root)
    document: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return document + b"\n"


def _suite(run: RecordedRun) -> ElementTree.Element:
    manifest = run.cases[0].bundle.manifest
    title = _text(run.name or manifest.what)
    suite = ElementTree.Element("testsuite", name=title, timestamp=manifest.when)
    properties = ElementTree.SubElement(suite, "properties")
    for name, value in run_facts(manifest).pairs:
        ElementTree.SubElement(properties, "property", name=name, value=_text(value))
    assessed = [case.assessment for case in run.cases if case.assessment is not None]
    if late := "; ".join(dict.fromkeys(str(one) for each in assessed for one in each.overdue)):
        ElementTree.SubElement(properties, "property", name="calibration overdue", value=_text(late))
    for case in run.cases:
        _tests_of(suite, f"{title}.{_text(case.name)}", case)
    for group, each in judged_together(run.repeated):
        name = f"{each.name} {each.limit.bounds}, {each.judge}"
        _judge(suite, f"{title}.{_text(group)}", name, each, each.disagreement)
    for name in run.missing:
        test = _test(suite, f"{title}.{_text(name)}", "run")
        ElementTree.SubElement(test, "skipped", message="the case has no recording")
    return _counted(suite)


def _suite_of_error(broken_off: BrokenOff) -> ElementTree.Element:
    """Return the suite of a run that ended with an error: one test, which has it."""
    suite = ElementTree.Element("testsuite", name=_text(broken_off.plan))
    _broken(_test(suite, _text(broken_off.plan), "benchtool run"), broken_off.reason)
    return _counted(suite)


def _broken(test: ElementTree.Element, reason: str) -> None:
    """Append to a test that it ended with an error."""
    first, *_ = reason.splitlines() or [""]
    ElementTree.SubElement(test, "error", message=_text(first), type="failed").text = _text(reason)


def _counted(suite: ElementTree.Element) -> ElementTree.Element:
    """Return a suite with the counts of its tests."""
    tests = suite.findall("testcase")
    suite.set("tests", str(len(tests)))
    for count, kind in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        suite.set(count, str(sum(test.find(kind) is not None for test in tests)))
    return suite


def _tests_of(suite: ElementTree.Element, place: str, case: RecordedCase) -> None:
    """Append the tests of a case: that it ran, and each of its limits."""
    ran = _test(suite, place, "run")
    if case.failure or not case.bundle.complete:
        _broken(ran, case.failure or "the run was cut short")
    output = ElementTree.SubElement(ran, "system-out")
    late = () if case.assessment is None else case.assessment.overdue
    lines = f"bundle: {case.bundle.directory}", *(f"warning: {each}" for each in late)
    output.text = _text("\n".join(lines))
    if case.assessment is None:
        return
    contradicted = {each.name: each for each in case.assessment.disagreements}
    for each in case.assessment.judged.values():
        _judge(suite, place, f"{each.name} {each.limit.bounds}", each, contradicted.get(each.name))


def _judge(
    suite: ElementTree.Element,
    place: str,
    name: str,
    judged: JudgedLimit,
    contradicted: Disagreement | None,
) -> None:
    """Append the test of a limit, with what was measured, the decision rule, and the transducer's number
    where that contradicts it."""
    test, limit, told = _test(suite, place, name), judged.limit, str(judged.told or "")
    if limit.requirement:
        properties = ElementTree.SubElement(test, "properties")
        ElementTree.SubElement(properties, "property", name="requirement", value=_text(limit.requirement))
    if judged.waived and limit.waived is not None:
        why = _text(f"waived by {limit.waived.by}: {limit.waived.reason}: {told}")
        ElementTree.SubElement(test, "skipped", message=why)
    elif not judged.verdict.met:
        failure = ElementTree.SubElement(test, "failure", message=_text(told), type=str(judged.verdict))
        failure.text = _text(told)
    value = "not measured"
    if (measured := judged.measured) is not None:
        value = measured.in_unit
    output = ElementTree.SubElement(test, "system-out")
    shaft = "" if contradicted is None else f"; the transducer disagrees: {contradicted}"
    output.text = _text(f"{judged.verdict}: {judged.name}: {value}, {limit.rule}{shaft}")


def _test(suite: ElementTree.Element, place: str, name: str) -> ElementTree.Element:
    return ElementTree.SubElement(suite, "testcase", classname=place, name=_text(name))


def _text(text: str) -> str:
    """Return a text without the characters that XML 1.0 does not allow."""
    return _NOT_IN_XML.sub("\ufffd", text)
