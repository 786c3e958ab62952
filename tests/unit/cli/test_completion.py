"""Tab completion: what is proposed, that verbs are proposed without being loaded, and a real bash."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.cli import COMPLETING, app
from benchtool.cli.completion import SCRIPTS, Shell
from benchtool.cli.verbs import PLAIN, VERBS

BASH = shutil.which("bash")
PROGRAM = Path(sys.executable).with_name("benchtool")
_PROGRAM = "import sys; sys.argv = ['benchtool']; from benchtool.cli import main; main()"
_DRIVE = """
complete_line() {
    COMP_LINE="$1" COMP_POINT=${#1} COMPREPLY=()
    local words=($1)
    "$(complete -p benchtool | sed 's/.*-F \\([^ ]*\\).*/\\1/')" benchtool
    echo "$1|${COMPREPLY[*]}"
}
"""


def ask(line: str, **environment: str) -> list[str]:
    """Proposals for a line, in a process of its own as a shell asks for them."""
    asked = {
        COMPLETING: "complete_fish",
        "_TYPER_COMPLETE_FISH_ACTION": "get-args",
        "_TYPER_COMPLETE_ARGS": line,
    }
    told = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", _PROGRAM],
        env={**os.environ, **asked, **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    loaded = {each.rpartition("|")[2].strip() for each in told.stderr.splitlines()}
    assert not loaded & {"numpy", "can", "scipy", "benchtool.profile", "benchtool.cli.run"}
    return told.stdout.split("\n")[:-1]


def test_verbs_are_proposed_with_their_help_and_none_is_loaded() -> None:
    assert [each.partition("\t")[0] for each in ask("benchtool ")][: len(VERBS)] == [
        each.name for each in VERBS
    ]
    assert ask("benchtool rec")[0].startswith("record\tRecord the stream")
    assert ask("benchtool rec", **{PLAIN: "1"}) == ["record"]


@pytest.mark.skipif(BASH is None or not PROGRAM.exists(), reason="needs bash and an installed benchtool")
def test_a_bash_with_what_was_installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_DATA_HOME", raising=False)
    monkeypatch.setenv("PATH", f"{PROGRAM.parent}{os.pathsep}{os.environ['PATH']}")
    (tmp_path / ".bashrc").write_text("alias x=y", encoding="utf-8")
    for _ in range(2):
        assert CliRunner().invoke(app, ["completion", "install", "bash"]).exit_code == 0
    startup = (tmp_path / ".bashrc").read_text(encoding="utf-8").splitlines()
    assert startup == ["alias x=y", f"source '{tmp_path}/.local/share/benchtool/completion.bash'"]
    lines = {
        "benchtool para": "params",
        "benchtool run zhu2011/rip": "zhu2011/ripple",
        "benchtool run x --link emulated?wire=s": "serial",  # readline completes behind the =
        "benchtool run x --set operating_point.omega_m_r": "operating_point.omega_m_rad_s=",
    }
    script = "\n".join((f"source {tmp_path}/.bashrc", _DRIVE, *(f"complete_line '{line}'" for line in lines)))
    told = subprocess.run([str(BASH), "-c", script], capture_output=True, text=True, check=True)
    assert dict(each.split("|") for each in told.stdout.splitlines()) == lines, told.stderr


@pytest.mark.parametrize("shell", list(Shell))
def test_every_shell_has_a_script_that_asks(shell: Shell) -> None:
    shown = CliRunner().invoke(app, ["completion", "show", shell])
    assert shown.exit_code == 0
    assert shown.stdout == SCRIPTS[shell]
    assert COMPLETING in shown.stdout
    assert shown.stdout.count("(") == shown.stdout.count(")")


def test_a_fish_finds_its_script_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    assert CliRunner().invoke(app, ["completion", "install", "fish"]).exit_code == 0
    assert (tmp_path / "fish" / "completions" / "benchtool.fish").read_text(encoding="utf-8") == SCRIPTS[
        Shell.FISH
    ]


def test_a_shell_that_is_not_served_and_one_that_is_not_there(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHELL", "/bin/tcsh")
    answer = CliRunner().invoke(app, ["completion", "install"])
    assert answer.exit_code == 2
    assert "SHELL names 'tcsh': name one of bash, zsh, fish" in answer.stderr
    monkeypatch.setenv("PATH", "")
    answer = CliRunner().invoke(app, ["completion", "install", "pwsh"])
    assert answer.exit_code == 3
    assert "'benchtool completion show pwsh' prints it" in answer.stderr
