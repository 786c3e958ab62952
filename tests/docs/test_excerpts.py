"""What pages quote of files is what the commands beside it write."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app

PAGE = Path(__file__).resolve().parents[2] / "docs" / "start" / "own_motor.md"


def test_the_motor_of_the_page_is_the_one_that_profile_new_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = PAGE.read_text(encoding="utf-8")
    (command,) = re.findall(r"^benchtool (profile new .*?)\n```", page, flags=re.DOTALL | re.MULTILINE)
    (quoted,) = re.findall(r"```toml\n(\[motor\].*?)```", page, flags=re.DOTALL)
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, shlex.split(command.replace("\\\n", " ")))
    assert result.exit_code == 0, result.output
    assert quoted in (tmp_path / "gimbal.toml").read_text(encoding="utf-8")
