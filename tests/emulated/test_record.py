"""`benchtool record`: its bundle, replayed bit by bit, after any end."""

from __future__ import annotations

import contextlib
import itertools
import json
import os
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import can
import numpy as np
import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app
from benchtool.emulator.bench import EmulatedBench
from benchtool.profile import load_profile
from benchtool.recording import Bundle
from benchtool.shipped import shipped
from benchtool.telemetry import TelemetryStream

from .test_telemetry import power_off

Invoke = Callable[..., Result]
_numbers = itertools.count()


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Result:
        return CliRunner().invoke(app, ("record", *arguments))

    return run


@pytest.fixture
def after_checks(monkeypatch: pytest.MonkeyPatch) -> Callable[[int, Callable[[], None]], None]:
    """Has something happen when the running recording is checked for the n-th time."""
    check = TelemetryStream.check

    def arrange(number: int, happens: Callable[[], None]) -> None:
        counter = itertools.count(1)

        def checked(stream: TelemetryStream) -> None:
            if next(counter) == number:
                happens()
            check(stream)

        monkeypatch.setattr(TelemetryStream, "check", checked)

    return arrange


def _refused(result: Result, code: int) -> str:
    assert result.exit_code == code, result.output
    assert result.stdout == ""
    lines = [line for line in result.stderr.splitlines() if line.startswith("benchtool: ")]
    assert "Traceback" not in result.output
    return lines[0]


def _cut_short(folder: str, rows: int, failure: str) -> Bundle:
    bundle = Bundle.open(Path(folder))
    assert not bundle.complete
    assert bundle.manifest.details["failure"].startswith(failure)
    assert len(bundle.block("telemetry").data) == rows
    return bundle


def test_a_recording(invoke: Invoke) -> None:
    result = invoke(
        "--duration", "2", "--out", "a", "--channels", "torque, omega_m", "--note", "cold", "--json"
    )
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["certificate"]["complete"] is True
    bundle = Bundle.open(Path("a"))
    assert bundle.complete
    assert bundle.certificate == document["certificate"]
    block = bundle.block("telemetry")
    assert (block.names, block.data.shape, block.sample_rate_Hz) == (("torque", "omega_m"), (200, 2), 100.0)
    manifest = bundle.manifest
    assert manifest.note == "cold"
    assert manifest.parameters["psi_r_Wb"] == 0.1685
    assert manifest.identity["device_name"] == "benchtool reference drive"
    assert manifest.details["state"] == "switch on disabled"
    assert manifest.details["telemetry"]["clock_fit"]["records"] == 200
    assert manifest.dictionary_hash == manifest.identity["dictionary_hash"]


def test_what_the_operator_states_is_in_the_manifest(invoke: Invoke, tmp_path: Path) -> None:
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    sensor = '[bench.channels.torque]\nserial_number = "7"\ndue = 2000-01-01\n'
    (tmp_path / "mine.toml").write_text(f"{text}\n{sensor}", encoding="utf-8")
    result = invoke(
        *("--duration", "0.1", "--out", "run", "--profile", "mine.toml", "--note", "cold"),
        *("--operator", "A. Müller", "--serial-number", "M-17", "--temperature", "21.5"),
        *("--instrument", "T40B", "--instrument", "LEM"),
    )
    assert result.exit_code == 0, result.output
    manifest = Bundle.open(tmp_path / "run").manifest
    assert manifest.note == "cold"
    assert manifest.conditions.model_dump() == {
        "operator": "A. Müller",
        "test_object_serial_number": "M-17",
        "temperature_degC": 21.5,
        "instruments": ("T40B", "LEM"),
    }
    assert "warning: calibration of torque (no. 7) was due on 2000-01-01" in result.stderr
    assert invoke("--duration", "0.1", "--temperature", "nan").exit_code == 2


def test_the_same_seed_gives_the_same_bytes(invoke: Invoke) -> None:
    for folder in "ab":
        assert invoke("--duration", "1", "--out", folder, "--seed", "3", "--frames").exit_code == 0
    for name in ("telemetry.parquet", "frames.log"):
        first, second = ((Path(folder) / "data" / name).read_bytes() for folder in "ab")
        assert first == second


