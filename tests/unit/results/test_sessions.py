"""Records of sessions: verdicts, requirements, waivers, trends, and the report that is made of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchtool.plan import Limit, Verdict
from benchtool.report.assembly import session_report
from benchtool.report.html import html_page
from benchtool.results import (
    Judged,
    Outcome,
    SessionRecord,
    TestRecord,
    Waiver,
    differing_verdicts,
    earlier_sessions,
    read_session,
    values_of,
    write_session,
)
from benchtool.shipped import shipped

PROFILE = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")


def _judged(value: float | None, **given: object) -> Judged:
    found = Judged(name="error", value=value, unit="Nm", limit=Limit(max=1.0), **given)  # type: ignore[arg-type]
    return found.model_copy(update={"verdict": str(found.judge())})


def _test(name: str, outcome: Outcome, value: float | None = 0.5, *requirements: str) -> TestRecord:
    waiver = Waiver(reason="later", by="ann", test=name) if outcome is Outcome.WAIVED else None
    judged = (_judged(value),)
    return TestRecord(name=name, outcome=outcome, requirements=requirements, judged=judged, waiver=waiver)


def _session(when: str, *tests: TestRecord, serial: int = 1) -> SessionRecord:
    return SessionRecord(
        when=when,
        profile_name="zhu2011",
        profile_toml=PROFILE,
        link="emulated",
        identity={"serial_number": serial, "device_name": "drive"},
        tests=tests,
    )


@pytest.mark.parametrize(
    ("outcomes", "verdict"),
    [
        ((Outcome.PASSED, Outcome.NOT_RUN), Verdict.PASS),
        ((Outcome.PASSED, Outcome.WAIVED), Verdict.PASS),
        ((Outcome.PASSED, Outcome.FAILED), Verdict.FAIL),
        ((Outcome.PASSED, Outcome.ERROR), Verdict.FAIL),
        ((Outcome.NOT_RUN,), Verdict.FAIL),
        ((), Verdict.FAIL),
    ],
)
def test_verdict_of_a_session(outcomes: tuple[Outcome, ...], verdict: Verdict) -> None:
    tests = [_test(str(number), each) for number, each in enumerate(outcomes)]
    assert _session("2026-01-01", *tests).verdict is verdict


def test_an_interrupted_session_fails() -> None:
    whole = _session("2026-01-01", _test("a", Outcome.PASSED))
    assert whole.model_copy(update={"interrupted": "the session was interrupted"}).verdict is Verdict.FAIL


def test_an_undecided_limit_leaves_the_session_undecided() -> None:
    limit = Limit(max=1.0, margin="U")
    found = Judged(name="error", value=0.9, unit="Nm", limit=limit, standard=0.1)
    found = found.model_copy(update={"verdict": str(found.judge())})
    test = TestRecord(name="a", outcome=Outcome.FAILED, judged=(found,))
    assert _session("2026-01-01", test).verdict is Verdict.UNDECIDED
    assert "0.1 Nm inside its limit ≤ 1 Nm, less than its U" in found.complaint


def test_a_requirement_has_the_worst_of_its_tests() -> None:
    record = _session(
        "2026-01-01", _test("a", Outcome.PASSED, 0.5, "R-1"), _test("b", Outcome.NOT_RUN, None, "R-1", "R-2")
    )
    assert record.requirements == {"R-1": Outcome.NOT_RUN, "R-2": Outcome.NOT_RUN}


def test_a_verdict_that_does_not_follow_is_found() -> None:
    wrong = _judged(1.5).model_copy(update={"verdict": "pass"})
    record = _session(
        "2026-01-01", TestRecord(name="a", outcome=Outcome.PASSED, judged=(wrong, _judged(0.5)))
    )
    assert dict(differing_verdicts(record)) == {"a: error": "stored is pass, value and limit give fail"}


def test_sessions_are_compared_with_those_of_the_same_drive(tmp_path: Path) -> None:
    values = {"2026-01-01": 0.50, "2026-01-02": 0.52, "2026-01-03": 0.48}
    for when, value in values.items():
        (tmp_path / when).mkdir()
        write_session(tmp_path / when, _session(when, _test("a", Outcome.PASSED, value)))
    (tmp_path / "another").mkdir()
    write_session(tmp_path / "another", _session("2026-01-02", _test("a", Outcome.PASSED), serial=2))
    (tmp_path / "damaged").mkdir()
    (tmp_path / "damaged" / "session.json").write_text("{}", encoding="utf-8")
    now = _session("2026-01-04", _test("a", Outcome.PASSED, 0.8))
    (tmp_path / "now").mkdir()
    write_session(tmp_path / "now", now)
    earlier = earlier_sessions(tmp_path / "now", read_session(tmp_path / "now"), 10)
    assert [each.when for each in earlier] == list(values)
    assert [each.when for each in earlier_sessions(tmp_path / "now", now, 2)] == list(values)[1:]
    assert values_of(earlier, "a", "error") == tuple(values.values())
    page = html_page(session_report(tmp_path / "now", now, earlier))
    assert "Against the last 3 sessions" in page
    assert "+60.0%" in page  # 0.3 of the 0.5 that 0.5 leaves to 1
