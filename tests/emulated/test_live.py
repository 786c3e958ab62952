"""`benchtool live` and `--live`: the view shows the recorded data, and has no effect on a run."""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app
from benchtool.cli.live_views import LiveDestinations
from benchtool.cli.output import Output
from benchtool.errors import EnvironmentFailure
from benchtool.live import CAPTURE, STREAM, TRANSDUCER, LiveView, RecordingSink, Viewer, names, sinks
from benchtool.live.messages import Message
from benchtool.live.sinks import picture
from benchtool.live.sinks.picture import headless_viewer
from benchtool.live.sinks.viewer import viewer_environment, viewer_program
from benchtool.recording import Bundle
from benchtool.telemetry import TelemetryStream
from tests.emulated import browser, headless
from tests.unit.live.readback import Recording, assert_holds

Invoke = Callable[..., Result]
_PLAN = """
title = "short"
profile = "zhu2011"

[operating_point]
omega_m_rad_s = 15.71
load_torque_Nm = 0.3
settle_s = 0.4

[record]
duration_s = 0.25
channels = ["i_a", "torque", "torque_reference", "psi_alpha", "psi_beta", "theta_m", "omega_m", "u_dc"]

[analyses]
steady = false

[limits]
capture_rows_missing = { max = 0 }
"""


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)
    Path("short.toml").write_text(_PLAN, encoding="utf-8")

    def run(*arguments: str) -> Result:
        result = CliRunner().invoke(app, arguments)
        assert "Traceback" not in result.output
        return result

    return run


def test_a_run_is_shown_as_it_is_recorded(invoke: Invoke) -> None:
    result = invoke("run", "short.toml", "--out", "run", "--live", "a.rrd")
    assert result.exit_code == 0, result.output
    bundle, recording = Bundle.open(Path("run")), Recording.read(Path("a.rrd"))
    assert bundle.complete
    for stream, source in (("telemetry", STREAM), ("capture", CAPTURE), ("transducer", TRANSDUCER)):
        assert_holds(recording, bundle.block(stream), source)
    events = dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True))
    walked = [text.removeprefix("state: ") for text in recording.texts(names.EVENTS) if "state: " in text]
    assert walked[:4] == [
        "switch on disabled", "ready to switch on", "switched on", "operation enabled",
    ]  # fmt: skip
    assert events["enabling"] <= events["state: operation enabled"] < bundle.block("capture").first_tick
    assert bundle.block("capture").ticks()[-1] <= events["state: switch on disabled"]
    assert recording.values(names.RECEPTION)[-1][0] == len(bundle.block("telemetry").data)
    assert np.all(recording.values(names.QUALITY) == 0.0)
    document = recording.still[names.RESULTS]["TextDocument:text"][0]
    assert "| capture\\_rows\\_missing | 0 |  | ≤ 0 | pass |" in document


def test_a_fault_is_found_where_the_speed_passed_its_limit(invoke: Invoke) -> None:
    plan = _PLAN.replace("[record]", "[setup]\nomega_m_trip_rad_s = 12.0\n\n[record]")
    Path("fast.toml").write_text(plan, encoding="utf-8")
    result = invoke("run", "fast.toml", "--out", "run", "--live", "a.rrd")
    assert result.exit_code == 4, result.output
    slow, recording = Bundle.open(Path("run")).block("telemetry"), Recording.read(Path("a.rrd"))
    past = slow.ticks()[slow.column("omega_m") >= 12.0][0]
    events = dict(zip(recording.texts(names.EVENTS), recording.ticks(names.EVENTS), strict=True))
    fault = events["emergency: 0x8400 speed outside its limits"]
    assert past - slow.stride <= fault <= past + 20  # the estimate's noise, and the frame's way
    assert fault <= events["state: fault"]
    assert fault in recording.ticks(names.ERROR)
    later = invoke("live", "run", "--save", "later.rrd")
    assert later.exit_code == 0, later.output
    again = Recording.read(Path("later.rrd"))
    shown = dict(zip(again.texts(names.EVENTS), again.ticks(names.EVENTS), strict=True))
    assert shown == events
    assert np.array_equal(again.ticks(names.ERROR), recording.ticks(names.ERROR))
    levels = recording.rows[names.EVENTS].column("TextLog:level").to_pylist()
    assert levels.count(["ERROR"]) >= 3  # the emergency, the state, and what ended the run


