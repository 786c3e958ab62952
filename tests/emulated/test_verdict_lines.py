"""Lines beside a verdict in the terminal, and the speed of error messages."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app

Invoke = Callable[..., Result]
PLAN = """title = "two [laws]"
profile = "zhu2011"
[operating_point]
omega_m_rad_s = 31.42
load_torque_Nm = 0.65
settle_s = 0.6
[sweep.setup]
law = ["tpc", "deadbeat"]
[record]
duration_s = 0.15
channels = ["torque", "theta_m"]
[case_limits.tpc]
torque_ripple_pp = { max = 0.06 }
[case_limits.deadbeat]
torque_ripple_pp = { max = 1e-6 }
"""


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(app, arguments)


@pytest.mark.usefixtures("blank_pictures")
def test_a_failed_run_names_case_limit_and_how_far_and_what_the_shaft_says(
    invoke: Invoke, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text(PLAN, encoding="utf-8")
    result = invoke("run", "mine.toml", "--out", "run")
    assert result.exit_code == 1, result.output
    assert "verdict: fail" in result.stdout
    assert "fail: deadbeat: torque_ripple_pp is 0." in result.stdout
    assert "at most 1 × 10⁻⁶ Nm is allowed" in result.stdout
    assert "the transducer disagrees: tpc: torque_ripple_pp is 0.0" in result.stdout
    assert "(fail)" in result.stdout
    assert "not measured for lack of channels: flux ripple (psi_s), current spectrum (i_a)" in result.stdout

    document = json.loads(invoke("analyze", "run", "--json").stdout)
    assert document["verdict"] == document["verdict_by_transducer"] == "fail"
    tpc = document["cases"]["tpc"]
    assert (tpc["verdict"], tpc["verdict_by_transducer"]) == ("pass", "fail")
    assert tpc["disagreements"]["torque_ripple_pp"]["verdict_by_transducer"] == "fail"
    assert document["cases"]["deadbeat"]["missed"][0].startswith("torque_ripple_pp is 0.")
    assert "current spectrum" in tpc["not_measured"]

    assert invoke("report", "run").exit_code == 1
    (page,) = (tmp_path / "run").glob("*.html")
    text = page.read_text(encoding="utf-8")
    assert "at most 1 × 10⁻⁶ Nm is allowed" in text
    assert "The transducer disagrees: torque_ripple_pp" in text


@pytest.mark.usefixtures("blank_pictures")
def test_the_report_of_repetitions_says_of_the_shaft_what_the_run_says(
    invoke: Invoke, tmp_path: Path
) -> None:
    together = PLAN[: PLAN.index("[case_limits.tpc]")].replace('["tpc", "deadbeat"]', '["tpc"]')
    together = (
        'repetitions = 2\njudge = "mean"\n' + together + "[limits]\ntorque_ripple_pp = { max = 0.06 }\n"
    )
    (tmp_path / "mine.toml").write_text(together, encoding="utf-8")
    verdict = "verdict: pass by the drive's own estimate, fail by the transducer on the shaft"

    printed = invoke("run", "mine.toml", "--out", "run").stdout
    assert verdict in printed
    contradicted = "torque_ripple_pp is 0.0"
    assert f"the transducer disagrees: tpc, mean of 2 repetitions: {contradicted}" in printed
    assert "Nm, at most 0.06 Nm is allowed: 0." in printed
    assert verdict in invoke("report", "run").stdout
    (page,) = (tmp_path / "run").glob("*.html")
    front = page.read_text(encoding="utf-8")
    assert "By the transducer on the shaft: fail." in front
    assert f"tpc over its repetitions: the transducer disagrees: {contradicted}" in front

    # one of the repetitions does not have the verdict of both
    alone = invoke("analyze", "run/tpc.1", "--json")
    document = json.loads(alone.stdout)
    assert (alone.exit_code, document["verdict"]) == (1, "undecided")
    (case,) = document["cases"].values()
    assert case["verdict"] == "none"
    assert (case["limits_together"]["judge"], case["limits_together"]["repetitions"]) == ("mean", 2)
    told = "torque_ripple_pp ≤ 0.06 Nm holds for the mean of 2 repetitions, of which this is one"
    assert f"undecided: tpc.1: {told}" in alone.stderr
    assert "verdict: undecided" in invoke("report", "run/tpc.1").stdout
    page = tmp_path / "run" / "tpc.1" / "report.html"
    assert f"Undecided: {told}" in page.read_text(encoding="utf-8")


def test_no_plan_of_a_folder_runs_before_all_are_sound(invoke: Invoke, tmp_path: Path) -> None:
    folder = tmp_path / "plans"
    folder.mkdir()
    (folder / "a.toml").write_text(PLAN, encoding="utf-8")
    (folder / "b.toml").write_text(PLAN.replace("omega_m_rad_s = 31.42", "omega_m_rad_s = 500"), "utf-8")
    result = invoke("run", "plans", "--out", "run")
    assert result.exit_code == 2
    assert "b.toml, line 4: omega_m_rad_s is 500" in result.stderr
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize("name", ["zhu2011/riple", "mine.toml"])
def test_a_typing_error_does_not_wait_for_what_a_run_needs(name: str, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(PLAN.replace("settle_s", "setle_s"), encoding="utf-8")
    code = (
        "import sys\nfrom benchtool.cli import app\n"
        "try:\n    app(sys.argv[1:])\nexcept SystemExit as end:\n    code = end.code\n"
        "print(code, [name for name in ('scipy', 'matplotlib', 'can', 'pyarrow') if name in sys.modules])"
    )
    done = subprocess.run(
        (sys.executable, "-c", code, "run", name), cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert "did you mean" in done.stderr
    assert done.stdout.strip() == "2 []", done.stderr
