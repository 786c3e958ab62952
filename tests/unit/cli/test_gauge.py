"""What `benchtool gauge` says of a study in words, and which options it refuses before it shows one."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app


def gauge(folder: Path, spread: float, *options: str, parts: int = 6) -> Result:
    """Return what the command says of readings of three operators, with this spread of their repetitions."""
    random = np.random.default_rng(2)
    lines = [
        f"{part},{operator},{part + spread * random.standard_normal():.6f}"
        for part in range(parts)
        for operator in "abc"
        for _ in range(3)
    ]
    path = folder / "readings.csv"
    path.write_text("part,operator,torque_Nm\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return CliRunner().invoke(app, ["gauge", str(path), *options], env={"COLUMNS": "300"})


@pytest.mark.parametrize(
    ("spread", "criterion"),
    [
        (0.02, "by AIAG's criteria under 10 %, acceptable\n"),
        (0.3, "by AIAG's criteria 10 to 30 %, which may be acceptable for some applications"),
        (3.0, "by AIAG's criteria over 30 %, not acceptable\n"),
    ],
)
def test_a_share_falls_under_a_criterion_of_aiag(tmp_path: Path, spread: float, criterion: str) -> None:
    assert criterion in gauge(tmp_path, spread).stdout


def test_criteria_that_the_interval_reaches_are_told(tmp_path: Path) -> None:
    said = gauge(tmp_path, 0.55, "--limit", "30").stdout
    assert "its interval also reaches" in said
    assert "%GRR of the total variation may be below or above 30 %" in said
    assert "probability of at most 30 %: 0." in said


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--limit", "30", "--margin", "X"), "--margin is X, U or a number of percent"),
        (("--limit", "nan"), "--limit is nan, a number of percent above 0"),
        (("--limit", "-3"), "--limit is -3, a number of percent above 0"),
        (("--margin", "5"), "--margin 5 without --limit"),
    ],
)
def test_a_wrong_rule_is_refused_before_the_study_is_shown(
    tmp_path: Path, options: tuple[str, ...], expected: str
) -> None:
    refused = gauge(tmp_path, 0.2, *options)
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert expected in refused.stderr


def test_one_part_has_a_share_of_the_tolerance_alone(tmp_path: Path) -> None:
    shown = gauge(tmp_path, 0.1, parts=1)
    assert shown.exit_code == 0
    assert "one part and no tolerance: %GRR has nothing to be a share of" in shown.stdout
    refused = gauge(tmp_path, 0.1, "--limit", "30", parts=1)
    assert (refused.exit_code, refused.stdout) == (2, "")
    assert "give --tolerance, or leave --limit out" in refused.stderr
    assert "%GRR of the tolerance" in gauge(tmp_path, 0.1, "--tolerance", "6", parts=1).stdout


def test_readings_that_hide_their_spread_have_no_share(tmp_path: Path) -> None:
    """A gauge that reads whole numbers was said to be acceptable, with a spread of 0."""
    shown = gauge(tmp_path, 0.0, "--tolerance", "6", "--limit", "30")
    assert shown.exit_code == 1
    assert "%GRR of" not in shown.stdout
    assert "verdict: undecided" in shown.stdout
    assert "their resolution hides the spread of the gauge" in shown.stderr
    assert "standard deviation of the gauge" not in shown.stdout
    document = json.loads(gauge(tmp_path, 0.0, "--json").stdout)
    assert document["gauge_interval"] is None
