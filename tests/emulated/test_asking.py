"""The question to the person at the bench, on a terminal: what was typed before is no answer to it."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

import pytest

from benchtool.bench.person import Confirmed, beforehand
from benchtool.cli.asking import prompt
from benchtool.cli.output import Output
from benchtool.errors import UsageError

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
        assert ask(WHAT) is Confirmed.BY_THE_PERSON
        assert select.select([sys.stdin], [], [], 0.0)[0] == [], "no other answer was left"
    assert f"The drive is disabled. Please {WHAT}; then press Enter" in capsys.readouterr().out


def test_a_terminal_that_goes_is_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    with _terminal(monkeypatch) as keyboard:
        ask = prompt(Answering(keyboard, b"\x04"), nullcontext, yes=False, alone=False)
        assert ask is not None
        with pytest.raises(UsageError, match="nobody can be asked"):
            ask(WHAT)


def test_who_is_asked(monkeypatch: pytest.MonkeyPatch) -> None:
    output = Output(as_json=False)
    with _terminal(monkeypatch):
        assert prompt(output, nullcontext, yes=False, alone=True) is None
        assert prompt(output, nullcontext, yes=True, alone=True) is beforehand
    monkeypatch.setattr(sys, "stdin", None)
    assert prompt(output, nullcontext, yes=False, alone=False) is None
