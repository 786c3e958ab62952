"""The wheel is complete: it runs the demo in a new environment, without the checkout."""

from __future__ import annotations

import ast
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from dataclasses import dataclass
from email import message_from_bytes
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
IMPORT_ALL = """
import importlib, pkgutil, benchtool
for module in pkgutil.walk_packages(benchtool.__path__, "benchtool."):
    if not module.name.endswith("__main__"):
        print(importlib.import_module(module.name).__name__)
"""


def _run(*command: str | Path, cwd: Path, home: Path) -> str:
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    done = subprocess.run(
        command, cwd=cwd, env={**environment, "HOME": str(home)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _distribution(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _imported(sources: zipfile.ZipFile) -> set[str]:
    """Top-level modules which the package's sources in the wheel import, but for those of an extra."""
    found: set[str] = set()
    for path in sources.namelist():
        if path.endswith(".py") and path.startswith("benchtool/") and "/_shipped/" not in path:
            for node in ast.walk(ast.parse(sources.read(path))):
                if isinstance(node, ast.Import):
                    found |= {each.name.partition(".")[0] for each in node.names}
                elif isinstance(node, ast.ImportFrom) and not node.level:
                    found.add(str(node.module).partition(".")[0])
    return found - sys.stdlib_module_names - {"benchtool"}


@dataclass(frozen=True)
class Installed:
    """The wheel, and an environment of its own in which it is installed, with an empty home."""

    wheel: Path
    python: Path
    elsewhere: Path
    home: Path

    def run(self, name: str, *arguments: str | Path) -> str:
        return _run(self.python.with_name(name), *arguments, cwd=self.elsewhere, home=self.home)


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Installed:
    place = tmp_path_factory.mktemp("installed")
    home, wheels, elsewhere = place / "home", place / "wheels", place / "elsewhere"
    for folder in (home, wheels, elsewhere):
        folder.mkdir()
    build = (sys.executable, "-m", "build", "--wheel", "--no-isolation", "-o", wheels, ROOT)
    _run(*build, cwd=elsewhere, home=home)
    (wheel,) = wheels.glob("*.whl")

    # The dependencies come from the environment of the tests. A .pth file in a folder which
    # another .pth file adds is not read, so the checkout, installed there as editable, is out of reach.
    environment = place / "venv"
    venv.create(environment)
    python = environment / "bin" / "python"
    packages = Path(sysconfig.get_path("purelib", vars={"base": str(environment)}))
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    pip = (sys.executable, "-m", "pip", "--python", python, "install")
    _run(*pip, "--quiet", "--no-deps", "--no-index", wheel, cwd=elsewhere, home=home)
    return Installed(wheel, python, elsewhere, home)


def test_the_wheel_declares_what_it_imports(installed: Installed) -> None:
    with zipfile.ZipFile(installed.wheel) as archive:
        (metadata,) = (name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
        required = message_from_bytes(archive.read(metadata)).get_all("Requires-Dist", [])
        imported = _imported(archive)
    declared = {_distribution(re.split(r"[^\w.-]", each, maxsplit=1)[0]) for each in required}
    installed_by = packages_distributions()
    providers = {name: {_distribution(each) for each in installed_by[name]} for name in imported}
    assert [name for name in imported if not declared & providers[name]] == []


def test_the_wheel_has_every_file_of_the_package(installed: Installed) -> None:
    listed = _run("git", "ls-files", "benchtool", cwd=ROOT, home=installed.home).split()
    with zipfile.ZipFile(installed.wheel) as archive:
        assert set(listed) <= set(archive.namelist())


def test_every_module_of_the_wheel_is_imported_in_an_environment_of_its_own(installed: Installed) -> None:
    names = installed.run("python", "-c", IMPORT_ALL).split()
    assert len(names) > 500
    where = installed.run("python", "-c", "import benchtool; print(benchtool.__file__)")
    assert Path(where.strip()).is_relative_to(installed.python.parents[1])
    installed.run("benchtool", "plan", "new", "mine.toml")  # of a profile that is shipped
    assert (installed.elsewhere / "mine.toml").is_file()


@pytest.mark.slow
def test_the_wheel_runs_the_demo_in_an_environment_of_its_own(installed: Installed) -> None:
    case = json.loads(installed.run("benchtool", "demo", "--json"))["cases"]["tpc"]
    assert set(case["measurements"]) >= {"torque_ripple_pp", "transducer_torque_ripple_pp", "current_thd_f"}
    bundle = installed.elsewhere / case["bundle"]
    installed.run("benchtool", "report", bundle, "--png")
    assert (bundle / "report.html").is_file()
    assert (bundle / "plots" / "waveforms.png").is_file()


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
