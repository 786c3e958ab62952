"""Asking the person at the bench, who presses Enter when something is done."""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import AbstractContextManager
from enum import Enum, auto
from typing import TYPE_CHECKING

from benchtool.cli.output import Output

if TYPE_CHECKING:
    from benchtool.bench.person import Confirmed, Prompt
    from benchtool.plan.model import Plan


class Way(Enum):
    """How a person can be asked: on the terminal, not at all, or not needed as all is taken as done."""

    TERMINAL = auto()
    NOBODY = auto()
    BEFOREHAND = auto()


def way(*, yes: bool, alone: bool) -> Way:
    """How a person can be asked by a command with `--yes`, or `alone`, on the terminal that it has."""
    if yes:
        return Way.BEFOREHAND
    return Way.NOBODY if alone or sys.stdin is None or not sys.stdin.isatty() else Way.TERMINAL


def prompt(by: Way, output: Output, aside: Callable[[], AbstractContextManager[None]]) -> Prompt:
    """What asks the person; `aside` clears the terminal meanwhile."""
    from benchtool.bench.person import beforehand, nobody

    def ask(what: str) -> Confirmed:
        with aside():
            return _ask(what, output)

    return {Way.TERMINAL: ask, Way.NOBODY: nobody, Way.BEFOREHAND: beforehand}[by]


def require_somebody(plan: Plan, by: Way) -> None:
    """Refuse a plan that needs a person where nobody can be asked, before anything is opened.

    Raises:
        UsageError: it does.
    """
    from benchtool.bench.person import instruction, nobody
    from benchtool.plan.cases import cases

    if by is not Way.NOBODY:
        return
    for case in cases(plan):
        if what := instruction(case.operating_point):
            nobody(what)


def _ask(what: str, output: Output) -> Confirmed:
    from benchtool.bench.person import Confirmed, nobody

    output.line(f"The drive is disabled. Please {what}; then press Enter (Ctrl-C ends the run).", "bold")
    if not sys.stdin.readline():  # the terminal has gone
        return nobody(what)
    return Confirmed.BY_THE_PERSON
