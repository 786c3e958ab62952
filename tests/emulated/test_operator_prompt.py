"""The prompt for the operator on a terminal: input typed before the question is discarded."""

from __future__ import annotations

import json
import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest
from typer.testing import CliRunner

from benchtool.bench.operator import Confirmation, confirmed_beforehand
from benchtool.cli import app
from benchtool.cli.operator_prompt import prompt
from benchtool.cli.output import Output
from benchtool.errors import UsageError
from benchtool.recording import Bundle
from benchtool.shipped import shipped

pty = pytest.importorskip("pty")
WHAT = "load the shaft with 0.65 Nm against positive rotation"


@contextmanager
def _terminal(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A terminal as standard input; the descriptor that types into it."""
    keyboard, terminal = pty.openpty()
    with os.fdopen(terminal, "r", encoding="utf-8") as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        yield keyboard
    os.close(keyboard)


class Answering(Output):
    """Types an answer as soon as the question is shown."""

    def __init__(self, keyboard: int, answer: bytes) -> None:
        super().__init__(as_json=False)
        self._keyboard, self._answer = keyboard, answer

    def line(self, text: str, style: str = "") -> None:
        super().line(text, style)
        os.write(self._keyboard, self._answer)


def test_what_was_typed_before_the_question_is_no_answer(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with _terminal(monkeypatch) as keyboard:
        os.write(keyboard, b"\n\n")
        ask = prompt(Answering(keyboard, b"\n"), nullcontext, yes=False, alone=False)
        assert ask is not None
        assert ask(WHAT) is Confirmation.BY_OPERATOR
        assert select.select([sys.stdin], [], [], 0.0)[0] == [], "no other answer was left"
    assert f"The drive is disabled. Please {WHAT}; then press Enter" in capsys.readouterr().out


def test_the_end_of_input_is_no_confirmation(monkeypatch: pytest.MonkeyPatch) -> None:
    with _terminal(monkeypatch) as keyboard:
        ask = prompt(Answering(keyboard, b"\x04"), nullcontext, yes=False, alone=False)
        assert ask is not None
        with pytest.raises(UsageError, match="there is no prompt"):
            ask(WHAT)


def test_who_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    output = Output(as_json=False)
    with _terminal(monkeypatch):
        assert prompt(output, nullcontext, yes=False, alone=True) is None
        assert prompt(output, nullcontext, yes=True, alone=True) is confirmed_beforehand
    monkeypatch.setattr(sys, "stdin", None)
    assert prompt(output, nullcontext, yes=False, alone=False) is None


def test_a_program_is_asked_nothing(tmp_path: Path) -> None:
    text = (shipped("profiles") / "zhu2011" / "profile.toml").read_text(encoding="utf-8")
    profile, plan = tmp_path / "mine.toml", tmp_path / "plan.toml"
    profile.write_text(f'{text}\n[bench.load]\nkind = "person"\n', encoding="utf-8")
    plan.write_text(
        f'title = "t"\nprofile = {json.dumps(str(profile))}\n'
        "[operating_point]\nomega_m_rad_s = 31.42\nload_torque_Nm = 0.65\nsettle_s = 0.2\n"
        '[record]\nduration_s = 0.05\nchannels = ["torque", "omega_m", "u_dc"]\n[analyses]\nsteady = false\n',
        encoding="utf-8",
    )
    run = ("run", str(plan), "--out", str(tmp_path / "out"))
    for options in (("--json",), ()):  # the second on no terminal
        result = CliRunner().invoke(app, (*run, *options))
        assert result.exit_code == 2, result.output
        assert "give --yes once that is done; the drive was not enabled" in result.stderr
        assert result.stdout == ""
        assert not (tmp_path / "out").exists()
    result = CliRunner().invoke(app, (*run, "--json", "--yes"))
    assert result.exit_code == 1, "the load was not there"
    by_hand = Bundle.open(tmp_path / "out").manifest.details["equipment"]["by_hand"]
    assert by_hand["confirmed"] == "taken as done beforehand"
