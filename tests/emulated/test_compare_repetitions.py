"""`benchtool compare` of runs whose limits hold for all repetitions of a case together."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app

PLAN = """
title = "repetitions"
profile = "zhu2011"
case = "tpc"
repetitions = 2
judge = "JUDGE"
operating_point = { omega_m_rad_s = 15.71, load_torque_Nm = 0.65, settle_s = 0.2 }
record = { duration_s = 0.12, channels = ["torque"] }
limits = { torque_ripple_pp = { max = 0.02 } }
setup.law = "tpc"
"""


def _told(*arguments: str | Path) -> str:
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    assert result.exit_code in (0, 1), result.output
    return result.stdout


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    place = tmp_path_factory.mktemp("repetitions")
    for judge in ("mean", "worst"):
        (place / f"{judge}.toml").write_text(PLAN.replace("JUDGE", judge), encoding="utf-8")
        _told("run", place / f"{judge}.toml", "--out", place / judge)
    return place / "mean", place / "worst"


def test_the_limits_over_repetitions_are_judged_in_each_run(runs: tuple[Path, Path], tmp_path: Path) -> None:
    text = " ".join(_told("compare", *runs, "--html", tmp_path / "page.html").split())
    assert "comparison: means of the repetitions" in text
    for letter, judge in (("A", "mean"), ("B", "worst")):
        assert f"{letter}: torque_ripple_pp: fail, " in text
        assert f"{judge} ≤ 0.02 Nm: it is 0.0" in text
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Limits over the repetitions" in page
    assert "worst of 2 repetitions" in page


def test_the_documents_have_what_the_runs_had_and_the_differences_of_the_means(
    runs: tuple[Path, Path],
) -> None:
    document = json.loads(_told("compare", *runs, "--json"))
    assert list(document["repeated"]) == ["mean:tpc", "worst:tpc"]
    for key, run in zip(document["repeated"], runs, strict=True):
        analysed = json.loads(_told("analyze", run, "--json"))
        assert document["repeated"][key] == analysed["repeated"]["tpc"]
    ((key, deltas),) = document["repeated_deltas"].items()
    assert (key, deltas["against"]) == ("worst:tpc", "mean:tpc")
    ripple = deltas["measurements"]["torque_ripple_pp"]
    assert ripple["absolute"] == pytest.approx(
        document["repeated"][key]["torque_ripple_pp"]["mean"]
        - document["repeated"]["mean:tpc"]["torque_ripple_pp"]["mean"]
    )


def test_one_repetition_alone_has_nothing_over_repetitions(runs: tuple[Path, Path]) -> None:
    document = json.loads(_told("compare", runs[0] / "tpc.1", runs[1] / "tpc.1", "--json"))
    assert "repeated" not in document
