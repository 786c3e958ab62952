"""Prompt for the operator at the bench, who confirms an action with Enter."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress

from benchtool.bench import Confirmation, Prompt, confirmed_beforehand, no_operator
from benchtool.cli.output import Output


def prompt(
    output: Output, aside: Callable[[], AbstractContextManager[None]], *, yes: bool, alone: bool
) -> Prompt | None:
    """Return the prompt of this terminal; None where there is no operator to ask.

    Args:
        output: of the command.
        aside: clears the terminal during the question.
        yes: confirm everything.
        alone: the command runs for a program, or in several processes.
    """

    if yes:
        return confirmed_beforehand
    if alone or sys.stdin is None or not sys.stdin.isatty():
        return None

    def ask(what: str) -> Confirmation:
        with aside():
            return _ask(what, output)

    return ask


def _ask(what: str, output: Output) -> Confirmation:

    _discard_input()
    output.line(f"The drive is disabled. Please {what}; then press Enter (Ctrl-C ends the run).", "bold")
    if not sys.stdin.readline():  # the terminal has gone
        raise no_operator(what)
    return Confirmation.BY_OPERATOR


def _discard_input() -> None:
    """Discard input that was typed before the question."""
    with suppress(ImportError, OSError):  # not every system has terminals of this kind
        import termios

        termios.tcflush(sys.stdin, termios.TCIFLUSH)
