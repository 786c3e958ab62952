"""Faults of the emulated bench: a few moments of a few of them, and who may inject them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchmarks.faults.figures import limit_s, summarise
from benchmarks.faults.trial import run_trial
from benchtool.cli import app
from benchtool.emulator.faults import FAULTS
from benchtool.errors import LimitTrip, StateError, UsageError, ValueRefused
from benchtool.protocol.cia402 import State
from benchtool.protocol.modes import Mode
from benchtool.run.checks import check_plan

from .conftest import Opener, Wire, over_both_wires

PLAN = """
title = "the supply fails"
profile = "zhu2011"
faults = ["dc_link_sag@0.02"]
[operating_point]
omega_m_rad_s = 20.0
settle_s = 0.2
[record]
duration_s = 0.05
channels = ["torque", "omega_m"]
"""


@pytest.mark.parametrize(
    ("fault", "wire"),
    [
        ("host_killed", "serial"),
        ("host_frozen", "can"),
        ("cable_pulled", "can"),
        ("duplicate_node", "can"),
        ("frames_duplicated", "serial"),
        ("frames_late", "can"),
        ("drive_hung", "serial"),
        ("encoder_loss", "can"),
        ("current_offset", "serial"),
        ("overtemperature", "can"),
    ],
)
def test_what_must_hold(fault: str, wire: str) -> None:
    outcomes = run_trial(fault, wire, seed=1000)
    figures = summarise(fault, wire, [outcomes])
    assert figures.holds, figures.line
    assert (figures.stopped_ms is None) == (limit_s(fault) is None)


def test_the_torque_of_a_lost_link_ends_late_in_the_time_that_is_configured() -> None:
    """The measurement sees the watchdog: the torque is there until shortly before its time."""
    outcomes = run_trial("host_killed", "can", seed=1001)
    assert outcomes.stopped_s is not None
    assert 0.099 < outcomes.stopped_s <= 0.1


def test_a_number_that_two_nodes_have_is_not_enabled(wire: Wire) -> None:
    drive, faults = wire.session.drive, wire.session.faults
    assert faults is not None
    drive.connect()
    drive.wait(0.1)
    faults.inject("duplicate_node")
    with pytest.raises(StateError, match="2 nodes answer as node 1, one is expected"):
        drive.enable(Mode.VELOCITY)
    assert drive.state() is State.SWITCH_ON_DISABLED
    faults.end()
    drive.enable(Mode.VELOCITY)
    drive.disable()


@over_both_wires
def test_a_fault_that_is_ended_before_it_began_does_not_begin(wire: Wire) -> None:
    drive, faults = wire.session.drive, wire.session.faults
    assert faults is not None
    drive.connect()
    faults.inject("drive_reset@0.5")
    faults.end()
    with drive.enabled(Mode.VELOCITY):
        drive.wait(0.7)


def test_a_fault_of_a_can_bus_is_refused_where_there_is_none(open_wire: Opener) -> None:
    from benchtool.bench import open_session

    with (
        open_session("zhu2011", "emulated?wire=serial") as session,
        pytest.raises(ValueRefused, match="the drive is on none"),
    ):
        assert session.faults is not None
        session.faults.inject("bus_off")


def test_a_quick_stop_that_does_not_brake_ends_in_disabling(wire: Wire) -> None:
    drive, load = wire.session.drive, wire.session.load
    assert load is not None
    drive.connect()
    drive.enable(Mode.VELOCITY)
    drive.write("omega_m_command", 20.0)
    drive.wait(0.2)
    load.hold(20.0)
    before_s = wire.session.clock.now_s()
    drive.quick_stop()
    assert wire.session.clock.now_s() - before_s < 0.3
    assert drive.state() is State.SWITCH_ON_DISABLED


def test_a_plan_injects_its_faults_and_the_run_names_what_the_drive_reports(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text(PLAN, encoding="utf-8")
    command = ["run", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(app, command)
    assert result.exit_code == 4
    assert "0x3220 dc link undervoltage" in result.stderr
    assert "injecting dc_link_sag@0.02" in result.stderr


def test_a_plan_with_faults_runs_on_an_emulated_bench_only(tmp_path: Path) -> None:
    from benchtool.plan.model import load_plan

    (tmp_path / "plan.toml").write_text(PLAN, encoding="utf-8")
    plan = load_plan(str(tmp_path / "plan.toml"))
    with pytest.raises(UsageError, match="faults are injected into an emulated bench"):
        check_plan(plan, None, "zhu2011", "serial:/dev/null")
    with pytest.raises(ValueRefused, match="there is no 'dc_link_sags'"):
        check_plan(plan.model_copy(update={"faults": ("dc_link_sags",)}), None, "zhu2011", "emulated")


def test_the_command_line_lists_every_fault() -> None:
    result = CliRunner().invoke(app, ["emulate", "--faults", "--json"])
    listed = {each["name"]: each for each in json.loads(result.stdout)["faults"]}
    assert set(listed) == set(FAULTS)
    assert listed["drive_hung"]["parameters"][0]["unit"] == "s"
    plain = CliRunner().invoke(app, ["emulate", "--faults"]).stdout
    assert all(name in plain for name in FAULTS)


def test_an_unknown_fault_is_a_usage_error() -> None:
    result = CliRunner().invoke(app, ["emulate", "--fault", "frame_lost"])
    assert (result.exit_code, "did you mean 'frames_lost'" in result.stderr) == (2, True)


def test_limits_of_a_profile_stop_a_case(tmp_path: Path) -> None:
    from benchtool.profile import profile_path

    text = profile_path("zhu2011").read_text(encoding="utf-8")
    (tmp_path / "own.toml").write_text(f"{text}\n[limits]\nomega_m_rad_s = 15.0\n", encoding="utf-8")
    plan = PLAN.replace('"zhu2011"', '"own.toml"').replace('faults = ["dc_link_sag@0.02"]', "")
    (tmp_path / "plan.toml").write_text(plan.replace("0.2\n", "0.6\n"), encoding="utf-8")
    result = CliRunner().invoke(app, ["run", str(tmp_path / "plan.toml"), "--out", str(tmp_path / "out")])
    assert result.exit_code == LimitTrip.exit_code
    assert "the profile's limit is 15 rad/s: the drive was told to stop" in result.stderr
