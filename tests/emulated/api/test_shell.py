"""`benchtool shell`: the same objects in IPython, disabled on every way out."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import app

LINES = """
drive["u_s"]
drive.enable("velocity")
drive.omega_m_command = "150 rpm"
bench.wait(0.3)
drive.watch("omega_m", duration_s=0.2)
plot("torque", "i_q")
1 / 0
drive.state
print("completes:", get_ipython().complete('drive["u_')[1])
"""


def _shell(folder: Path, lines: str) -> subprocess.CompletedProcess[str]:
    """The shell with lines from a pipe; a process of its own, as IPython is one for each."""
    return subprocess.run(
        [sys.executable, "-m", "benchtool", "shell", "--virtual-time"],
        input=lines,
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, "IPYTHONDIR": str(folder / "ipython"), "NO_COLOR": "1", "TERM": "dumb"},
        check=False,
    )


def test_an_engineer_works_in_it_and_a_signal_ends_it_in_order(tmp_path: Path) -> None:
    ends = "import os, signal; os.kill(os.getpid(), signal.SIGTERM)\n"
    done = _shell(tmp_path, f"{LINES}{ends}print('still here')\n")
    assert done.returncode == 128 + signal.SIGTERM, done.stderr
    for said in ("Out[1]: 81.65", "operation enabled", "omega_m 15.", "ZeroDivisionError", "plot-1.png"):
        assert said in done.stdout
    assert "completes: " in done.stdout
    assert (
        'u_s"' in done.stdout.partition("completes: ")[2] or "u_s" in done.stdout.partition("completes: ")[2]
    )
    assert "still here" not in done.stdout
    assert done.stdout.count("Error") == 2, "only the division's, by its name and in the traceback"
    assert not [word for word in ("Error", "SystemExit", "To exit") if word in done.stderr]
    assert "SystemExit" not in done.stdout
    assert (tmp_path / "plot-1.png").read_bytes().startswith(b"\x89PNG")


def test_without_ipython_the_line_that_installs_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "IPython.terminal.interactiveshell", None)
    result = CliRunner().invoke(app, ["shell"])
    assert result.exit_code == 3
    assert "pip install 'benchtool[shell]'" in result.output
