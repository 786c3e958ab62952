"""`benchtool verify`: a flipped bit is named, and a number that was forged with its hash is found."""

from __future__ import annotations

import json
import random
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from benchtool.recording.manifest import MANIFEST, MEASUREMENTS
from benchtool.recording.seal import SEAL, hash_of, write_json
from benchtool.results import verify_run
from tests.at_length import at_length

PLAN = """
title = "short"
profile = "zhu2011"
operating_point = { omega_m_rad_s = 15.71, load_torque_Nm = 0.65, settle_s = 0.2 }
record = { duration_s = 0.21, channels = ["i_a", "torque"] }
limits = { torque_ripple_pp = { max = 0.1 } }
"""


def _invoked(*arguments: str | Path) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    return result.exit_code, result.output


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("verify")
    (place / "short.toml").write_text(PLAN, encoding="utf-8")
    assert _invoked("run", place / "short.toml", "--out", place / "run")[0] in (0, 1)
    assert _invoked("report", place / "run", "--png")[0] in (0, 1)
    return place / "run"


@pytest.fixture
def run(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded, tmp_path / "run"))


@pytest.mark.parametrize("name", ["", "report.html", "plots/waveforms.png", MANIFEST])
def test_a_run_as_it_was_written_is_verified(run: Path, name: str) -> None:
    if name.startswith("plots"):
        name = next((run / "plots").iterdir()).relative_to(run).as_posix()
    code, told = _invoked("verify", run / name, "--json")
    document = json.loads(told[told.index("{\n") :])
    assert code == 0, told
    assert document["verdict"] == "pass"
    results = json.loads((run / MEASUREMENTS).read_text(encoding="utf-8"))
    tables = json.loads((run / "tables.json").read_text(encoding="utf-8"))
    assert document["recomputed"] == len(results) + len(tables) + 1
    assert document["files"] == sum(path.is_file() for path in run.rglob("*"))


@pytest.mark.parametrize("flips", [12, *at_length(100)])
def test_a_flipped_bit_is_named_every_time(run: Path, flips: int) -> None:
    files = sorted(path for path in run.rglob("*") if path.is_file())
    chance = random.Random(2)
    for _ in range(flips):
        path = chance.choice(files)
        content = path.read_bytes()
        place = chance.randrange(len(content))
        flipped = (
            content[:place] + bytes([content[place] ^ (1 << chance.randrange(8))]) + content[place + 1 :]
        )
        path.write_bytes(flipped)
        found = verify_run(run)
        assert not found.holds
        assert path.relative_to(run).as_posix() in found.damaged
        path.write_bytes(content)
    assert verify_run(run).holds


def test_the_command_names_the_file(run: Path) -> None:
    (run / "report.html").write_bytes((run / "report.html").read_bytes()[:-1])
    code, told = _invoked("verify", run)
    assert code == 1
    assert f"{run / 'report.html'}: it has" in told


def _forge(run: Path, name: str, content: bytes) -> None:
    """Replace a file and have the manifest fit it."""
    (run / name).write_bytes(content)
    manifest = json.loads((run / MANIFEST).read_text(encoding="utf-8"))
    del manifest[SEAL]
    of_file = hash_of(run / name)
    manifest["files"][name] = of_file.model_dump()
    write_json(run / MANIFEST, manifest, sealed=True)


def test_a_forged_number_differs_from_the_data(run: Path) -> None:
    results = json.loads((run / MEASUREMENTS).read_text(encoding="utf-8"))
    results["torque_mean"]["value"] *= 1.0 + 2.0**-50
    _forge(run, MEASUREMENTS, json.dumps(results).encode())
    code, told = _invoked("verify", run, "--json")
    document = json.loads(told[told.index("{\n") :])
    assert (code, document["damaged"]) == (1, {})
    assert list(document["different"]) == ["torque_mean"]
    assert "the data give" in document["different"]["torque_mean"]


def test_a_forged_verdict_differs_from_the_data(run: Path) -> None:
    manifest = json.loads((run / MANIFEST).read_text(encoding="utf-8"))
    del manifest[SEAL]
    other = "fail" if manifest["verdict"] != "fail" else "pass"
    write_json(run / MANIFEST, {**manifest, "verdict": other}, sealed=True)
    assert list(verify_run(run).different) == ["verdict"]


def test_data_of_another_run_give_other_numbers(run: Path, recorded: Path, tmp_path: Path) -> None:
    plan = recorded.parent / "short.toml"
    assert _invoked("run", plan, "--out", tmp_path / "other", "--seed", "2")[0] in (0, 1)
    _forge(run, "data/capture.parquet", (tmp_path / "other" / "data" / "capture.parquet").read_bytes())
    found = verify_run(run)
    assert not found.damaged
    assert "torque_mean" in found.different


def test_a_file_without_a_hash_is_not_verified(run: Path) -> None:
    (run / "signed.pdf").write_bytes(b"another")
    assert verify_run(run).unlisted == ("signed.pdf",)
    code, told = _invoked("verify", run / "signed.pdf")
    assert code == 1
    assert "it has no hash in its folder" in told


def test_what_is_no_run(tmp_path: Path) -> None:
    code, told = _invoked("verify", tmp_path)
    assert code == 2
    assert "holds no run bundle" in told


def test_a_recording_without_a_plan_has_its_files_compared(tmp_path: Path) -> None:
    assert _invoked("record", "--duration", "0.1", "--out", tmp_path / "recorded")[0] == 0
    code, told = _invoked("verify", tmp_path / "recorded")
    assert code == 0
    assert "not measured again" in told
