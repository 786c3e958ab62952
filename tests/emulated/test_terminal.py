"""Terminals, pipes and disks: text is escaped, every refusal is one line and an exit code."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import typer
from rich.text import Text
from typer.testing import CliRunner

from benchtool.cli import app, options
from benchtool.cli.exit_codes import print_error, with_exit_code
from benchtool.cli.output import Output
from benchtool.cli.progress import RunProgress
from benchtool.recording import BundleWriter, Manifest, verify
from benchtool.run.folder import bundle_folder

HOSTILE = ("[rpm]", "[/rev]", "[bold]x", "[link=file:///etc]", ":warning:", "\x1b[2Jx", "{task}", "$\\frac{$")


@pytest.mark.parametrize("text", HOSTILE)
def test_text_is_shown_as_it_is(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    output = Output(as_json=False)
    output.note(text)
    output.line(text)
    output.table(text, ("name", f">{text}"), [(text, Text("1"))])
    with RunProgress(output) as progress:
        progress.begin(text, 1, 2)
        progress.note(text)
    print_error(text, OSError())
    out, err = capsys.readouterr()
    shown = text.replace("\x1b", "\\x1b")
    assert out.count(shown) == 4
    assert err.count(shown) == 4  # the note, case and step of the progress, the error
    assert "\x1b" not in out + err


@pytest.fixture(scope="module")
def bundle(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("terminal")
    plan = folder / "[rev].toml"
    plan.write_text(
        'title = "[/rev] [bold] $x$ $\\\\frac{$"\nprofile = "zhu2011"\nfigure = "steady"\n'
        "[operating_point]\nomega_m_rad_s = 31.42\nload_torque_Nm = 0.3\nsettle_s = 0.4\n"
        '[[variants]]\nname = "[/rev]"\n[[variants]]\nname = "[rpm]"\n'
        '[record]\nduration_s = 0.12\nchannels = ["i_a", "torque", "psi_s", "theta_m"]\n',
        encoding="utf-8",
    )
    result = CliRunner().invoke(app, ("run", str(plan), "--out", str(folder / "run")))
    assert result.exit_code == 0, result.output
    for name in ("[/rev]", "[rpm]", "$\\frac{$"):
        assert name in result.stdout + result.stderr
    assert not verify(folder / "run").damaged
    assert not verify(folder / "run").unlisted
    return folder / "run"


@pytest.mark.usefixtures("blank_pictures")
def test_a_report_of_names_with_brackets(bundle: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ("report", str(bundle), "--out", str(tmp_path / "a.html")))
    assert result.exit_code == 0, result.output
    page = (tmp_path / "a.html").read_text(encoding="utf-8")
    assert page.count("emulated") >= 2  # the link of each case


def test_a_report_takes_the_place_of_a_report_only(bundle: Path, tmp_path: Path) -> None:
    mine = tmp_path / "mine.html"
    mine.write_text("mine", encoding="utf-8")
    for arguments in (("report", bundle, "--out", mine), ("compare", bundle, "--html", mine)):
        result = CliRunner().invoke(app, [str(each) for each in arguments])
        assert result.exit_code == 3, result.output
        assert "was not written by this command" in result.stderr
    assert mine.read_text(encoding="utf-8") == "mine"


def _run(*arguments: object, shell: str, folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "benchtool", *(str(each) for each in arguments)]
    return subprocess.run(
        ["bash", "-c", f'"$@" {shell}', "bash", *command],
        cwd=folder,
        # as a shell has it: unbuffered streams would have nothing left to fail at the end
        env={name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(
    ("verb", "shell", "code", "said"),
    [
        ("profiles", ">/dev/full", 3, "cannot use standard output: No space left on device"),
        ("profiles", "| true; exit ${PIPESTATUS[0]}", 3, "cannot use standard output: Broken pipe"),
        ("profiles", ">&-", 0, ""),
        ("report run", "2>/dev/full", 0, ""),  # tells its progress
    ],
)
def test_streams_that_take_nothing(tmp_path: Path, verb: str, shell: str, code: int, said: str) -> None:
    with BundleWriter(tmp_path / "run", Manifest(what="x", when="2026-01-01T00:00:00+00:00")) as writer:
        writer.finish()
    done = _run(*verb.split(), "--json", shell=shell, folder=tmp_path)
    assert done.returncode == code, done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    assert said in done.stderr


@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EACCES, errno.EIO])
def test_what_the_system_refuses_is_a_line(number: int, capsys: pytest.CaptureFixture[str]) -> None:
    def verb() -> int:
        raise OSError(number, "refused", "place")

    def defect() -> int:
        raise ZeroDivisionError

    with pytest.raises(typer.Exit) as end:
        with_exit_code(verb)()
    assert end.value.exit_code == 3
    assert capsys.readouterr().err.startswith("benchtool: cannot use 'place': refused; ")
    with pytest.raises(ZeroDivisionError):
        with_exit_code(defect)()


def _nested() -> Iterator[str]:
    yield "a = " + "[" * 3000 + "]" * 3000
    yield "a = " + "{b = " * 3000 + "1" + "}" * 3000
    yield ".".join(["a"] * 3000) + " = 1"
    yield "[setup]\n" + ".".join(["a"] * 3000) + " = 1"
    yield f"[{'.'.join(['a'] * 3000)}]"


@pytest.mark.parametrize("text", list(_nested()), ids=["lists", "tables", "key", "value", "head"])
def test_a_document_that_is_nested_deep_is_a_line(text: str, tmp_path: Path) -> None:
    (tmp_path / "deep.toml").write_text(text, encoding="utf-8")
    for verb in (("run",), ("info", "--profile"), ("params", "diff")):
        result = CliRunner().invoke(app, [*verb, str(tmp_path / "deep.toml")])
        assert result.exit_code == 2, result.output
        lines = result.stderr.strip().splitlines()
        assert lines
        for line in lines:
            assert "deep.toml" in line
            assert len(line) < 1000


def test_two_runs_in_one_second_have_folders_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    when = options.wall_time()
    with (
        bundle_folder(None, when, "a/b") as one,
        bundle_folder(None, when, "a/b") as two,
        bundle_folder(None, when, "a/b") as three,
    ):
        assert len({one, two, three}) == 3
        (two / "kept").touch()
    assert list(Path("runs").iterdir()) == [two]
    with bundle_folder(tmp_path / "mine", when, "a") as mine:
        assert mine == tmp_path / "mine"
    assert not mine.exists()
