"""Asking the person at the bench, who presses Enter when something is done."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress

from benchtool.bench.person import Confirmed, Prompt, beforehand, unasked
from benchtool.cli.output import Output


def prompt(
    output: Output, aside: Callable[[], AbstractContextManager[None]], *, yes: bool, alone: bool
) -> Prompt | None:
    """What asks the person at this terminal; None where there is no person to ask.

    Args:
        output: of the command.
        aside: clears the terminal during the question.
        yes: take everything as done.
        alone: the command runs for a program, or in several processes.
    """

    if yes:
        return beforehand
    if alone or sys.stdin is None or not sys.stdin.isatty():
        return None

    def ask(what: str) -> Confirmed:
        with aside():
            return _ask(what, output)

    return ask


def _ask(what: str, output: Output) -> Confirmed:

    _forget_input()
    output.line(f"The drive is disabled. Please {what}; then press Enter (Ctrl-C ends the run).", "bold")
    if not sys.stdin.readline():  # the terminal has gone
        raise unasked(what)
    return Confirmed.BY_THE_PERSON


def _forget_input() -> None:
    """Drop what was typed before the question: it is no answer."""
    with suppress(ImportError, OSError):  # not every system has terminals of this kind
        import termios

        termios.tcflush(sys.stdin, termios.TCIFLUSH)
