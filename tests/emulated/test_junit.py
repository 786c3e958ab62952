"""`run --junit`: verdicts as CI servers read them, of runs that end and of those that break off."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from datetime import date
from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.cli.junit_file import junit_file
from benchtool.profile import Sensor
from benchtool.recording import bundles_in
from benchtool.report import junit
from benchtool.report.assembly import run_report
from benchtool.report.html import html_page
from benchtool.results import recorded_runs
from benchtool.results.calibration import Overdue

PLAN = """
title = "two laws & <more>"
profile = "zhu2011"
repetitions = 2
judge = "mean"
operating_point = { omega_m_rad_s = 15.71, load_torque_Nm = 0.65, settle_s = 0.2 }
record = { duration_s = 0.21, channels = ["i_a", "torque"] }
limits = { torque_ripple_pp = { max = 0.02 } }
sweep.setup.law = ["foc", "tpc"]
"""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("junit")
    (place / "two.toml").write_text(PLAN, encoding="utf-8")
    arguments = ["run", str(place / "two.toml"), "--out", str(place / "run"), "--operator", "ann"]
    told = CliRunner().invoke(app, [*arguments, "--junit", str(place / "reports" / "out.xml")])
    assert told.exit_code == 1, told.output
    return place


def _root(document: bytes) -> ElementTree.Element:
    return ElementTree.fromstring(document)


def test_every_limit_is_a_test(recorded: Path) -> None:
    root = _root((recorded / "reports" / "out.xml").read_bytes())
    (suite,) = root
    assert suite.get("name") == "two laws & <more>"
    ran = [test for test in suite.iter("testcase") if test.get("name") == "run"]
    assert len(ran) == 4  # two laws, two repetitions
    assert suite.get("skipped") == "0"
    together = [test for test in suite.iter("testcase") if "mean" in str(test.get("name"))]
    assert [str(test.get("classname")).rpartition(".")[2] for test in together] == ["foc", "tpc"]
    failures = [failure for test in together if (failure := test.find("failure")) is not None]
    assert failures
    assert "torque_ripple_pp is" in str(failures[0].get("message"))
    told = [str(output.text) for test in together if (output := test.find("system-out")) is not None]
    assert all("the transducer disagrees: torque_ripple_pp is " in each for each in told)
    for count, kind in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
        assert int(str(suite.get(count))) == len(list(suite.iter(kind))) == int(str(root.get(count)))
    assert int(str(suite.get("tests"))) == len(list(suite.iter("testcase")))
    properties = {each.get("name"): each.get("value") for each in suite.iter("property")}
    assert properties["operator"] == "ann"
    assert properties["firmware"]


def test_a_case_without_a_recording_is_skipped_and_a_broken_one_is_an_error(
    recorded: Path, tmp_path: Path
) -> None:
    run = Path(shutil.copytree(recorded / "run", tmp_path / "run"))
    first, second, *_ = bundles_in(run)
    shutil.rmtree(first)
    for stream in (second / "data").glob("capture.*"):
        stream.unlink()
    (suite,) = _root(junit(recorded_runs(run)))
    assert suite.get("skipped") == "1"
    (skipped,) = (test for test in suite.iter("testcase") if test.find("skipped") is not None)
    assert str(skipped.get("classname")).endswith(first.name)
    assert suite.get("errors") == "1"


def test_the_same_recordings_give_the_same_bytes(recorded: Path) -> None:
    written = (recorded / "reports" / "out.xml").read_bytes()
    assert junit(recorded_runs(recorded / "run")) == written


@pytest.mark.usefixtures("blank_pictures")
def test_a_waived_limit_is_skipped_told_and_does_not_count(tmp_path: Path) -> None:
    once = PLAN.replace("repetitions = 2", 'requirements = ["SRS-1"]').replace('judge = "mean"', "")
    waived = 'max = 0.02, requirement = "SRS-2", waived = { reason = "new filter", by = "ann" }'
    once = (
        once.replace("max = 0.02", waived).replace(', "tpc"', "").replace("settle_s = 0.2", "settle_s = 1.5")
    )
    (tmp_path / "two.toml").write_text(once, encoding="utf-8")
    arguments = ["run", str(tmp_path / "two.toml"), "--out", str(tmp_path / "run"), "--json"]
    told = CliRunner().invoke(app, [*arguments, "--junit", str(tmp_path / "out.xml")])
    assert told.exit_code == 0, told.output
    (case,) = json.loads(told.stdout)["cases"].values()
    assert case["verdict"] == "pass"
    assert case["missed"] == []
    assert "torque_ripple_pp is" in case["waived"]["torque_ripple_pp"]
    assert "waived: torque_ripple_pp is" in told.stderr
    (suite,) = _root((tmp_path / "out.xml").read_bytes())
    (skipped,) = (test for test in suite.iter("testcase") if test.find("skipped") is not None)
    assert str(skipped.find("skipped").get("message")).startswith("waived by ann: new filter: ")  # type: ignore[union-attr]
    assert [each.get("value") for each in skipped.iter("property")] == ["SRS-2"]
    page = html_page(run_report(tmp_path / "run", recorded_runs(tmp_path / "run")))
    for text in ("SRS-1", "SRS-2", "new filter", "torque_ripple_pp (waived)"):
        assert text in page


def test_a_place_that_takes_no_file_is_one_line(tmp_path: Path) -> None:
    once = PLAN.replace("repetitions = 2", "repetitions = 1").replace('judge = "mean"', "")
    (tmp_path / "two.toml").write_text(once.replace(', "tpc"', ""), encoding="utf-8")
    (tmp_path / "file").touch()
    arguments = ["run", str(tmp_path / "two.toml"), "--out", str(tmp_path / "run")]
    told = CliRunner().invoke(app, [*arguments, "--junit", str(tmp_path / "file" / "out.xml")])
    assert told.exit_code == 3
    assert "out.xml" in told.stderr


@pytest.mark.parametrize(
    ("changed", "options", "code", "message"),
    [
        ("torque_ripple_pp = { max = 0.02 }", [], 2, "torque_ripple_qq"),
        ("", ["--link", "serial:/dev/no-such-port"], 3, "/dev/no-such-port"),
        ("", ["--resume", "no-such-run"], 2, "no-such-run does not exist"),
    ],
)
def test_a_run_that_ends_with_an_error_writes_it_in_place_of_an_earlier_file(
    tmp_path: Path, changed: str, options: list[str], code: int, message: str
) -> None:
    text = PLAN.replace("torque_ripple_pp", "torque_ripple_qq") if changed else PLAN
    (tmp_path / "two.toml").write_text(text, encoding="utf-8")
    (tmp_path / "out.xml").write_text("an earlier one", encoding="utf-8")
    out = [] if "--resume" in options else ["--out", str(tmp_path / "run")]
    arguments = ["run", str(tmp_path / "two.toml"), *out, *options]
    told = CliRunner().invoke(app, [*arguments, "--junit", str(tmp_path / "out.xml")])
    assert told.exit_code == code
    root = _root((tmp_path / "out.xml").read_bytes())
    (test,) = root.iter("testcase")
    (error,) = test.iter("error")
    assert message in str(error.get("message"))
    assert str(error.get("message")) in told.stderr
    assert (root.get("tests"), root.get("errors")) == ("1", "1")


def test_a_run_that_breaks_off_has_its_error_beside_what_was_recorded(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt), junit_file("two.toml", tmp_path / "out.xml") as file:
        file.folder = recorded / "run"
        raise KeyboardInterrupt
    whole, broken = _root((tmp_path / "out.xml").read_bytes())
    assert len(list(whole.iter("testcase"))) > 4
    (error,) = broken.iter("error")
    assert (broken.get("name"), error.get("message")) == ("two.toml", "interrupted")


def test_overdue_calibrations_are_told(recorded: Path) -> None:
    late = Overdue("i_a", Sensor(sensor="LEM", due=date(2026, 1, 1)), date(2026, 1, 3))
    (run,) = recorded_runs(recorded / "run")
    first, *others = run.cases
    assert first.assessment is not None
    first = replace(first, assessment=replace(first.assessment, overdue=(late,)))
    (suite,) = _root(junit([replace(run, cases=(first, *others))]))
    properties = {each.get("name"): each.get("value") for each in suite.iter("property")}
    assert properties["calibration overdue"] == str(late)
    told = [str(each.text) for each in suite.iter("system-out") if f"warning: {late}" in str(each.text)]
    assert len(told) == 1