def test_a_bundle_with_frames_replays_bit_by_bit(invoke: Invoke) -> None:
    options = ("--duration", "1.5", "--channels", "i_a,i_b,torque", "--rate", "250")
    assert invoke(*options, "--out", "a", "--frames").exit_code == 0
    assert invoke(*options, "--out", "b", "--link", "replay:a").exit_code == 0
    first, second = Bundle.open(Path("a")), Bundle.open(Path("b"))
    assert (Path("a/data/telemetry.parquet")).read_bytes() == (Path("b/data/telemetry.parquet")).read_bytes()
    assert len(first.block("telemetry").data) == 375
    assert second.manifest.parameters == first.manifest.parameters
    assert second.manifest.identity == first.manifest.identity


def test_a_replay_does_only_what_was_done(invoke: Invoke) -> None:
    assert invoke("--duration", "1", "--out", "a", "--frames").exit_code == 0
    line = _refused(invoke("--duration", "1", "--link", "replay:a", "--channels", "torque", "--out", "b"), 3)
    assert "a replay does only what was done then" in line
    line = _refused(invoke("--duration", "9", "--link", "replay:a", "--out", "c"), 3)
    assert "the recording a ends after 1.00 s" in line
    assert len(Bundle.open(Path("c")).block("telemetry").data) == 100
    line = _refused(invoke("--duration", "1", "--link", "replay:a?node=5", "--out", "d"), 3)
    assert "no answer of node 5" in line
    invoke("--duration", "1", "--out", "plain")
    line = _refused(invoke("--duration", "1", "--link", "replay:plain", "--out", "e"), 3)
    assert "recorded with --frames is expected" in line


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        (("--channels", "torqe"), 2, "did you mean 'torque'"),
        (("--rate", "300"), 2, "choose 333.333 Hz"),
        (("--link", "emulated?node=9"), 3, "node 9 did not answer"),
        (("--link", "replay:nowhere"), 3, "cannot replay nowhere"),
        (("--out", "/proc/nothing"), 3, "cannot write /proc/nothing"),
    ],
)
def test_mistakes(invoke: Invoke, arguments: tuple[str, ...], code: int, complaint: str) -> None:
    assert complaint in _refused(invoke("--duration", "1", *arguments), code)
    assert list(Path().iterdir()) == [], "a mistake leaves no folder"


def test_a_folder_in_use_is_left_alone(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "thesis.txt").write_text("mine", encoding="utf-8")
    assert "taken has content" in _refused(invoke("--duration", "1", "--out", "taken"), 3)
    assert [path.name for path in (tmp_path / "taken").iterdir()] == ["thesis.txt"]


# ---- however it ends -------------------------------------------------------------------------------------


def test_a_drive_that_vanishes_leaves_what_came(
    invoke: Invoke, after_checks: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    benches: list[EmulatedBench] = []
    host_bus = EmulatedBench.host_bus

    def watched(bench: EmulatedBench) -> object:
        benches.append(bench)
        return host_bus(bench)

    monkeypatch.setattr(EmulatedBench, "host_bus", watched)
    after_checks(10, lambda: power_off(benches[0]))
    line = _refused(invoke("--duration", "60", "--out", "a"), 3)
    assert "the stream of node 1 stopped" in line
    bundle = _cut_short("a", 50, "NoAnswer: the stream of node 1 stopped")
    assert bundle.certificate is not None


def test_a_reset_of_the_drive_leaves_what_came(invoke: Invoke, after_checks: Callable[..., None]) -> None:
    channel = f"record-{next(_numbers)}"
    with can.Bus(interface="virtual", channel=channel) as bus:
        reset = can.Message(arbitration_id=0, data=[0x81, 1], is_extended_id=False)
        after_checks(10, lambda: bus.send(reset))
        line = _refused(invoke("--duration", "60", "--out", "a", "--link", f"emulated?channel={channel}"), 4)
    assert "its heartbeat says pre-operational" in line
    _cut_short("a", 50, "StateError: the stream of node 1 stopped")


@contextlib.contextmanager
def _recording(folder: Path, *arguments: str, before: str = "") -> Iterator[subprocess.Popen[str]]:
    """The command as a process of its own."""
    code = f"{before}\nfrom benchtool.cli import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "record", "--out", str(folder), *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=folder.parent,
    )
    with process:
        try:
            yield process
        finally:
            process.kill()


