"""The program of the porting page builds, and `benchtool info` answers."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app
from tests.device.c_drive import FOLDER

PAGE = (FOLDER.parents[1] / "docs" / "how_to" / "port_firmware.md").read_text(encoding="utf-8")
OTHERS = ("bt_canopen",)


def test_the_program_of_the_page_answers(tmp_path: Path) -> None:
    compiler = shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("the C library needs gcc or clang, not installed here")
    (program,) = re.findall(r"```c\n(.*?)```", PAGE, flags=re.DOTALL)
    (tmp_path / "main.c").write_text(program)
    sources = [path for path in FOLDER.glob("*.c") if not path.name.startswith(OTHERS)]
    (named,) = re.findall(r"`gcc (.*?) -Ibt", PAGE)
    flags = [*named.split(), "-Wall", "-Wextra", "-Werror", f"-I{FOLDER}", f"-I{FOLDER.parent}"]
    drive = tmp_path / "drive"
    subprocess.run([compiler, *flags, tmp_path / "main.c", *sources, "-o", drive], check=True, timeout=120)
    with subprocess.Popen([drive], stdout=subprocess.PIPE, text=True) as child:
        try:
            assert child.stdout is not None
            link = f"serial:{child.stdout.readline().strip()}"
            result = CliRunner().invoke(app, ("info", "--link", link, "--json"))
        finally:
            child.kill()
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["state"] == "switch on disabled"


def test_the_page_counts_the_entries_of_the_dictionary() -> None:
    """It said 279 where `info` lists 287."""
    (stated,) = re.findall(r"table of (\d+) entries", PAGE)
    header = (FOLDER.parent / "drive_objects.h").read_text(encoding="utf-8")
    table = header[header.index("#define BT_ENTRIES(X)") :].split("\n\n", 1)[0]
    assert int(stated) == len(re.findall(r"^ +X\(", table, flags=re.MULTILINE))