def test_one_file_is_written_once_however_it_is_spelt(invoke: Invoke) -> None:
    result = invoke("record", "--duration", "1", "--out", "run", "--live", "a.rrd", "--live", "./a.rrd")
    assert result.exit_code == 0, result.output
    assert_holds(Recording.read(Path("a.rrd")), Bundle.open(Path("run")).block("telemetry"), STREAM)


def test_a_recorded_drive_shows_the_states_that_another_master_brings_it_into(invoke: Invoke) -> None:
    result = invoke("record", "--duration", "2", "--out", "run", "--live", "a.rrd")
    assert result.exit_code == 0, result.output
    asked = Bundle.open(Path("run")).manifest.quality["frames_received"]
    assert Recording.read(Path("a.rrd")).texts(names.EVENTS) == ["state: switch on disabled"]
    assert asked > 200


def test_looking_on_changes_no_bit(invoke: Invoke) -> None:
    assert invoke("run", "short.toml", "--out", "a").exit_code == 0
    assert invoke("run", "short.toml", "--out", "b", "--live", "b.rrd").exit_code == 0
    for name in ("telemetry", "capture", "transducer"):
        first, second = (Path(folder) / "data" / f"{name}.parquet" for folder in "ab")
        assert first.read_bytes() == second.read_bytes()


def test_a_recorded_run_opens_in_the_same_view(invoke: Invoke) -> None:
    plan = _PLAN + '\n[[variants]]\nname = "cold"\n[[variants]]\nname = "warm"\nsetup = { R_s_ohm = 0.17 }\n'
    Path("two.toml").write_text(plan, encoding="utf-8")
    assert invoke("run", "two.toml", "--out", "run", "--live", "live.rrd").exit_code == 0
    result = invoke("live", "run", "--save", "later.rrd", "--json")
    assert result.exit_code == 0, result.output
    shown = [Path(each["bundle"]) for each in json.loads(result.stdout)["shown"]]
    assert len(shown) == 2
    assert not Path("live.rrd").exists()
    written = sorted(Path.cwd().glob("live-*.rrd")), sorted(Path.cwd().glob("later-*.rrd"))
    assert [len(each) for each in written] == [2, 2]
    for place, live, later in zip(shown, *written, strict=True):
        bundle = Bundle.open(place)
        for path in (live, later):
            recording = Recording.read(path)
            assert_holds(recording, bundle.block("telemetry"), STREAM)
            assert_holds(recording, bundle.block("capture"), CAPTURE)


@pytest.mark.parametrize("wire", ["emulated", "emulated?wire=serial"])
def test_a_drive_is_shown_without_being_enabled(invoke: Invoke, wire: str) -> None:
    before_s = time.time()
    options = ("--rate", "1000") if "serial" in wire else ()
    result = invoke("live", "--duration", "1", "--save", "a.rrd", "--link", wire, "--json", *options)
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["rows"] == (1000 if options else 250)
    assert document["rows_not_shown"] == {"queue": 0, "a.rrd": 0}
    recording = Recording.read(Path("a.rrd"))
    assert recording.texts(names.EVENTS) == ["state: switch on disabled"]
    begun_s = recording.nanoseconds("/stream/torque", names.WALL_TIME)[0] * 1e-9
    assert abs(begun_s - before_s) < 60.0
    assert len(recording.values("/stream/torque")) == document["rows"]
    assert recording.series("/stream/current") == ["i_a (A)", "i_b (A)", "i_c (A)"]


