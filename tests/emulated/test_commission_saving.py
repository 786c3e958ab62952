"""Parameters are old or new, whenever the host dies; what is kept, and where a commissioning goes on."""

from __future__ import annotations

import importlib
import json
import math
import re
import shutil
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import benchtool
from benchtool.analysis import Measurement, analyze_response
from benchtool.bench.session import Session, open_session
from benchtool.cli import app
from benchtool.commission import (
    Commissioning,
    StepRecorder,
    StepResult,
    StepVerdict,
    commission,
    step_bundles,
    steps_for,
)
from benchtool.commission.saving import save, trial
from benchtool.commission.steps.current_control import CurrentControl
from benchtool.commission.steps.speed_control import SpeedControl
from benchtool.drive import Identity, RemoteDrive
from benchtool.drive.parameters import reset, snapshot, store
from benchtool.errors import LinkClosed, SdoAbort, WriteNotVerified
from benchtool.live import names
from benchtool.profile import load_profile
from benchtool.recording import Conditions, Manifest
from benchtool.report.assembly import CAPTURES, LOOPS
from benchtool.results import verify_run
from benchtool.run import manifest_of
from tests.unit.live.readback import Recording

from .test_commission import boxed as boxed
from .test_third_party_drive import third_party_profile


class Dead(BaseException):
    """What ends a process that is killed: nothing of it runs any more."""


@contextmanager
def killed(drive: RemoteDrive, monkeypatch: pytest.MonkeyPatch, after: int) -> Iterator[None]:
    """Have this host die with its nth write: from then on it sends nothing, no heartbeat either."""
    left = after
    download, upload = drive.link.download, drive.link.upload

    def dying(index: int, sub: int, data: bytes, *, block: bool = False) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            drive.stop_heartbeat()
        if left <= 0:
            raise Dead
        download(index, sub, data, block=block)

    def dead(*arguments: Any, **options: Any) -> bytes:
        if left <= 0:
            raise Dead
        return upload(*arguments, **options)

    with monkeypatch.context() as patch, suppress(Dead):
        patch.setattr(drive.link, "download", dying)
        patch.setattr(drive.link, "upload", dead)
        yield


@contextmanager
def connected(profile: str) -> Iterator[Session]:
    with open_session(profile, "emulated", seed=2) as session:
        session.drive.connect()
        yield session


@pytest.mark.parametrize("after", [5, 33, 70, 121, 160])
def test_a_host_that_dies_leaves_old_parameters_or_new_ones(
    boxed: str, monkeypatch: pytest.MonkeyPatch, after: int
) -> None:
    with connected(boxed) as session:
        drive = session.drive
        old = snapshot(drive)
        with killed(drive, monkeypatch, after):
            commission(drive, session.profile, steps_for(["offsets"]), keep=True)
        session.clock.wait(0.7)
        in_force = snapshot(drive)
        assert not drive.state().power_stage_on
        reset(drive)
        assert snapshot(drive) == in_force
        stated = load_profile(boxed).motor
        new = {**old, "R_s_ohm": stated.R_s_ohm, "J_kgm2": pytest.approx(stated.J_kgm2, rel=1e-6)}
        is_new = in_force["R_s_ohm"] == pytest.approx(stated.R_s_ohm, rel=1e-6)
        assert in_force == old or (is_new and in_force["J_kgm2"] == new["J_kgm2"])


def test_what_is_stored_outlives_a_reset(boxed: str) -> None:
    with connected(boxed) as session:
        done = commission(session.drive, session.profile, steps_for(["offsets"]), keep=True)
        assert done.saved
        reset(session.drive)
        held = snapshot(session.drive)
        assert held == {**held, **{key: pytest.approx(value) for key, value in done.parameters.items()}}
        assert held["L_d_H"] == pytest.approx(7e-3)


