"""The commands from a user's point of view: output, files, failures."""

from __future__ import annotations

import json
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from benchtool.cli import app
from benchtool.shipped import shipped

Invoke = Callable[..., Result]
ROOT = Path(__file__).parents[2]
PROFILE = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
PLAN = (shipped("profiles") / "zhu2011" / "ripple.toml").read_text(encoding="utf-8")
NAMES = {
    "torque_ripple_pp": "Nm",
    "torque_ripple_rms": "Nm",
    "torque_mean": "Nm",
    "transducer_torque_ripple_pp": "Nm",
    "flux_ripple_pp": "Wb",
    "current_fundamental": "A",
    "current_thd_f": "%",
    "current_max_low_harmonic": "A",
    "switching_frequency_mean": "Hz",
}


@pytest.fixture
def invoke(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    monkeypatch.chdir(tmp_path)

    def run(*arguments: str) -> Result:
        return CliRunner().invoke(app, arguments)

    return run


def _refused(result: Result, code: int) -> str:
    assert result.exit_code == code, result.output
    assert result.stdout == ""
    (line,) = result.stderr.strip().splitlines()[-1:]
    assert line.startswith("benchtool: ")
    assert "Traceback" not in result.output
    return line


def test_the_demo(invoke: Invoke) -> None:
    result = invoke("demo", "--json", "--out", "first")
    assert result.exit_code == 0, result.output
    document = json.loads(result.stdout)
    assert document["verdict"] == "pass"
    (case,) = document["cases"].values()
    measured = case["measurements"]
    assert {name: measured[name]["unit"] for name in NAMES} == NAMES
    assert all(measured[name]["definition"] for name in NAMES)
    value = {name: measured[name]["value"] for name in NAMES}
    assert 0.0 < value["torque_ripple_pp"] <= 0.06
    assert value["torque_mean"] == pytest.approx(0.65, abs=0.005)
    # 0.65 Nm / (3/2 4 0.1685 Wb) is the current that the torque needs
    assert value["current_fundamental"] == pytest.approx(0.643, rel=0.02)
    assert value["switching_frequency_mean"] == pytest.approx(10_000.0, rel=1e-3)
    assert value["transducer_torque_ripple_pp"] > value["torque_ripple_pp"]

    bundle = Path(case["bundle"])
    manifest = json.loads((bundle / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["complete"]
    assert manifest["verdict"] == "pass"
    assert manifest["parameters"]["psi_r_Wb"] == 0.1685
    assert not (bundle / "plots").exists()  # a verdict waits for no pictures

    again = invoke("analyze", str(bundle), "--json")
    assert again.exit_code == 0
    assert json.loads(again.stdout) == document


def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(invoke: Invoke) -> None:
    for folder, seed in (("a", "3"), ("b", "3"), ("c", "4")):
        assert invoke("demo", "--out", folder, "--seed", seed).exit_code == 0
    for name in ("capture.parquet", "transducer.parquet", "telemetry.parquet"):
        data = {folder: (Path(folder) / "data" / name).read_bytes() for folder in "abc"}
        assert data["a"] == data["b"]
        assert data["a"] != data["c"]


def test_for_people_the_table_stands_on_standard_output(invoke: Invoke) -> None:
    result = invoke("demo", "--out", "people")
    assert "verdict: pass" in result.stdout
    assert "capturing" in result.stderr
    printed = _rows(result.stdout)
    for page in ("README.md", "docs/start/emulated.md"):
        shown = _rows((ROOT / page).read_text(encoding="utf-8"))
        assert len(shown) == 2
        assert shown <= printed, page


def _rows(text: str) -> set[tuple[str, ...]]:
    """Return the cells of the rows of tables as the terminal has them."""
    rows = [line.strip("│").split("│") for line in text.splitlines() if "│" in line]
    return {tuple(filter(None, map(str.strip, row))) for row in rows}


def test_limits_that_are_missed_are_exit_code_1(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "strict.toml").write_text(PLAN.replace("max = 0.06", "max = 0.01"), encoding="utf-8")
    result = invoke("run", "strict.toml", "--json", "--out", "strict")
    assert result.exit_code == 1
    assert json.loads(result.stdout)["verdict"] == "fail"


def test_that_the_drive_is_compiled_is_told_only_where_it_is(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("first_call", "core.kernels"):
        monkeypatch.setattr(f"benchtool.emulator.{module}.is_cached", lambda _: False)
    assert "compiling" not in invoke("info").stderr  # which runs no tick


def test_info_says_who_answers(invoke: Invoke) -> None:
    result = invoke("info", "--json")
    assert result.exit_code == 0, result.output
    facts = json.loads(result.stdout)
    assert facts["device_name"] == "benchtool reference drive"
    assert facts["state"] == "switch on disabled"


def test_doctor_finds_this_machine_well(invoke: Invoke) -> None:
    result = invoke("doctor", "--json")
    assert result.exit_code == 0, result.output
    assert all(check["ok"] for check in json.loads(result.stdout).values())


def test_doctor_names_what_is_wrong(invoke: Invoke) -> None:
    result = invoke("doctor", "--link", "emulated?node=9", "--json")
    assert result.exit_code == 3
    assert "node 9 did not answer" in json.loads(result.stdout)["drive"]["seen"]


@pytest.mark.parametrize(
    ("arguments", "code", "complaint"),
    [
        (
            ("run", "zhu2011/ripple", "--profile", "zhu2012"),
            2,
            "no profile 'zhu2012': did you mean 'zhu2011'? the names are motors/",
        ),
        (
            ("run", "zhu2011/riple"),
            2,
            "no plan 'zhu2011/riple': did you mean 'zhu2011/ripple'? the names are motors/speed_and_load, ",
        ),
        (("run", "zhu2011/ripple", "--link", "can:nonsense:0"), 3, "cannot open can:nonsense:0"),
        (("run", "zhu2011/ripple", "--link", "usb0"), 2, "link 'usb0' is not known"),
        (("run", "zhu2011/ripple", "--link", "emulated?node=5"), 3, "node 5"),
        (("info", "--link", "can:virtual:no-drive"), 3, "node 1"),
        (("analyze", "nowhere"), 2, "nowhere"),
        (("compare", "nowhere", "elsewhere"), 2, "elsewhere does not exist"),
        (("verify", "nowhere"), 2, "nowhere does not exist"),
        (("analyze", "--csv", "nowhere.csv", "--rate", "1kHz", "--current", "i"), 2, "nowhere.csv"),
        (("run", "zhu2011/ripple", "--resume", "nowhere"), 2, "nowhere does not exist"),
    ],
)
def test_mistakes_on_the_command_line(
    invoke: Invoke, arguments: tuple[str, ...], code: int, complaint: str
) -> None:
    assert complaint in _refused(invoke(*arguments), code)


@pytest.mark.parametrize(
    ("change", "code", "complaint"),
    [
        (("u_s_V", "u_s_v"), 2, "line 7: no parameter 'u_s_v' in drive.eds: write 'u_s_V'"),
        (("u_s_V = 81.65", "u_s_V = 1e6"), 2, "u_s"),
        (('law = "tpc"', 'law = "tcp"'), 2, "tcp"),
        (('"i_a",', '"i_x",'), 2, "i_x"),
        (("omega_m_rad_s = 15.71", "omega_m_rad_s = nan"), 2, "omega_m_rad_s"),
        (('law = "tpc"', "control_period_s = 1e-3"), 2, "line 6: 'control_period_s' is not a parameter"),
        (('law = "tpc"', "torque_command_Nm = 1.0"), 2, "line 6: 'torque_command_Nm' is not a parameter"),
    ],
)
def test_mistakes_in_a_plan(
    invoke: Invoke, tmp_path: Path, change: tuple[str, str], code: int, complaint: str
) -> None:
    (tmp_path / "mine.toml").write_text(PLAN.replace(*change), encoding="utf-8")
    assert complaint.lower() in _refused(invoke("run", "mine.toml", "--out", "x"), code).lower()


def test_a_misspelt_key_in_a_profile(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(PROFILE.replace("J_kgm2", "J_kgcm2"), encoding="utf-8")
    line = _refused(invoke("info", "--profile", "mine.toml"), 2)
    assert "did you mean 'J_kgm2'?" in line


def test_another_dictionary_is_refused_by_its_hash(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(PROFILE.replace("drive.eds", "old.eds"), encoding="utf-8")
    eds = (shipped("firmware_protocol") / "drive.eds").read_text(encoding="utf-8")
    head, section, tail = eds.partition("[2060]")
    old = "\n".join(
        "DefaultValue=0x12345678" if line.startswith("DefaultValue") else line
        for line in tail.split("\n")[:12]
    )
    rest = "\n".join(tail.split("\n")[12:])
    (tmp_path / "old.eds").write_text(f"{head}{section}{old}\n{rest}", encoding="utf-8")
    line = _refused(invoke("info", "--profile", "mine.toml"), 3)
    assert "0x12345678" in line
    assert "old.eds" in line


def test_a_folder_that_is_in_use_is_refused(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "thesis.txt").write_text("mine", encoding="utf-8")
    assert "taken" in _refused(invoke("demo", "--out", "taken"), 3)
    assert (tmp_path / "taken" / "thesis.txt").read_text(encoding="utf-8") == "mine"


def _limit_file_size() -> None:
    """As on a full disk: a write beyond the first 100 kB of a file fails."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))


def test_a_disk_that_fills_up_is_one_line_and_leaves_a_bundle_that_says_so(tmp_path: Path) -> None:
    done = subprocess.run(
        (sys.executable, "-m", "benchtool", "demo", "--json", "--out", "full"),
        cwd=tmp_path,
        preexec_fn=_limit_file_size,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 3, done.stderr
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    line = done.stderr.strip().splitlines()[-1]
    assert line.startswith("benchtool: cannot write")
    assert "full" in line
    manifest = json.loads((tmp_path / "full" / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["verdict"] == "fail"
    assert "RecordingError" in manifest["details"]["failure"]


def test_an_interrupt_ends_with_130_and_a_way_to_go_on(tmp_path: Path) -> None:
    running = subprocess.Popen(
        (sys.executable, "-m", "benchtool", "demo", "--real-time", "--out", "cut"),
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert running.stderr is not None
    for line in running.stderr:
        if line.startswith("running at"):
            running.send_signal(signal.SIGTERM)
            break
    rest = running.stderr.read()
    running.stderr.close()
    assert running.wait() == 130
    assert "interrupted; the drive was left disabled" in rest
    assert "--resume cut" in rest
    manifest = json.loads((tmp_path / "cut" / "manifest.json").read_text(encoding="utf-8"))
    assert "KeyboardInterrupt" in manifest["details"]["failure"]
