"""`benchtool report` and `benchtool compare` on recorded runs, whole and broken."""

from __future__ import annotations

import hashlib
import html
import json
import re
import shlex
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app
from benchtool.recording.seal import write_json
from benchtool.results import verify_run
from benchtool.shipped import shipped

PLAN = (shipped("profiles") / "zhu2011" / "ripple.toml").read_text(encoding="utf-8")
SHORT = """
title = "Two laws"
profile = "zhu2011"
figure = "torque"
[operating_point]
omega_m_rad_s = 31.42
load_torque_Nm = 0.3
settle_s = 0.4
[sweep.setup]
law = ["tpc", "foc"]
[record]
duration_s = 0.25
channels = ["i_a", "i_b", "i_c", "torque", "torque_reference", "psi_s", "theta_m", "switching_count"]
[case_limits.foc]
torque_ripple_pp = { max = 0.1 }
"""

blank = pytest.mark.usefixtures("blank_pictures")


def invoke(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(each) for each in arguments])


def done(*arguments: object, code: int = 0) -> Result:
    result = invoke(*arguments)
    assert result.exit_code == code, result.output
    return result


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder `demo`, and `plans` with one plan of one case and one of two."""
    folder = tmp_path_factory.mktemp("recorded")
    done("demo", "--out", folder / "demo")
    plans = folder / "toml"
    plans.mkdir()
    (plans / "one.toml").write_text(PLAN, encoding="utf-8")
    (plans / "two.toml").write_text(SHORT, encoding="utf-8")
    done("run", plans, "--out", folder / "plans")
    return folder


@pytest.fixture(scope="module")
def reported(recorded: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Result]:
    """A bundle of the demo with page, PDF and pictures, and what the command told."""
    bundle = Path(shutil.copytree(recorded / "demo", tmp_path_factory.mktemp("reported") / "demo"))
    return bundle, done("report", bundle, "--pdf", "--png", "--json")


@pytest.fixture
def demo(recorded: Path, tmp_path: Path) -> Path:
    """A bundle of its own to be changed."""
    return Path(shutil.copytree(recorded / "demo", tmp_path / "demo"))


def change(bundle: Path, alter: Callable[[dict[str, Any]], None]) -> None:
    path = bundle / "manifest.json"
    document = json.loads(path.read_text(encoding="utf-8"))
    del document["seal"]
    alter(document)
    write_json(path, document, sealed=True)


def page_of(bundle: Path, *options: str, code: int = 0) -> str:
    done("report", bundle, *options, code=code)
    return (bundle / "report.html").read_text(encoding="utf-8")


def text_of(page: str) -> str:
    return " ".join(re.sub(r"<[^>]*>", " ", page.partition("</style>")[2]).split())


def test_the_report_of_the_demo(reported: tuple[Path, Result]) -> None:
    demo, result = reported
    names = ("waveforms", "current_spectrum", "flux_trajectory", "switching_states")
    pictures = {str(demo / "plots" / f"{name}.png") for name in names}
    assert json.loads(result.stdout) == {
        "report": str(demo / "report.html"),
        "pdf": str(demo / "report.pdf"),
        "verdict": "pass",
        "cases": {"tpc": {"verdict": "pass", "bundle": str(demo)}},
        "pictures": sorted(pictures, key=lambda path: names.index(Path(path).stem)),
    }
    assert all(Path(path).read_bytes().startswith(b"\x89PNG") for path in pictures)
    assert "pass by the drive's own estimate, fail by the transducer on the shaft" in result.stderr
    page = (demo / "report.html").read_text(encoding="utf-8")
    text = text_of(page)
    order = (
        "✓ Pass 5 of 5 limits met.",
        "benchtool reference drive",
        "Limits and verdicts",
        "≤ 0.06",
        "Every case of the plan was run, and every limit was put to a number.",
        "Tested by: name, date, signature",
        "Figures",
        "Torque, phase currents and stator flux",
        "Measurements",
        "torque_mean",
        "Maximum minus minimum of the drive",
        "Tables",
        "current_harmonics",
        "Appendix",
        "Data quality",
        "Complete: every row of every stream is there.",
        "Drive parameters",
        "differs",
        "Plan",
        "record.duration_s 0.52",
        "Choices of the profile",
        "How to compute this again",
        "theta_m (rad)",
    )
    places = [text.find(each) for each in order]
    assert all(place >= 0 for place in places), dict(zip(order, places, strict=True))
    assert places == sorted(places)
    analysed = json.loads(done("analyze", demo, "--json").stdout)["cases"]["tpc"]
    for name in (*analysed["measurements"], *analysed["tables"]):
        assert name in text
    for file in (demo / "data").iterdir():
        assert hashlib.sha256(file.read_bytes()).hexdigest() in text
    document = (demo / "report.pdf").read_bytes()
    assert document.startswith(b"%PDF-")
    assert document.count(b"/Type /Page\n") <= 7
    assert (
        page.count(f"<code>{hashlib.sha256((demo / 'manifest.json').read_bytes()).hexdigest()}</code>") == 1
    )


@blank
def test_the_first_page_says_what_was_tested_and_by_whom(demo: Path) -> None:
    def state(manifest: dict[str, Any]) -> None:
        manifest["conditions"] |= {"operator": "A. Ampère", "test_object_serial_number": "M-17"}
        manifest["details"]["plan"]["limits"]["torque_ripple_pp"] = {"max": 0.051, "margin": "U"}

    front = text_of(page_of(demo)).partition("Figures")[0]
    for told in ("serial number not stated", "operator not stated", "rated 9.55 Nm", "serial number 1"):
        assert told in front
    assert "By the transducer on the shaft: fail." in front
    change(demo, state)
    front = text_of(page_of(demo, code=1)).partition("Figures")[0]
    assert "? Undecided 4 of 5 limits met, 1 undecided." in front
    assert "serial number M-17" in front
    assert "operator A. Ampère" in front
    assert re.search(r"Undecided: torque_ripple_pp is .* probability of conformance 0\.\d+", front)
    assert "guard band U (95 %)" in front


def test_a_plan_that_was_taken_away_is_missed(recorded: Path, tmp_path: Path) -> None:
    plans = Path(shutil.copytree(recorded / "plans", tmp_path / "plans"))
    assert verify_run(plans).holds
    shutil.rmtree(plans / "one")
    assert list(verify_run(plans).damaged) == ["one/manifest.json"]


@blank
def test_the_first_page_of_many_cases_has_the_worst_of_each_limit_and_what_was_not_run(
    recorded: Path, tmp_path: Path
) -> None:
    two = Path(shutil.copytree(recorded / "plans" / "two", tmp_path / "two"))
    front = text_of(page_of(two)).partition("Figures")[0]
    assert "2 pass" in front
    assert "in case" in front
    shutil.rmtree(two / "foc")
    shutil.copytree(recorded / "demo", two / "demo")  # so that it is still a run of several
    front = text_of(page_of(two)).partition("Figures")[0]
    assert "Cases of the plan without a recording: tpc: foc." in front


@blank
def test_a_number_of_the_demo_has_one_uncertainty_wherever_it_is_printed(demo: Path) -> None:
    """± is the expanded uncertainty, in the table of measurements and in what the transducer contradicts."""
    page = page_of(demo)
    found = re.findall(r"torque_ripple_pp is (\S+ ± \S+) Nm by", page)
    assert len(found) == 1
    assert page.count(found[0]) >= 3  # the limits, the measurements and this remark


def test_the_same_bundle_gives_the_same_bytes_wherever_it_lies(
    reported: tuple[Path, Result], demo: Path
) -> None:
    first, _ = reported
    done("report", demo, "--pdf")
    for name in ("report.html", "report.pdf"):
        assert (demo / name).read_bytes() == (first / name).read_bytes()


@blank
def test_a_limit_that_is_missed_is_exit_code_1_and_said_in_words(demo: Path) -> None:
    def strict(manifest: dict[str, Any]) -> None:
        manifest["details"]["plan"]["limits"]["torque_ripple_pp"] = {"max": 0.01}

    change(demo, strict)
    text = text_of(page_of(demo, code=1))
    assert "✗ Fail 4 of 5 limits met." in text
    assert "✗ fail" in text


@blank
def test_what_a_manifest_says_is_text_and_nothing_else(demo: Path) -> None:
    hostile = "<script>alert(1)</script><img src=x onerror=alert(1)>"

    def alter(manifest: dict[str, Any]) -> None:
        manifest["what"] = manifest["note"] = manifest["details"]["plan"]["title"] = hostile
        manifest["details"]["case"] = manifest["identity"]["device_name"] = hostile
        manifest["parameters"][hostile] = hostile

    change(demo, alter)
    page = page_of(demo, "--pdf")
    assert "<script" not in page
    assert "<img src=x" not in page
    assert page.count("&lt;script&gt;alert(1)&lt;/script&gt;") >= 6


@blank
def test_a_run_that_failed_has_a_report_that_says_why(demo: Path) -> None:
    def failed(manifest: dict[str, Any]) -> None:
        manifest["complete"] = False
        manifest["verdict"] = "fail"
        manifest["details"]["failure"] = "DriveFault: overcurrent <0x2310>"
        manifest["streams"] = {"telemetry": manifest["streams"]["telemetry"]}
        for name in ("capture", "transducer"):
            del manifest["files"][f"data/{name}.parquet"]

    change(demo, failed)
    for name in ("capture", "transducer"):
        (demo / "data" / f"{name}.parquet").unlink()
    result = done("report", demo, "--pdf", "--json", code=1)
    document = json.loads(result.stdout)
    assert document["verdict"] == "fail"
    assert document["cases"]["tpc"]["failure"] == "DriveFault: overcurrent <0x2310>"
    text = text_of((demo / "report.html").read_text(encoding="utf-8"))
    assert "✗ Fail" in text
    assert "This case was cut short: DriveFault: overcurrent &lt;0x2310&gt;." in text
    assert "Every channel of stream telemetry over its whole length" in text
    assert "What happened" in text
    assert "state: operation enabled" in text


@blank
def test_a_run_that_was_cut_short_without_a_word(demo: Path) -> None:
    def cut(manifest: dict[str, Any]) -> None:
        manifest["complete"] = False
        manifest["verdict"] = None
        manifest["streams"] = manifest["files"] = {}

    change(demo, cut)
    shutil.rmtree(demo / "data")
    (demo / "data").mkdir()
    (demo / "certificate.json").unlink()
    text = text_of(page_of(demo, code=1))
    assert "the run was cut short before it ended" in text
    assert "ended before the quality of its data was known" in text


@blank
def test_data_that_cannot_be_read_are_named_and_the_rest_is_reported(demo: Path) -> None:
    (demo / "data" / "capture.parquet").write_bytes(b"torn")
    text = text_of(page_of(demo, code=3))
    assert "This recording could not be measured: cannot read" in text
    assert "benchtool reference drive" in text


@blank
def test_a_recording_without_a_plan_is_measured_and_not_judged(tmp_path: Path) -> None:
    done("record", "--duration", "0.5", "--out", tmp_path / "slow")
    result = done("report", tmp_path / "slow", "--json")
    assert json.loads(result.stdout)["verdict"] == "none"
    text = text_of((tmp_path / "slow" / "report.html").read_text(encoding="utf-8"))
    assert "What was measured stream telemetry, 100 Hz, every 100 control ticks" in text
    assert "Undefined: torque_mean" in text
    assert "'torque' is constant at 0 Nm over 50 samples" in html.unescape(text)
    assert "omega_m_reached" in text
    assert "The plan sets no limits" not in text
    assert "No limits" in text


@blank
def test_a_folder_of_cases_is_measured_again_case_by_case(recorded: Path) -> None:
    analysed = json.loads(done("analyze", recorded / "plans" / "two", "--json").stdout)
    assert list(analysed["cases"]) == ["tpc", "foc"]
    for name, case in analysed["cases"].items():
        alone = json.loads(done("analyze", recorded / "plans" / "two" / name, "--json").stdout)
        assert case["measurements"] == alone["cases"][name]["measurements"]
    several = invoke("analyze", recorded / "plans")
    assert several.exit_code == 2
    assert "holds 2 plans: give the folder of one" in several.stderr


@blank
def test_several_cases_and_several_plans(recorded: Path, tmp_path: Path) -> None:
    result = done("report", recorded / "plans" / "two", "--out", tmp_path / "two.html", "--json")
    assert list(json.loads(result.stdout)["cases"]) == ["tpc", "foc"]  # in the order in which they ran
    page = (tmp_path / "two.html").read_text(encoding="utf-8")
    assert '<a href="#s-case-foc">Case foc</a>' in page
    assert 'id="s-case-foc"' in page
    assert "Parameters of the drive in which the cases differ." in page

    result = done("report", recorded / "plans", "--out", tmp_path / "all.html", "--pdf", "--json")
    document = json.loads(result.stdout)
    assert list(document["cases"]) == ["one/tpc", "two/tpc", "two/foc"]
    text = text_of((tmp_path / "all.html").read_text(encoding="utf-8"))
    for title in ("2 plans", "Plan one", "Plan two", "Case two/foc"):
        assert title in text


@blank
def test_what_cannot_be_reported_is_one_line(demo: Path, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for arguments, code, said in (
        (("report", tmp_path / "nowhere"), 2, "nowhere does not exist: give the folder of a run"),
        (("report", demo / "manifest.json"), 2, f"expected: its folder, {demo}, is for 'benchtool analyze'"),
        (("report", demo / "measurements.json"), 2, "is a file: give the folder of a run"),
        (("report", tmp_path / "empty"), 2, "holds no run bundle"),
        (("report", demo, "--out", tmp_path / "no" / "page.html"), 3, "cannot write"),
        (("compare", demo, tmp_path / "empty"), 2, "holds no run bundle"),
    ):
        result = done(*arguments, code=code)
        (line,) = result.stderr.strip().splitlines()
        assert line.startswith("benchtool: ")
        assert said in line
    assert "add --html FILE" in done("compare", demo, demo, "--pdf", code=2).stderr
    assert "is one run of one case, two are compared" in done("compare", demo, code=2).stderr


@blank
def test_compare_says_what_differs_and_whether_it_means_anything(demo: Path, tmp_path: Path) -> None:
    done("demo", "--seed", "1", "--out", tmp_path / "other")
    page = tmp_path / "comparison.html"
    result = done("compare", demo, tmp_path / "other", "--html", page, "--pdf", "--json")
    document = json.loads(result.stdout)
    assert document["report"] == str(page)
    assert Path(document["pdf"]).read_bytes().startswith(b"%PDF-")
    delta = document["deltas"]["other:tpc"]
    assert delta["against"] == "demo:tpc"
    values = {
        name: case["measurements"]["torque_ripple_pp"]["value"] for name, case in document["cases"].items()
    }
    ripple = delta["measurements"]["torque_ripple_pp"]
    difference = values["other:tpc"] - values["demo:tpc"]
    assert ripple["absolute"] == pytest.approx(difference)
    assert ripple["percent"] == pytest.approx(100 * difference / values["demo:tpc"])
    text = text_of(page.read_text(encoding="utf-8"))
    assert ripple["standard_uncertainty"] > 0.0
    assert "other against demo" in text
    assert "difference ± U (95 %)" in text
    assert "Maximum minus minimum of the drive's estimate torque" in html.unescape(text)
    assert re.search(
        r"other: U = \S+ Nm covers 95 %, k = \S+, u = \S+ Nm, \S+ degrees of freedom: scatter of maximum and "
        r"minimum over records of this length, by those of the 5 single electrical periods",
        text,
    )
    assert f"benchtool compare {shlex.join([str(demo), str(tmp_path / 'other')])}" in html.unescape(text)
    assert "seed 0 1" in text
    assert "the same in all runs drive parameters; plan; operating point" in text


@blank
def test_compare_matches_the_cases_of_runs_by_name(recorded: Path, tmp_path: Path) -> None:
    two = recorded / "plans" / "two"
    document = json.loads(done("compare", two, two, "--json").stdout)
    assert {name: each["against"] for name, each in document["deltas"].items()} == {
        f"{two}#2:{case}": f"{two}#1:{case}" for case in ("tpc", "foc")
    }
    for each in document["deltas"].values():
        for delta in each["measurements"].values():
            assert delta["absolute"] in (0.0, None)
            assert delta["judgement"] is None
    within = json.loads(done("compare", two, "--json").stdout)
    assert list(within["deltas"]) == ["foc"]
    assert within["deltas"]["foc"]["measurements"]["torque_ripple_pp"]["judgement"] in (
        "better",
        "worse",
        None,
    )
    done("compare", two, recorded / "demo", two, "--html", tmp_path / "mixed.html")


@blank
def test_many_runs_stay_readable_for_people(demo: Path, recorded: Path) -> None:
    for runs in ([demo, recorded / "demo"], [demo] * 5):
        shown = done("compare", *runs).stdout
        assert "torque_ripple_pp" in shown.replace("\n", "") or "torque_ripple" in shown
        assert max(map(len, shown.splitlines())) <= 200
        assert "beyond its expanded uncertainty (95 %)" in " ".join(shown.split())


def test_ten_lines_of_numpy_give_the_numbers_again(recorded: Path) -> None:
    page = (Path(__file__).parents[2] / "docs" / "reference" / "measurements.md").read_text(encoding="utf-8")
    found = re.search(r"```python\n(.*?)```", page, re.DOTALL)
    assert found is not None
    lines = found[1]
    assert len([line for line in lines.splitlines() if line and not line.startswith("import")]) <= 10
    numbers: dict[str, Any] = {}
    exec(lines.replace("RUN", str(recorded / "demo")), numbers)
    measured = json.loads((recorded / "demo" / "measurements.json").read_text(encoding="utf-8"))
    assert numbers["ripple_pp"] == measured["torque_ripple_pp"]["value"]
    fundamental_A, squares = numbers["A"][numbers["turns"]], numbers["B"][:, 0]
    # straight lines between the samples cost harmonic 50, at 500 Hz of 10 kHz, a percent
    with_noise = float(
        re.findall(r"with which it is ([0-9.]+) %", measured["current_thd_f"]["uncertainty"]["source"])[0]
    )
    assert 100.0 * np.sqrt(squares.sum()) / fundamental_A == pytest.approx(with_noise, rel=0.01)
    # the noise is the mean of the bins here, and that of medians there
    assert numbers["thd_percent"] == pytest.approx(measured["current_thd_f"]["value"], rel=0.05)
    assert fundamental_A == pytest.approx(measured["current_fundamental"]["value"], rel=2e-4)
    assert numbers["turns"] == round(
        measured["fundamental_frequency"]["value"] * measured["fundamental_frequency"]["basis"]["duration_s"]
    )


def test_a_page_is_never_called_pdf(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ("report", str(tmp_path), "--out", "x.pdf"))
    assert result.exit_code == 2
    assert "--out x.pdf names a PDF, the page is HTML: add --pdf" in result.stderr
