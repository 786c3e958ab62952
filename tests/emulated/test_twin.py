"""`benchtool twin`: an emulated machine that is not as the drive believes, by the shipped plan."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from docs.generate.json_documents import DOCUMENTS

CHANGES = (
    *("record.duration_s=0.8", "stimulus.duration_s=0.75"),
    *("setup.psi_r_Wb=0.15", "setup.J_kgm2=0.002"),  # of 0.1685 Wb and 0.00131 kgm2
)


def test_what_the_drive_believes_wrongly_is_named_with_its_size(tmp_path: Path) -> None:
    run, figure = tmp_path / "run", tmp_path / "twin.png"
    options = [word for change in CHANGES for word in ("--set", change)]
    done = CliRunner().invoke(app, ["run", "zhu2011/identify", "--out", str(run), *options])
    assert done.exit_code == 0, done.output

    done = CliRunner().invoke(app, ["twin", str(run), "--json", "--figure", str(figure)])
    assert done.exit_code == 1, done.output
    document = json.loads(done.stdout)
    DOCUMENTS["twin"].model_validate(document)
    case = document["cases"]["tpc"]
    assert set(case["wrong"]) == {"psi_r", "J"}
    for name, believed, true in (("psi_r", 0.15, 0.1685), ("J", 0.002, 0.00131)):
        found = case["parameters"][name]
        assert found["believed"] == pytest.approx(believed)
        assert found["value"] == pytest.approx(true, rel=2e-3)
    assert set(case["residuals"]) == {"i_d", "i_q", "omega_m"}
    for residual in case["residuals"].values():
        assert residual["residual_rms_estimated"] < 0.1 * residual["residual_rms_believed"]
    assert figure.stat().st_size > 10_000
    full = tmp_path / "full.svg"
    full.symlink_to("/dev/full")
    stopped = CliRunner().invoke(app, ["twin", str(run), "--figure", str(full)])
    assert stopped.exit_code == 3
    assert f"cannot write {full}: No space left on device" in stopped.stderr

    done = CliRunner().invoke(app, ["twin", str(run), "--stream", "telemetry"])
    assert done.exit_code == 2
    assert "record i_a, i_b, i_c, theta_m, u_alpha, u_beta, u_dc with every tick" in done.stderr