def test_a_drive_that_refuses_to_store_keeps_what_it_had(boxed: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with connected(boxed) as session:
        drive = session.drive
        old = snapshot(drive)

        def refuses(_: RemoteDrive) -> None:
            raise SdoAbort("hardware error", 0x06060000)

        monkeypatch.setattr("benchtool.commission.saving.store", refuses)
        with pytest.raises(SdoAbort, match="hardware"):
            save(drive, {"R_s": 0.5})
        assert snapshot(drive) == old
        monkeypatch.setattr("benchtool.commission.saving.store", lambda _: None)
        with pytest.raises(WriteNotVerified, match="R_s_ohm"):
            save(drive, {"R_s": 0.5})
        assert snapshot(drive) == old


def test_a_reset_is_seen_though_a_heartbeat_follows_the_boot_up_at_once(boxed: str) -> None:
    with connected(boxed) as session:
        session.drive.write("producer_heartbeat", 0.002)
        store(session.drive)
        reset(session.drive)
        assert session.drive.number("producer_heartbeat") == pytest.approx(0.002)


@pytest.mark.usefixtures("blank_pictures")
def test_a_commissioning_is_shown_live(boxed: str, tmp_path: Path) -> None:
    shown = tmp_path / "view.rrd"
    command = ("commission", "offsets", "--profile", boxed, "--yes", "--save", "--json")
    result = CliRunner().invoke(app, [*command, "--out", str(tmp_path / "a"), "--live", str(shown)])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["saved"]
    recording = Recording.read(shown)
    (told,) = recording.still[names.RESULTS]["TextDocument:text"]
    assert told.index("| **offsets** | **pass** |") < told.index("| **preflight** | **pass** |")
    (row,) = (line for line in told.splitlines() if line.startswith("| u\\_dc |"))
    value, U, unit = re.split(" [|±] ", row.strip("| "))[1:]
    u_dc = json.loads(result.stdout)["estimates"]["u_dc"]
    assert float(value) == pytest.approx(u_dc["value"], abs=0.1 * float(U))
    standard, k = (u_dc["uncertainty"][key] for key in ("standard", "k"))
    assert float(U) == pytest.approx(k * standard, rel=0.05)
    assert unit == "V"
    lines = recording.texts(names.EVENTS)
    played = [each for each in lines if each.startswith(("preflight: ", "offsets: "))]
    assert played[-1] == "offsets: no current"
    assert "state: operation enabled" in lines[: lines.index(played[-1])]  # of the preflight


def test_a_trial_ends_in_good_order_with_what_was_tried(boxed: str) -> None:
    with connected(boxed) as session:
        drive = session.drive
        with trial(drive):
            drive.write("R_s", 0.5)
        assert drive.read("parameter_trial") == "off"
        with pytest.raises(LinkClosed), trial(drive):
            drive.write("R_s", 0.6)
            raise LinkClosed("unplugged")
        drive.stop_heartbeat()
        session.clock.wait(0.7)
        assert drive.number("R_s") == pytest.approx(0.6)
        with pytest.raises(SdoAbort):
            drive.write("parameter_trial", "on")


@pytest.mark.parametrize(
    ("J_of_true", "rounds", "verdict"), [(1.0, 1, "pass"), (1.4, 1, "fail"), (1.4, 3, "pass")]
)
def test_loops_are_tuned_and_measured(
    J_of_true: float, rounds: int, verdict: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With an inertia that is not the true one the crossover is not the designed one, and tells the true."""
    monkeypatch.setattr(SpeedControl, "most_rounds", rounds)
    path = tmp_path / "profile.toml"
    source = Path(__file__).parents[2] / "profiles" / "zhu2011" / "profile.toml"
    text = source.read_text(encoding="utf-8").split("[[choices]]")[0]
    text = text.replace("J_kgm2 = 13.1e-4", f"J_kgm2 = {13.1e-4 * J_of_true}")
    path.write_text(
        text.replace("[emulator.motor]\n", "[emulator.motor]\nJ_kgm2 = 13.1e-4\n"), encoding="utf-8"
    )
    with open_session(str(path), "emulated", seed=2) as session:
        identity = session.drive.connect()
        before = snapshot(session.drive)
        steps = (CurrentControl(), SpeedControl())
        recorder = StepRecorder(tmp_path / "steps", lambda step: manifest(session, identity, step))
        done = commission(session.drive, session.profile, steps, recorder=recorder, keep=True)
        assert [each.verdict for each in done.results] == [StepVerdict.PASS, StepVerdict(verdict)]
        assert done.saved == (verdict == "pass")
        if not done.saved:
            assert snapshot(session.drive) == before
            assert "crossover of the speed loop" in done.results[1].reason
            return
        found = done.estimates
        assert found["current_loop_crossover"].value == pytest.approx(339.9, rel=0.02)
        assert found["current_loop_phase_margin"].value == pytest.approx(74.2, abs=1.0)
        assert found["speed_loop_phase_margin"].value == pytest.approx(60.0, abs=3.0)
        assert found["speed_loop_crossover"].value == pytest.approx(10.8 / math.sqrt(J_of_true), rel=0.04)
        assert session.drive.number("K_p_speed") == pytest.approx(found["K_p_speed"].value, rel=1e-6)
        (bundle,) = (each for each in step_bundles(tmp_path / "steps") if each.directory.name == "speed_loop")
        assert len(bundle.streams) == (1 if J_of_true == 1.0 else 2)
        ((stream, loop),) = bundle.manifest.details[LOOPS].items()
        assert stream == bundle.streams[-1]
        again = analyze_response(bundle.block(stream), loop["input"], loop["output"], **loop["rows"])
        shown = {each.name: each.value for each in again.measurements}
        assert shown["phase_margin"] == pytest.approx(found["speed_loop_phase_margin"].value, abs=1.5)
        if J_of_true != 1.0:
            assert found["speed_loop_J"].value == pytest.approx(13.1e-4, rel=0.04)
            assert bundle.manifest.details[CAPTURES][stream] == "sequence of the speed, round 2"


def manifest(session: Session, identity: Identity, step: str) -> Manifest:
    return manifest_of(
        session,
        identity,
        what=step,
        when="2026-01-01T00:00:00",
        wall_s=0.0,
        note="",
        conditions=Conditions(),
        seed=2,
        link="emulated",
        command_line=(),
        details={},
    )


@pytest.mark.usefixtures("blank_pictures")
def test_a_commissioning_goes_on_where_it_was_cut_short(boxed: str, tmp_path: Path) -> None:
    runner, folder = CliRunner(), tmp_path / "a"
    command = ("commission", "--profile", boxed, "--yes", "--json")
    first = runner.invoke(app, [*command, "offsets", "--out", str(folder)])
    assert first.exit_code == 0, first.output
    recorded = (folder / "offsets" / "manifest.json").read_bytes()
    (folder / "resistance" / "data").mkdir(parents=True)  # as a process leaves it that is killed at once
    again = json.loads(runner.invoke(app, [*command, "offsets", "--resume", str(folder)]).stdout)
    assert again["steps"]["offsets"]["resumed"]
    assert again["estimates"] == json.loads(first.stdout)["estimates"]
    assert (folder / "offsets" / "manifest.json").read_bytes() == recorded
    assert again["bundle"] == str(folder)
    assert not again["saved"]
    written = tomllib.loads(Path(again["profile"]).read_text(encoding="utf-8"))
    assert written["nameplate"]["R_s_ohm"] == 0.16
    signed, _, rest = Path(again["report"]).read_text(encoding="utf-8").partition("Tested by")
    assert "Commissioning of" in signed
    assert all(name in signed for name in again["steps"]["offsets"]["sets"])
    assert "current_noise_a" not in signed
    assert "current_noise_a" in rest
    assert 'alt="no current.' in rest  # the title of its capture
    verified = runner.invoke(app, ["verify", str(folder), "--json"])
    assert json.loads(verified.stdout)["verdict"] == "pass", verified.output

    other = tmp_path / "other.toml"
    other.write_text(Path(boxed).read_text(encoding="utf-8").replace("0.16", "0.17"), encoding="utf-8")
    refused = runner.invoke(app, [*command, "offsets", "--profile", str(other), "--resume", str(folder)])
    assert refused.exit_code == 2
    assert "another profile" in refused.stderr


def test_a_drive_of_another_maker_says_what_it_leaves_out(tmp_path: Path) -> None:
    profile = third_party_profile(tmp_path)
    with connected(str(profile)) as session:
        before = session.drive.state()
        done = commission(session.drive, session.profile, steps_for([]))
        stops, *others = done.results
        assert (stops.name, stops.verdict) == ("preflight", StepVerdict.PASS)
        assert 0.3 < stops.estimates["link_loss_time"].value < 0.6
        assert {each.verdict for each in others} == {StepVerdict.SKIPPED}
        assert all("it takes a capture" in each.reason for each in done.results)
        assert session.drive.state() is before


@pytest.mark.usefixtures("blank_pictures")
def test_a_folder_holds_one_commissioning_and_an_interrupted_one_says_where_to_go_on(
    boxed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = str(tmp_path / "a")
    command = ("commission", "offsets", "--profile", boxed, "--yes")
    assert CliRunner().invoke(app, [*command, "--out", folder]).exit_code == 0
    again = CliRunner().invoke(app, [*command, "--out", folder])
    assert again.exit_code == 2
    assert "holds a commissioning" in again.output
    (tmp_path / "profile.toml").write_text("mine")
    beside = CliRunner().invoke(app, [*command, "--out", str(tmp_path)])
    assert beside.exit_code == 3
    assert "has content" in beside.output
    assert (tmp_path / "profile.toml").read_text() == "mine"

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("benchtool.cli.commission.run", interrupted)
    cut = CliRunner().invoke(app, [*command, "--resume", folder])
    assert cut.exit_code == 130
    assert "2 steps are done: go on with --resume" in cut.output
    assert verify_run(Path(folder)).holds
    shutil.rmtree(Path(folder) / "preflight")
    assert list(verify_run(Path(folder)).damaged) == ["preflight/manifest.json"]


def test_why_a_number_is_not_told_stands_below_the_table(
    boxed: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cli_commission = importlib.import_module("benchtool.cli.commission")  # of which the verb has the name
    real = cli_commission.run

    def with_friction(*arguments: Any, **named: Any) -> Commissioning:
        done: Commissioning = real(*arguments, **named)
        lost = {"friction": Measurement.undefined("friction", "Nms", "of a slope", "within its scatter")}
        return replace(done, results=(*done.results, StepResult("mechanics", (), StepVerdict.PASS, "", lost)))

    monkeypatch.setattr(cli_commission, "run", with_friction)
    told = CliRunner().invoke(
        app, ["commission", "preflight", "--profile", boxed, "--yes", "--out", str(tmp_path / "a")]
    )
    assert told.exit_code == 0, told.output
    assert "undefined: friction: within its scatter" in told.output


@pytest.mark.usefixtures("blank_pictures")
def test_the_report_of_a_commissioning_is_written_again_from_what_it_holds(
    boxed: str, tmp_path: Path
) -> None:
    runner, folder = CliRunner(), tmp_path / "a"
    asked = ["commission", "offsets", "--profile", boxed, "--yes", "--out", str(folder)]
    assert runner.invoke(app, asked).exit_code == 0
    report, document = folder / "report.html", folder / "commissioning.json"
    signed, stated, hashes = (path.read_bytes() for path in (report, document, folder / "hashes.json"))
    again = runner.invoke(app, ["report", str(folder), "--json"])
    assert (again.exit_code, json.loads(again.stdout)["verdict"]) == (0, "pass"), again.output
    assert report.read_bytes() == signed
    benchtool.write_report(folder)
    assert report.read_bytes() == signed
    assert (folder / "hashes.json").read_bytes() == hashes
    pictures = runner.invoke(app, ["report", str(folder), "--png"])
    assert pictures.exit_code == 2
    assert "a commissioning" in pictures.stderr

    report.write_bytes(signed.replace(b"Commissioning of", b"commissioning of"))
    changed = report.read_bytes()
    blessing = runner.invoke(app, ["report", str(folder)])
    assert blessing.exit_code == 3
    assert "report.html was changed after it was written" in " ".join(blessing.stderr.split())
    assert (report.read_bytes(), (folder / "hashes.json").read_bytes()) == (changed, hashes)
    resumed = runner.invoke(app, [*asked[:-2], "--resume", str(folder)])
    assert (resumed.exit_code, report.read_bytes()) == (3, changed)

    elsewhere = ["report", str(folder), "--out", str(tmp_path / "other.html")]
    assert runner.invoke(app, elsewhere).exit_code == 0
    assert (tmp_path / "other.html").read_bytes() == signed
    document.write_bytes(stated.replace(b'"pass"', b'"fail"', 1))
    assert runner.invoke(app, elsewhere).exit_code == 3
    document.unlink()
    cut = runner.invoke(app, elsewhere)
    assert cut.exit_code == 2
    assert "commission --resume" in cut.stderr
    document.write_bytes(stated)
    shutil.rmtree(folder / "offsets")
    without = runner.invoke(app, elsewhere)
    assert without.exit_code == 3
    assert "offsets is missing" in " ".join(without.stderr.split())