def _await(process: subprocess.Popen[str], beginning: str) -> None:
    assert process.stderr is not None
    seen: list[str] = []
    for line in iter(process.stderr.readline, ""):
        seen.append(line)
        if line.startswith(beginning):
            return
    raise AssertionError("".join(seen))


def test_a_killed_recording_loses_at_most_the_last_second(tmp_path: Path) -> None:
    with _recording(tmp_path / "a", "--duration", "600", "--real-time", "--frames") as process:
        _await(process, "2 of 600 s")
        process.kill()
    bundle = Bundle.open(tmp_path / "a")
    assert not bundle.complete
    rows = len(bundle.block("telemetry").data)
    assert rows >= 100
    assert bundle.block("telemetry").gaps == ()
    told = f"{tmp_path / 'a'} is incomplete: it was cut short (its process ended), what was recorded until"
    for verb, code in (("analyze", 1), ("verify", 0), ("export", 0)):
        options = ("--out", str(tmp_path / "a.csv")) if verb == "export" else ()
        read = CliRunner().invoke(app, (verb, str(tmp_path / "a"), *options))
        assert (verb, read.exit_code, told in read.stderr) == (verb, code, True)
    seconds = f"{rows / 100 - 0.5:.1f}"
    again = CliRunner().invoke(
        app,
        ("record", "--duration", seconds, "--link", f"replay:{tmp_path / 'a'}", "--out", str(tmp_path / "b")),
    )
    assert again.exit_code == 0, again.output
    replayed = Bundle.open(tmp_path / "b").block("telemetry").data
    np.testing.assert_array_equal(replayed, bundle.block("telemetry").data[: len(replayed)])


def test_a_node_with_few_pdos_streams_what_matters_most(tmp_path: Path) -> None:
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    profile = tmp_path / "far.toml"
    profile.write_text(text.replace("node_id = 1\n", "node_id = 70\n"), encoding="utf-8")
    folder = tmp_path / "run"
    options = ("--profile", str(profile), "--duration", "1", "--out", str(folder))
    result = CliRunner().invoke(app, ("record", *options))
    assert result.exit_code == 0, result.output
    names = Bundle.open(folder).block("telemetry").names
    assert names == ("torque", "torque_reference", "omega_m", "i_q", "i_d")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_recording_that_is_ended_by_hand_is_complete(tmp_path: Path, number: int) -> None:
    with _recording(tmp_path / "a", "--real-time") as process:
        _await(process, "1 s, ")
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 0, err
    assert "benchtool: " not in err
    assert "ended by hand after " in out
    bundle = Bundle.open(tmp_path / "a")
    assert bundle.complete
    assert bundle.manifest.details["ended_by"] == "hand"
    assert bundle.manifest.details["lasted_s"] >= 1.0
    assert len(bundle.block("telemetry").data) >= 100
    assert bundle.certificate is not None
    assert bundle.certificate["complete"]


def test_an_end_by_hand_before_the_duration_is_told_in_json_alone(
    invoke: Invoke, after_checks: Callable[..., None]
) -> None:
    after_checks(10, lambda: signal.raise_signal(signal.SIGINT))
    before = signal.getsignal(signal.SIGINT)
    result = invoke("--duration", "60", "--json", "--out", "a")
    assert result.exit_code == 0, result.output
    assert "rows/s" not in result.stderr
    document = json.loads(result.stdout)
    assert (document["ended_by"], document["lasted_s"]) == ("hand", pytest.approx(0.5))
    assert document["certificate"]["complete"]
    assert len(Bundle.open(Path("a")).block("telemetry").data) == 50
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_interruption_ends_it_at_once_and_says_so(
    invoke: Invoke, after_checks: Callable[..., None]
) -> None:
    def twice() -> None:
        for _ in range(2):  # each is handled before the loop goes round
            signal.raise_signal(signal.SIGINT)

    after_checks(10, twice)
    result = invoke("--duration", "60", "--out", "a")
    assert result.exit_code == 130
    _cut_short("a", 50, "KeyboardInterrupt")


