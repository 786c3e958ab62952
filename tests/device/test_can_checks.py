"""The CAN side's tests in C, with each compiler that is installed, plain and under its sanitizers."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.device.c_drive import make


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_tests_in_c_are_content(compiler: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed here")
    said = make(tmp_path, str(tmp_path / f"passed-canopen-{compiler}"))
    assert said.count("CAN side: all content") == 2