def test_a_view_that_blocks_loses_rows_and_the_recording_none(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In real time: in virtual time a view is waited for."""
    let_go = threading.Event()
    ended = TelemetryStream.__exit__

    def block(view: LiveView, _block: object) -> None:
        let_go.wait()

    def leave(stream: TelemetryStream, *error: object) -> None:
        let_go.set()
        ended(stream, *error)  # type: ignore[arg-type]

    monkeypatch.setattr(LiveView, "_take", block)
    monkeypatch.setattr(TelemetryStream, "__exit__", leave)
    monkeypatch.setattr("benchtool.clock.VirtualClock.register", _but_not_for_sinks)
    result = invoke(
        "record", "--duration", "20", "--out", "a", "--live", "a.rrd", "--channels", "torque,omega_m",
        "--rate", "100", "--json",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    bundle = Bundle.open(Path("a"))
    assert bundle.complete
    assert len(bundle.block("telemetry").data) == 2000
    values = json.loads(result.stdout)["certificate"]["measurements"]
    assert values["telemetry_rows_missing"]["value"] == 0
    # 100 blocks came, 64 waited and one was being handled
    assert values["telemetry_rows_dropped"]["value"] == 700


def _but_not_for_sinks(clock: object, settle: Callable[[], bool]) -> None:
    """What is waited for before time moves, the live sink apart."""
    worker = getattr(settle, "__self__", None)
    thread = getattr(worker, "_thread", None)
    if getattr(thread, "name", "") != "benchtool-live":
        clock._settlers.append(settle)  # type: ignore[attr-defined]


def test_a_view_that_fails_ends_nothing(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError("spectrum of nothing")

    monkeypatch.setattr("benchtool.live.view.running_spectra", fail)
    result = invoke("record", "--duration", "2", "--out", "a", "--live", "a.rrd")
    assert result.exit_code == 0, result.output
    assert "the live view has failed and stopped (ZeroDivisionError: spectrum of nothing)" in result.stderr
    assert "a.rrd: 200 rows were not shown; the recording of the run has them" in result.stderr
    assert len(Bundle.open(Path("a")).block("telemetry").data) == 200
    monkeypatch.setattr("benchtool.live.view.capture_spectra", fail)
    result = invoke("run", "short.toml", "--out", "b", "--live", "b.rrd")
    assert result.exit_code == 0, result.output
    assert result.stderr.count("the live view has failed") == 1


def test_a_viewer_that_is_killed_ends_nothing(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[Viewer] = []
    connect, send = Viewer.connect, RecordingSink.send
    sent: list[int] = []

    def noted(viewer: Viewer, stream: object) -> None:
        started.append(viewer)
        connect(viewer, stream)  # type: ignore[arg-type]

    def counted(sink: RecordingSink, messages: Iterable[Message], rows: int = 0) -> bool:
        sent.append(rows)
        if len([each for each in sent if each]) == 5:
            started[0].process.kill()
            started[0].process.wait()
        return send(sink, messages, rows)

    monkeypatch.setattr(Viewer, "connect", noted)
    monkeypatch.setattr(RecordingSink, "send", counted)
    result = invoke("record", "--duration", "3", "--out", "a", "--live", "web", "--live", "a.rrd")
    assert result.exit_code == 0, result.output
    assert "the web viewer is gone, the measurement goes on without it" in result.stderr
    bundle = Bundle.open(Path("a"))
    assert bundle.complete
    assert len(bundle.block("telemetry").data) == 300
    assert_holds(Recording.read(Path("a.rrd")), bundle.block("telemetry"), STREAM)


@pytest.mark.parametrize(
    ("arguments", "code", "line"),
    [
        (("demo", "--live", "nowhere"), 2, "--live nowhere: 'viewer', 'web' or a file that ends in .rrd"),
        (("live", "--save", "a.txt"), 2, "--save a.txt: a file that ends in .rrd is expected"),
        (("record", "--duration", "1", "--live", "short.toml/a.rrd"), 3, "cannot write short.toml/a.rrd: "),
        (("live", "--duration", "1"), 3, "the native viewer needs a display"),
        (("live", "nowhere", "--save", "a.rrd"), 2, "nowhere does not exist: give the folder of a run"),
        (("run", "short.toml", "--jobs", "2", "--live", "a.rrd"), 2, "--jobs 2 runs elsewhere than --live"),
        (("live", "--web", "--bind", "x"), 2, "'x' is no address to listen on"),
        (
            ("live", "run", "--rate", "10", "--save", "a.rrd"),
            2,
            "--channels, --rate, --link and --seed are for",
        ),
    ],
)
def test_what_cannot_be_shown_is_said_before_anything_runs(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...], code: int, line: str
) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    result = invoke(*arguments)
    assert result.exit_code == code, result.output
    lines = result.stderr.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith(f"benchtool: {line}")
    assert not Path("runs").exists()
    assert not list(Path.cwd().glob("*.rrd"))


def _rerun(*arguments: str) -> str:
    done = subprocess.run(
        [viewer_program(), *arguments], env=viewer_environment(), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stderr + done.stdout


def test_rerun_finds_nothing_wrong_with_a_recording(invoke: Invoke) -> None:
    assert invoke("run", "short.toml", "--out", "run", "--live", "a.rrd").exit_code == 0
    assert "1 file verified without error" in _rerun("rrd", "verify", "a.rrd")


def test_a_recording_without_an_end_gets_its_index_from_rerun(invoke: Invoke) -> None:
    assert invoke("record", "--duration", "2", "--out", "run", "--live", "a.rrd").exit_code == 0
    _rerun("rrd", "optimize", "a.rrd", "-o", "b.rrd")
    assert "1 file verified without error" in _rerun("rrd", "verify", "b.rrd")
    slow = Bundle.open(Path("run")).block("telemetry")
    for path in ("a.rrd", "b.rrd"):
        assert_holds(Recording.read(Path(path)), slow, STREAM)


@pytest.mark.skipif(not headless.POSSIBLE, reason="needs lavapipe (Debian: mesa-vulkan-drivers)")
def test_the_view_can_be_drawn_without_a_display(invoke: Invoke, tmp_path: Path) -> None:
    assert invoke("run", "short.toml", "--out", "run", "--live", "a.rrd").exit_code == 0
    with headless_viewer(tmp_path / "a.rrd") as viewer:
        views = viewer.get_state().views
        pixels = plt.imread(io.BytesIO(viewer.take_screenshot()), format="png")
    assert {view.name: view.reports for view in views if view.reports} == {}
    assert {"torque (Nm)", "phase currents (A)", "speed (rad/s)", "data quality"} <= {v.name for v in views}
    # torque and i_a of the capture, the reference circle, the hexagon
    for colour in ((86, 180, 233), (0, 158, 115), (230, 159, 0)):
        near = np.abs(pixels[:, :, :3] * 255.0 - colour).max(axis=2) < 12.0
        assert np.count_nonzero(near) > 100, f"nothing of colour {colour} is drawn"


@pytest.mark.skipif(browser.PROGRAM is None, reason="the page needs a browser (Debian: chromium)")
def test_the_page_shows_its_data_and_contacts_no_other_host(invoke: Invoke) -> None:
    assert invoke("record", "--duration", "1", "--out", "run").exit_code == 0
    with Viewer(web=True) as viewer, browser.browser(Path.cwd() / "profile") as page:
        page.open(f"{viewer.page}&renderer=webgl")
        data = f"http://127.0.0.1:{viewer.port}/"
        deadline_s = time.monotonic() + 90.0
        while not any(url.startswith(data) for url in page.asked_for) or not page.refused:
            assert time.monotonic() < deadline_s, f"the page asked for {page.asked_for} only"
            page.ask("Runtime.evaluate", expression="new Promise(r => setTimeout(r, 200))", awaitPromise=True)
        own = (viewer.page.split("?")[0], data)
        refused = set(page.refused)
        assert [url for url in page.asked_for if not url.startswith(own) and url not in refused] == []
    with contextlib.suppress(OSError):
        shutil.rmtree("profile")


# ---- pictures and pages that stay --------------------------------------------------------------------------


def test_pictures_of_a_run_are_named_as_its_recordings(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sinks, "take_picture", lambda recording: recording.read_bytes()[:4])
    assert invoke("run", "short.toml", "--out", "run").exit_code == 0
    shown = invoke("live", "run", "--png", "one.png", "--json")
    assert shown.exit_code == 0, shown.output
    assert json.loads(shown.stdout)["pictures"] == ["one.png"]
    assert (tmp_path / "one.png").read_bytes() == b"RRF2"
    for arguments, complaint in (
        (("run", "--png", "one.jpg"), "--png one.jpg: a file that ends in .png is expected"),
        (("--png", "one.png"), "which there is none without --duration: add it"),
    ):
        refused = invoke("live", *arguments)
        assert refused.exit_code == 2
        assert complaint in refused.stderr


def test_a_viewer_that_cannot_draw_says_what_that_needs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "rerun"
    program.write_text("#!/bin/sh\necho 'Error: no suitable graphics adapter'; exit 1\n", encoding="utf-8")
    program.chmod(0o755)
    monkeypatch.setattr(picture, "viewer_program", lambda: program)
    with pytest.raises(EnvironmentFailure, match=r"no suitable graphics adapter; .*mesa-vulkan-drivers"):
        picture.take_picture(tmp_path / "a.rrd")


@pytest.mark.parametrize("stay", [True, False])
def test_a_page_stays_if_asked_to_and_a_script_goes_on(stay: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    waited = []

    class Process:
        def wait(self, duration_s: float | None) -> None:
            waited.append(duration_s)
            raise KeyboardInterrupt

    class Page:
        web, page, process = True, "http://127.0.0.1:1", Process()

    monkeypatch.setattr("sys.stdin", io.StringIO())
    LiveDestinations([Page()], []).keep_open(Output(as_json=False), stay=stay)  # type: ignore[list-item]
    assert waited == ([None] if stay else [])