def test_a_disk_that_fills_up_ends_the_recording_with_what_was_written(tmp_path: Path) -> None:
    limit = 100_000
    before = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, {limit}))"
    with _recording(tmp_path / "a", "--duration", "600", before=before) as process:
        _, err = process.communicate(timeout=120)
    assert process.returncode == 3, err
    assert "Traceback" not in err
    (line, *_) = [line for line in err.splitlines() if line.startswith("benchtool: ")]
    assert "cannot write" in line
    assert "telemetry.arrows" in line
    bundle = Bundle.open(tmp_path / "a")
    rows = len(bundle.block("telemetry").data)
    assert 500 < rows < 60_000
    assert os.path.getsize(tmp_path / "a" / "data" / "telemetry.arrows") <= limit
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != limit


# ---- over the wall clock, as with a real adapter ---------------------------------------------------------


def test_a_drive_in_its_own_time_is_recorded_and_replayed(invoke: Invoke) -> None:
    channel = f"record-{next(_numbers)}"
    bench = EmulatedBench(load_profile("zhu2011"), channel, paced=True)
    stop = threading.Event()

    def live() -> None:
        while not stop.is_set():
            bench.clock.wait(0.01)

    drive = threading.Thread(target=live)
    drive.start()
    try:
        options = ("--duration", "0.5", "--rate", "200")
        result = invoke(*options, "--link", f"can:virtual:{channel}", "--out", "a", "--frames", "--json")
    finally:
        stop.set()
        drive.join()
        bench.close()
    assert result.exit_code == 0, result.output
    certificate = json.loads(result.stdout)["certificate"]
    assert certificate["complete"]
    measured = {name: each["value"] for name, each in certificate["measurements"].items()}
    assert 0.0 < measured["arrival_jitter_rms"] <= measured["arrival_jitter_max"] < 0.5
    assert 0.0 < measured["clock_residual_rms"] <= measured["clock_residual_max"] < 0.5

    again = invoke(*options, "--link", "replay:a", "--out", "b", "--json")
    assert again.exit_code == 0, again.output
    assert Path("a/data/telemetry.parquet").read_bytes() == Path("b/data/telemetry.parquet").read_bytes()
    replayed = json.loads(again.stdout)["certificate"]["measurements"]
    assert replayed["arrival_jitter_rms"]["value"] == pytest.approx(measured["arrival_jitter_rms"], rel=1e-3)


# ---- export ----------------------------------------------------------------------------------------------


def test_a_recording_is_exported(invoke: Invoke) -> None:
    assert invoke("--duration", "1", "--out", "a", "--channels", "torque").exit_code == 0
    done = CliRunner().invoke(app, ("export", "a", "--json"))
    assert done.exit_code == 0, done.output
    document = json.loads(done.stdout)
    assert (document["file"], document["stream"], document["rows"]) == ("a-telemetry.csv", "telemetry", 100)
    assert document["channels"] == {"torque": "Nm"}
    assert Path("a-telemetry.csv").read_text(encoding="utf-8").startswith("tick,time_s [s],torque [Nm]\n")
    assert "overwrites nothing" in _refused(CliRunner().invoke(app, ("export", "a")), 3)
    assert CliRunner().invoke(app, ("export", "a", "--format", "xls")).exit_code == 2


def test_a_count_that_is_not_known_is_told_with_its_reason(invoke: Invoke) -> None:
    """It was a dash in the table, and nothing said why."""
    told = invoke("--duration", "0.3", "--channels", "torque", "--out", "run").stdout
    for name in ("adc_saturated", "law_clipped"):
        assert f"undefined: telemetry_{name}_count: {name} is not recorded: record it too" in told
