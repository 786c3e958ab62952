"""A motor identified over the wire, by a drive that knows nothing of it."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.bench.session import open_session
from benchtool.cli import app
from benchtool.commission import Commissioning, StepVerdict, commission, document, steps_for
from benchtool.drive.parameters import snapshot
from benchtool.errors import UsageError
from benchtool.shipped import shipped

from .conftest import over_both_wires

NAMEPLATE = {
    "R_s_ohm = 0.123": "R_s_ohm = 0.16",
    "L_d_H = 9.52e-3": "L_d_H = 7e-3",
    "L_q_H = 9.52e-3": "L_q_H = 7e-3",
    "omega_m_N_rad_s = 157.1": "omega_m_N_rad_s = 100.0",  # that the dc link allows
}
TRUTH = "[emulator.motor]\nR_s_ohm = 0.123\nL_d_H = 9.52e-3\nL_q_H = 9.52e-3\n"


@pytest.fixture(scope="module")
def boxed(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The paper's machine with a nameplate that is off, on a drive as it comes out of its box."""
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    for old, new in NAMEPLATE.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    text = text.split("[[choices]]")[0].replace(
        "[emulator.motor]\n", f"[emulator]\ncommissioned = false\n\n{TRUTH}"
    )
    path = tmp_path_factory.mktemp("boxed") / "profile.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def commissioned(profile: str, options: str, *names: str) -> Commissioning:
    """Run steps, and hold that the drive is as it was."""
    with open_session(profile, f"emulated?{options}", seed=2) as session:
        drive = session.drive
        drive.connect()
        before = snapshot(drive)
        done = commission(drive, session.profile, steps_for(names))
        assert not drive.state().power_stage_on
        assert snapshot(drive) == before
    return done


@over_both_wires
def test_a_motor_is_identified(boxed: str, link_options: str) -> None:
    done = commissioned(boxed, link_options.removeprefix("&"), "inductance")
    assert [(each.name, each.verdict) for each in done.results] == [
        (name, StepVerdict.PASS)
        for name in ("preflight", "offsets", "connections", "resistance", "encoder", "inductance")
    ]
    estimates = done.estimates
    for name, true, tolerance in (("R_s", 0.123, 0.02), ("L_d", 9.52e-3, 0.03), ("L_q", 9.52e-3, 0.03)):
        found = estimates[name]
        assert found.uncertainty is not None
        assert found.value == pytest.approx(true, rel=tolerance)
        assert abs(found.value - true) < 4.0 * found.uncertainty.standard
    assert estimates["dead_time_voltage"].value == pytest.approx(0.0, abs=0.05)
    assert estimates["pole_pairs"].value == 4.0
    assert estimates["encoder_direction"].value == 1.0
    assert abs(estimates["encoder_offset"].value) < math.radians(1.0) / 4.0
    assert 0.3 < estimates["link_loss_time"].value < 0.6


def test_a_step_brings_those_that_it_needs() -> None:
    assert [each.name for each in steps_for(["inductance"])] == [
        "preflight",
        "offsets",
        "connections",
        "resistance",
        "encoder",
        "inductance",
    ]
    assert [each.name for each in steps_for(["offsets"])] == ["preflight", "offsets"]
    with pytest.raises(UsageError, match="no step 'flux'"):
        steps_for(["flux"])


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("i_trip_A = 12.0", "i_trip_A = 9.4", "trips at 9.4 A"),
        ("u_dc_min_V = 50.0", "u_dc_min_V = 130.0", "130 V"),
    ],
)
def test_a_step_that_fails_leaves_out_those_that_need_it(
    boxed: str, tmp_path: Path, old: str, new: str, reason: str
) -> None:
    tripping = tmp_path / "profile.toml"
    tripping.write_text(Path(boxed).read_text(encoding="utf-8").replace(old, new))
    done = commissioned(str(tripping), "", "inductance")
    content = document(done)
    assert [each["verdict"] for each in content["steps"].values()] == ["fail", *5 * ["skipped"]]
    assert reason in content["steps"]["preflight"]["reason"]
    assert content["estimates"]["L_d"]["value"] is None
    assert content["estimates"]["L_d"]["reason"].startswith("step inductance: it needs")
    assert content["verdict"] == "fail"


