"""The sources for a firmware project: free of races, valid C++, with licence, and with a lock."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

from tests.device.c_drive import FOLDER, make

COPIED = [*FOLDER.rglob("*.[ch]"), FOLDER.parent / "drive_objects.h"]
PUBLIC = [*FOLDER.glob("*.h"), FOLDER.parent / "drive_objects.h"]
MACROS_ONLY = {"bt_abort.h", "bt_config.h", "bt_version.h"}


def _compiler() -> str:
    if (found := shutil.which("gcc") or shutil.which("clang")) is None:
        pytest.skip("the C library needs gcc or clang, not installed here")
    return found


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_threads_in_place_of_interrupts_do_not_race(compiler: str, tmp_path: Path) -> None:
    """A race, a crash or a lock taken twice fails; a compiler without ThreadSanitizer is passed over."""
    if compiler not in make(tmp_path, "tsan-compilers").split("ThreadSanitizer:")[1].split():
        pytest.skip(f"{compiler} with ThreadSanitizer is not installed here")
    assert "captures" in make(tmp_path, str(tmp_path / f"passed-threads-{compiler}"))


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_every_header_is_one_of_cxx_too(compiler: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed here")
    make(tmp_path, str(tmp_path / f"passed-cxx-{compiler}"))


def test_a_firmware_without_a_lock_does_not_compile() -> None:
    """Off a Cortex-M it says itself what its lock is, or that one thread calls all of the library."""

    def compiled(*options: str) -> subprocess.CompletedProcess[str]:
        flags = ["-std=c99", f"-I{FOLDER}", f"-I{FOLDER.parent}", "-fsyntax-only", *options]
        return subprocess.run(
            [_compiler(), *flags, FOLDER / "bt_capture.c"], capture_output=True, text=True, check=False
        )

    refused = compiled()
    assert refused.returncode != 0
    assert "define BT_LOCK() and BT_UNLOCK()" in refused.stderr
    assert compiled("-DBT_LOCK()=").returncode != 0
    assert compiled("-DBT_ONE_THREAD").returncode == 0
    assert compiled("-DBT_LOCK()=take()", "-DBT_UNLOCK()=give()", "-Dtake()=", "-Dgive()=").returncode == 0


@pytest.mark.parametrize("path", COPIED, ids=lambda path: path.name)
def test_every_file_names_its_licence(path: Path) -> None:
    first, second = path.read_text(encoding="utf-8").splitlines()[:2]
    assert "SPDX-FileCopyrightText: 2026 The benchtool authors" in first
    assert "SPDX-License-Identifier: MIT" in second


@pytest.mark.parametrize("path", PUBLIC, ids=lambda path: path.name)
def test_every_header_that_declares_something_is_c_to_cxx(path: Path) -> None:
    assert ('extern "C" {' in path.read_text(encoding="utf-8")) == (path.name not in MACROS_ONLY)


def test_the_version_is_that_of_the_package() -> None:
    project = tomllib.loads((FOLDER.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    version = (FOLDER / "bt_version.h").read_text(encoding="utf-8")
    numbers = re.findall(r"#define BT_VERSION_(?:MAJOR|MINOR|PATCH) (\d+)", version)
    (text,) = re.findall(r'#define BT_VERSION_STRING "(.*)"', version)
    assert ".".join(numbers) == text == project["project"]["version"]
