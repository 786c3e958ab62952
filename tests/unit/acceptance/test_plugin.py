"""The pytest plugin: outcomes, limits, waivers, safe states, JUnit XML, report and record of a session."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from benchtool.acceptance.session_log import SessionLog
from benchtool.acceptance.settings import Settings, require_usable
from benchtool.errors import RecordingError, UsageError
from benchtool.plan import Verdict
from benchtool.recording import SESSION
from benchtool.results import Outcome, read_session, verify_run

from .nested import Ran, run_pytest

TESTS = '''
import pytest
from matplotlib.figure import Figure

@pytest.mark.requirement("R-1", "R-2")
def test_passes(drive, measure, attach):
    """The drive is one of ours."""
    measure("vendor_id", drive.identity.vendor_id, min=2940, max=2940, requirement="R-3")
    attach.text("answer.txt", "forty-two")
    attach.picture("empty", lambda: Figure(figsize=(2, 1)))

@pytest.mark.requirement("R-2")
def test_limits(measure):
    measure("guarded", 0.95, "Nm", max=1.0, margin="U", uncertainty=0.1)
    measure("nan", float("nan"), "Nm", max=1.0)
    measure("missing", None, "Nm", max=1.0, reason="no sensor")
    measure("met", 0.5, "Nm", max=1.0)

def test_measures_nothing(measure):
    pass

def test_skipped(bench):
    pytest.skip("no load machine")

@pytest.mark.waived("known since 2026", by="ann")
def test_waived(measure):
    measure("beyond", 3.0, "", max=1.0)

@pytest.mark.waived("long over", by="ann", until="2020-01-01")
def test_waived_once(measure):
    measure("beyond", 3.0, "", max=1.0)

def test_fault(bench_session):
    bench_session.drive.write("u_dc_max", 100.0)
    bench_session.drive.wait(0.1)

def test_left_enabled(drive):
    drive.enable("velocity")

def test_left_in_fault(bench_session):
    bench_session.drive.write("u_dc_max", 100.0)
    bench_session.clock.wait(0.1)

def test_reads_an_emergency(bench_session):
    bench_session.drive.write("u_dc_max", 100.0)
    bench_session.clock.wait(0.1)
    bench_session.drive.emergencies()
    bench_session.drive.write("u_dc_max", 400.0)
    bench_session.drive.reset_fault()

def test_injects_a_fault(bench, inject_fault):
    from benchtool.errors import DriveFault
    inject_fault("dc_link_sag@0.3")
    inject_fault("frames_duplicated")
    with pytest.raises(DriveFault, match="undervoltage"), bench.drive.enabled("velocity") as running:
        bench.wait(1.0)

def test_injects_what_does_not_end(bench_session, inject_fault):
    inject_fault("frames_duplicated")
    bench_session.drive.write("u_dc_max", 100.0)
    bench_session.clock.wait(0.1)
'''


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("acceptance")


@pytest.fixture(scope="module")
def ran(place: Path) -> Ran:
    words = ("--bench", "zhu2011", "--bench-out", str(place / "out"), "--junitxml", str(place / "j.xml"))
    return run_pytest(
        place, TESTS, *words, "--bench-operator", "ann", "--bench-serial-number", "M-7", "--bench-pdf"
    )


@pytest.mark.parametrize(
    ("name", "outcome", "told"),
    [
        ("test_passes", Outcome.PASSED, ""),
        ("test_limits", Outcome.FAILED, "missing was not measured (no sensor), ≤ 1 Nm is asked for"),
        ("test_measures_nothing", Outcome.FAILED, "nothing was measured"),
        ("test_skipped", Outcome.NOT_RUN, "no load machine"),
        ("test_waived", Outcome.WAIVED, "beyond is 3"),
        ("test_waived_once", Outcome.FAILED, "beyond is 3"),
        ("test_fault", Outcome.FAILED, "0x3210 dc link overvoltage"),
        ("test_left_enabled", Outcome.ERROR, "a power stage that is off is expected"),
        ("test_left_in_fault", Outcome.ERROR, "the drive is in 'fault'"),
        ("test_reads_an_emergency", Outcome.PASSED, ""),
        ("test_injects_a_fault", Outcome.PASSED, ""),
        ("test_injects_what_does_not_end", Outcome.ERROR, "the drive is in 'fault'"),
    ],
)
def test_outcomes(ran: Ran, name: str, outcome: Outcome, told: str) -> None:
    assert ran[name].outcome is outcome, ran.text
    assert told in ran[name].reason


def test_limits_keep_value_rule_and_verdict(ran: Ran) -> None:
    judged = {each.name: each for each in ran["test_limits"].judged}
    assert {name: each.verdict for name, each in judged.items()} == {
        "guarded": "undecided",
        "nan": "fail",
        "missing": "fail",
        "met": "pass",
    }
    guarded = judged["guarded"]
    assert guarded.limit.rule == "guard band U (95 %)"
    assert guarded.conformance == pytest.approx(0.691, abs=1e-3)  # ndtr(0.5)
    assert judged["nan"].value is None


def test_requirements_have_their_worst_outcome(ran: Ran) -> None:
    assert ran.record is not None
    assert ran.record.requirements == {"R-1": "passed", "R-2": "failed", "R-3": "passed"}
    assert ran.record.verdict is Verdict.FAIL


def test_the_record_is_sealed_and_verified(ran: Ran, place: Path) -> None:
    folder = place / "out"
    assert ran.record is not None
    assert read_session(folder).tests == ran.record.tests
    found = verify_run(folder)
    assert found.holds, (found.damaged, found.different)
    assert verify_run(folder / "report.html").holds
    assert verify_run(folder / "report.pdf").holds
    content = (folder / SESSION).read_bytes()
    try:
        (folder / SESSION).write_bytes(content.replace(b'"guarded"', b'"guardee"'))
        assert not verify_run(folder).holds
        with pytest.raises(RecordingError, match="does not fit its seal"):
            read_session(folder)
    finally:
        (folder / SESSION).write_bytes(content)


def test_a_session_without_hashes_is_not_told_from_another(ran: Ran, place: Path, tmp_path: Path) -> None:
    folder = Path(shutil.copytree(place / "out", tmp_path / "out"))
    (folder / "hashes.json").unlink()
    assert "no hash" in verify_run(folder).damaged[SESSION]


def test_an_earlier_session_is_not_replaced(ran: Ran, place: Path) -> None:
    stored = (place / "out" / SESSION).read_bytes()
    words = ("--bench", "zhu2011", "--bench-out", str(place / "out"))
    again = run_pytest(place, "def test_it(measure):\n    measure('x', 1.0, below=2.0)\n", *words)
    assert again.code == pytest.ExitCode.USAGE_ERROR
    assert "has content" in again.text
    assert (place / "out" / SESSION).read_bytes() == stored


def test_the_first_page_has_what_is_signed(ran: Ran, place: Path) -> None:
    page = (place / "out" / "report.html").read_text(encoding="utf-8")
    above, signed, below = page.partition("Tested by")
    assert signed
    for text in (
        "serial number M-7",
        "benchtool reference drive",
        "R-2",
        "known since 2026",
        "no load machine",
        "Guard band U (95 %): 1 limit.",
        "Simple acceptance: 6 limits.",
    ):
        assert text in above
    assert "what it asks" not in above
    assert "what it asks" in below
    assert "0 earlier sessions" in below


def test_pictures_and_texts_are_kept_with_the_test(ran: Ran, place: Path) -> None:
    paths = {each.name: place / "out" / each.path for each in ran["test_passes"].attachments}
    assert paths["answer.txt"].read_text(encoding="utf-8") == "forty-two"
    assert paths["empty"].read_bytes().startswith(b"\x89PNG")
    assert "state: " in paths["log"].read_text(encoding="utf-8")


def test_junit_names_drive_operator_and_requirements(ran: Ran, place: Path) -> None:
    assert ran.code == 1
    root = ElementTree.parse(place / "j.xml").getroot()
    (suite,) = root
    named = {each.get("name"): each.get("value") for each in suite.findall("properties/property")}
    assert named["drive"] == "benchtool reference drive"
    assert named["firmware"] == "0.1.0"
    assert (named["operator"], named["test object"], named["profile"]) == ("ann", "M-7", "zhu2011")
    (case,) = [each for each in suite.iter("testcase") if each.get("name") == "test_passes"]
    properties = [(each.get("name"), each.get("value")) for each in case.iter("property")]
    assert ("requirement", "R-2") in properties
    assert ("measured vendor_id", "2940.0") in properties


def test_without_a_bench_the_fixtures_say_what_to_give(tmp_path: Path) -> None:
    ran = run_pytest(tmp_path, "def test_it(drive): pass\ndef test_plain(): pass\n")
    assert ran.record is None
    assert "give --bench PROFILE" in ran.text
    assert "1 passed" in ran.text


def test_an_operating_point_that_is_not_reached_fails(tmp_path: Path) -> None:
    plan = {
        "title": "too fast for the dc link",
        "profile": "zhu2011",
        "operating_point": {"omega_m_rad_s": 157.0, "load_torque_Nm": 6.0, "settle_s": 0.5},
        "record": {"duration_s": 0.1, "channels": ["omega_m", "torque", "u_dc"]},
        "analyses": {"steady": False},
    }
    source = f"import benchtool\ndef test_it(run_plan):\n    run_plan(benchtool.Plan(**{plan!r}))\n"
    ran = run_pytest(tmp_path, source, "--bench", "zhu2011", "--bench-out", str(tmp_path / "out"))
    assert ran["test_it"].outcome is Outcome.FAILED
    assert "omega_m_reached is " in ran["test_it"].reason
    (bundle,) = [each for each in ran["test_it"].attachments if each.name != "log"]
    assert (tmp_path / "out" / bundle.path / "manifest.json").is_file()
    assert verify_run(tmp_path / "out").holds
    shutil.rmtree(tmp_path / "out" / bundle.path)
    assert list(verify_run(tmp_path / "out").damaged) == [f"{bundle.path}/manifest.json"]


def test_a_log_that_cannot_be_kept_ends_no_session(tmp_path: Path) -> None:
    source = "def test_it(attach):\n    own = attach.folder\n    own.rmdir()\n    own.touch()\n    assert 0\n"
    ran = run_pytest(tmp_path, source, "--bench", "zhu2011", "--bench-out", str(tmp_path / "out"))
    assert ran.code == pytest.ExitCode.TESTS_FAILED, ran.text
    (note,) = ran["test_it"].notes
    assert note.startswith("its log was not kept: cannot write ")


def test_a_file_of_waivers(tmp_path: Path) -> None:
    source = (
        "import pytest\n"
        "@pytest.mark.requirement('R-9')\n"
        "def test_a(measure): measure('x', 2, '', max=1)\n"
        "def test_b(measure): measure('x', 2, '', max=1)\n"
    )
    waivers = tmp_path / "waivers.toml"
    waivers.write_text(
        '[[waiver]]\nrequirement = "R-9"\nreason = "next release"\nby = "bob"\n', encoding="utf-8"
    )
    ran = run_pytest(tmp_path, source, "--bench", "zhu2011", "--bench-bare", "--bench-waivers", str(waivers))
    assert (ran["test_a"].outcome, ran["test_b"].outcome) == (Outcome.WAIVED, Outcome.FAILED)
    waivers.write_text('[[waiver]]\ntest = "*"\nreason = ""\nby = "bob"\n', encoding="utf-8")
    ran = run_pytest(tmp_path, source, "--bench", "zhu2011", "--bench-bare", "--bench-waivers", str(waivers))
    assert ran.code == 4
    assert "a sentence and a name are expected" in ran.text


class _AsWorker:
    """Has a session be that of a worker of pytest-xdist, and keeps what it would send."""

    def __init__(self, out: Path) -> None:
        self._out = out
        self.sent: list[dict[str, Any]] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_configure(self, config: pytest.Config) -> None:
        config.workerinput = {"benchtool_out": str(self._out)}  # type: ignore[attr-defined]
        self._config = config

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        hook = self._config.hook
        self.sent.append(hook.pytest_report_to_serializable(config=self._config, report=report))


def test_a_worker_sends_its_records_to_the_process_that_reports(tmp_path: Path) -> None:
    """Each worker opens a bench of its own, as every test does; the report is written once."""
    worker = _AsWorker(tmp_path / "out")
    source = "def test_a(drive, measure): measure('vendor', drive.identity.vendor_id, min=1)\n"
    ran = run_pytest(tmp_path, source, "--bench", "zhu2011", plugins=(worker,))
    assert ran.record is None
    assert not (tmp_path / "out" / SESSION).exists()
    log = SessionLog(Settings("zhu2011", "emulated", tmp_path / "out"), ran.config)
    for each in json.loads(json.dumps(worker.sent)):  # execnet carries plain values only
        log.pytest_runtest_logreport(pytest.TestReport._from_json(each))
    (test,) = log.record().tests
    assert test.outcome is Outcome.PASSED
    assert test.judged[0].value == log.record().identity["vendor_id"] == 2940


def test_workers_do_not_share_a_real_drive() -> None:
    require_usable("zhu2011", "emulated", workers=4)
    require_usable("zhu2011", "can:virtual:0", workers=1)
    with pytest.raises(UsageError, match="2 workers would share the drive"):
        require_usable("zhu2011", "can:virtual:0", workers=2)