@pytest.mark.usefixtures("blank_pictures")
def test_the_command_prints_one_document_and_needs_a_yes(boxed: str, tmp_path: Path) -> None:
    runner = CliRunner()
    asked = runner.invoke(app, ["commission", "resistance", "--profile", boxed])
    assert asked.exit_code == 2
    of_resistance = ("commission", "resistance", "--profile", boxed, "--json")
    planned = json.loads(runner.invoke(app, [*of_resistance, "--dry-run"]).stdout)
    assert list(planned["steps"]) == ["preflight", "offsets", "connections", "resistance"]
    result = runner.invoke(app, [*of_resistance, "--yes", "--out", str(tmp_path / "a")])
    assert result.exit_code == 0, result.output
    content = json.loads(result.stdout)
    assert content["estimates"]["R_s"]["nameplate"] == 0.16
    steps = content["steps"].values()
    assert sum(each["energy_J"] for each in steps) == pytest.approx(planned["energy_J"])
    stated_R_s, found_R_s = 0.16, content["estimates"]["R_s"]["value"]
    by_its_R_s = planned["energy_J"] * found_R_s / stated_R_s
    assert sum(each["spent_J"] for each in steps) == pytest.approx(by_its_R_s, rel=0.05)


@pytest.mark.parametrize(
    ("wrong", "cause"),
    [(("b",), "its sensor is mounted the other way round"), (("a", "b", "c"), "sign of the currents")],
)
def test_a_reversed_sensor_is_named_before_a_loop_is_closed(
    boxed: str, tmp_path: Path, wrong: tuple[str, ...], cause: str
) -> None:
    path = tmp_path / "profile.toml"
    tables = "".join(f"\n[emulator.sensors.i_{phase}]\ngain = -1.0\n" for phase in wrong)
    path.write_text(Path(boxed).read_text(encoding="utf-8") + tables, encoding="utf-8")
    content = document(commissioned(str(path), "", "resistance"))
    (finding,) = content["findings"]
    assert cause in finding["cause"]
    assert finding["remedy"]
    assert [each["verdict"] for each in content["steps"].values()] == ["pass", "pass", "fail", "skipped"]


def test_a_shaft_that_may_not_turn_round_leaves_out_what_needs_a_speed(boxed: str) -> None:
    runner = CliRunner()
    asked = ("commission", "flux_linkage", "speed_loop", "--profile", boxed, "--json", "--dry-run")
    whole, short = (
        json.loads(runner.invoke(app, [*asked, *travel]).stdout)["steps"]
        for travel in ((), ("--travel", "1rev"))
    )
    assert whole["speed_loop"]["energy_J"] > 0.0
    assert whole["flux_linkage"]["energy_J"] > 0.0
    assert short["speed_loop"]["energy_J"] == short["flux_linkage"]["energy_J"] == 0.0
    assert 0.0 < short["encoder"]["energy_J"] <= whole["encoder"]["energy_J"]
    for wrong in ("1", "-1rev", "0deg", "rev"):
        assert runner.invoke(app, [*asked, "--travel", wrong]).exit_code == 2


def test_a_dry_run_of_a_drive_in_fault_over_limits_that_it_came_with(tmp_path: Path) -> None:
    text = (shipped("profiles") / "motors" / "ipmsm_2_2kw" / "profile.toml").read_text(encoding="utf-8")
    path = tmp_path / "profile.toml"
    path.write_text(text.replace("[emulator.", "[emulator]\ncommissioned = false\n\n[emulator.", 1))
    asked = ("commission", "resistance", "--profile", str(path), "--dry-run", "--json")
    planned = CliRunner().invoke(app, asked)
    assert planned.exit_code == 0, planned.output
    least_J, most_J = json.loads(planned.stdout)["energy_range_J"]
    assert least_J < json.loads(planned.stdout)["energy_J"] < most_J
