"""Recorded runs as JUnit XML, which CI servers show: a suite for each plan, a test for each limit of a case.

The elements are those of the schema that Jenkins' xunit plug-in publishes (junit-10.xsd), which GitLab and
GitHub's reporters read too. A limit that is missed or undecided is a failure, a case that broke off an error,
a case of the plan without a recording skipped.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from benchtool.analysis import with_expanded
from benchtool.plan import Limit, Verdict
from benchtool.recording import writing
from benchtool.report.provenance import run_facts
from benchtool.results import Assessment, RecordedCase, RecordedRun

_NOT_IN_XML: Final = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_junit(runs: Sequence[RecordedRun], path: Path) -> None:
    """Write the document; its folder is made.

    Raises:
        RecordingError: it cannot be written.
    """
    with writing(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(junit(runs))


def junit(runs: Sequence[RecordedRun]) -> bytes:
    """Return the document, in UTF-8; the same for the same recordings."""
    root = ElementTree.Element("testsuites", name="benchtool")
    for run in runs:
        root.append(_suite(run))
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
    for case in run.cases:
        _tests_of(suite, f"{title}.{_text(case.name)}", case)
    for group, together in run.repeated.items():
        for each in together:
            if each.limit is not None:
                judged = each.judged
                value = "not measured"
                if judged is not None:
                    value = f"{with_expanded(judged.value, judged.uncertainty)} {each.unit}".rstrip()
                test = _test(
                    suite, f"{title}.{_text(group)}", f"{each.name} {each.limit.bounds}, {each.judge}"
                )
                _judge(
                    *(test, each.verdict, str(each.missed or each.waived or "")),
                    *(f"{value}, {each.limit.rule}", each.limit),
                )
    for name in run.missing:
        test = _test(suite, f"{title}.{_text(name)}", "run")
        ElementTree.SubElement(test, "skipped", message="the case has no recording")
    tests = suite.findall("testcase")
    suite.set("tests", str(len(tests)))
    for count, kind in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        suite.set(count, str(sum(test.find(kind) is not None for test in tests)))
    return suite


def _tests_of(suite: ElementTree.Element, place: str, case: RecordedCase) -> None:
    """Append the tests of a case: that it ran, and each of its limits."""
    ran = _test(suite, place, "run")
    if case.failure or not case.bundle.complete:
        why = _text(case.failure or "the run was cut short")
        ElementTree.SubElement(ran, "error", message=why, type="failed").text = why
    output = ElementTree.SubElement(ran, "system-out")
    output.text = _text(f"bundle: {case.bundle.directory}")
    if case.assessment is None:
        return
    result = case.assessment
    missed = {each.name: str(each) for each in (*result.missed, *result.waived)}
    for name, verdict in case.assessment.verdicts.items():
        limit = case.assessment.limits[name]
        test = _test(suite, place, f"{name} {limit.bounds}")
        _judge(
            test, verdict, missed.get(name, ""), f"{_measured(case.assessment, name)}, {limit.rule}", limit
        )


def _measured(result: Assessment, name: str) -> str:
    measurement = result.found.get(name)
    if measurement is None:
        return f"{name}: not measured"
    value = with_expanded(measurement.value, measurement.uncertainty)
    return f"{name}: {value} {measurement.unit}".rstrip()


def _judge(test: ElementTree.Element, verdict: Verdict, missed: str, measured: str, limit: Limit) -> None:
    if limit.requirement:
        properties = ElementTree.SubElement(test, "properties")
        ElementTree.SubElement(properties, "property", name="requirement", value=_text(limit.requirement))
    if not verdict.met and limit.waived is not None:
        why = _text(f"waived by {limit.waived.by}: {limit.waived.reason}: {missed}")
        ElementTree.SubElement(test, "skipped", message=why)
    elif not verdict.met:
        failure = ElementTree.SubElement(test, "failure", message=_text(missed), type=str(verdict))
        failure.text = _text(missed)
    output = ElementTree.SubElement(test, "system-out")
    output.text = _text(f"{verdict}: {measured}")


def _test(suite: ElementTree.Element, place: str, name: str) -> ElementTree.Element:
    return ElementTree.SubElement(suite, "testcase", classname=place, name=_text(name))


def _text(text: str) -> str:
    """Return a text without the characters that XML 1.0 does not allow."""
    return _NOT_IN_XML.sub("\ufffd", text)
