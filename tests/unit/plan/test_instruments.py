"""Instruments of a bench that a dry run looks at: calibrations to come, and those that are overdue."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.profile import profile_path
from tests.unit.plan.test_validation import BASE


def _with_instruments(folder: Path, section: str) -> Path:
    """A plan and its profile, whose bench has this section."""
    profile = profile_path("zhu2011").read_text(encoding="utf-8")
    (folder / "bench.toml").write_text(f"{profile}\n{section}\n", encoding="utf-8")
    for eds in profile_path("zhu2011").parent.glob("*.eds"):
        (folder / eds.name).write_bytes(eds.read_bytes())
    plan = folder / "mine.toml"
    plan.write_text(BASE.replace('profile = "zhu2011"', 'profile = "bench.toml"'), encoding="utf-8")
    return plan


@pytest.mark.parametrize("table", ["bench.channels.torque", "bench.clock"])
def test_a_calibration_in_the_future_is_refused_before_a_run(tmp_path: Path, table: str) -> None:
    more = "" if "channels" in table else "tolerance_ppm = 50\n"
    plan = _with_instruments(tmp_path, f"[{table}]\n{more}calibrated = 2999-01-01")
    result = CliRunner().invoke(app, ["run", str(plan), "--dry-run"])
    assert result.exit_code == 2
    assert f"[{table}]: calibrated on 2999-01-01, and today is" in result.output


def test_a_dry_run_tells_what_is_overdue(tmp_path: Path) -> None:
    """Of the channels that the plan records, as a run of it would."""
    section = (
        "[bench.channels.torque]\nsensor = 'T40'\ndue = 2001-02-03\n[bench.channels.i_b]\ndue = 2001-01-01"
    )
    plan = _with_instruments(tmp_path, section)
    result = CliRunner().invoke(app, ["run", str(plan), "--dry-run", "--json"])
    assert result.exit_code == 0, result.output
    (found,) = json.loads(result.stdout)["plans"].values()
    assert [(each["channel"], each["due"]) for each in found["overdue"]] == [("torque", "2001-02-03")]
    assert found["calibration overdue"].startswith("calibration of torque (T40) was due on 2001-02-03")
