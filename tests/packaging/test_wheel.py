"""The wheel is complete: in an empty environment it runs the demo with nothing of the checkout."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def _run(*command: str | Path, cwd: Path, home: Path) -> str:
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    done = subprocess.run(
        command, cwd=cwd, env={**environment, "HOME": str(home)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.packaging
def test_the_wheel_runs_the_demo_in_a_clean_environment(tmp_path: Path) -> None:
    home, wheels, elsewhere = tmp_path / "home", tmp_path / "wheels", tmp_path / "elsewhere"
    for folder in (home, wheels, elsewhere):
        folder.mkdir()
    build = (sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", wheels, ROOT)
    _run(*build, cwd=elsewhere, home=home)
    (wheel,) = wheels.glob("*.whl")
    venv.create(tmp_path / "venv", with_pip=True)
    python = tmp_path / "venv" / "bin" / "python"
    lock = ROOT / "requirements-dev.lock"
    _run(python, "-m", "pip", "install", "--quiet", "--constraint", lock, wheel, cwd=elsewhere, home=home)

    printed = _run(python.with_name("benchtool"), "demo", "--json", cwd=elsewhere, home=home)

    case = json.loads(printed)["cases"]["tpc"]
    assert set(case["measurements"]) >= {"torque_ripple_pp", "true_torque_ripple_pp", "current_thd"}
    assert (elsewhere / case["bundle"] / "plots" / "waveforms.png").is_file()
    where = _run(python, "-c", "import benchtool; print(benchtool.__file__)", cwd=elsewhere, home=home)
    assert Path(where.strip()).is_relative_to(tmp_path)


@pytest.mark.packaging
def test_what_make_built_is_in_no_distribution(tmp_path: Path) -> None:
    tree, distributions = tmp_path / "tree", tmp_path / "distributions"
    for folder in ("benchtool", "profiles", "firmware_protocol"):
        shutil.copytree(ROOT / folder, tree / folder, ignore=shutil.ignore_patterns("build", "__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE", ".gitignore"):
        shutil.copy(ROOT / name, tree)
    sources = {path.relative_to(tree) for path in (tree / "firmware_protocol").rglob("*") if path.is_file()}
    built = tree / "firmware_protocol" / "c" / "build" / "drive"
    built.parent.mkdir()
    built.touch()

    for target in ("wheel", "sdist"):
        build = (sys.executable, "-m", "hatchling", "build", "-t", target, "-d", distributions)
        _run(*build, cwd=tree, home=tmp_path)

    (wheel,), (sdist,) = distributions.glob("*.whl"), distributions.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        packed = {Path(name).relative_to(sdist.name.removesuffix(".tar.gz")) for name in archive.getnames()}
    assert {path for path in packed if path.parts[0] == "firmware_protocol"} == sources
    with zipfile.ZipFile(wheel) as archive:
        packed = {Path(name) for name in archive.namelist()}
    shipped = Path("benchtool", "_shipped")
    assert {path.relative_to(shipped) for path in packed if path.is_relative_to(shipped)} == sources | {
        path.relative_to(tree) for path in (tree / "profiles").rglob("*") if path.is_file()
    }
