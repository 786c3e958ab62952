"""One mutant at a time, put into a copy of the project and met by the tests that reach it."""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from tests.mutation.operators import Mutant, functions_of
from tests.mutation.reach import Reach
from tests.mutation.warm import run_pytest, warm_up

_LEFT_OUT = shutil.ignore_patterns(".*", "__pycache__", "build", "*.egg-info")
_COMPILED = "benchtool/emulator/control"
_BUDGETS_S = (8.0, 60.0)  # of the tests' own time: a quick look, then the rest
_BUDGET_PLAIN_S = 15.0
_BUDGET_LOOP_S = 40.0
_START_S = 40.0  # for imports and compilation
_PATIENCE = 4.0  # times the tests' own time, before they count as hanging
_FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", re.MULTILINE)


class Outcome(StrEnum):
    """Result of a mutant."""

    NOTICED = "noticed"
    TIMED_OUT = "timed out"
    SURVIVED = "survived"
    UNREACHED = "unreached"
    EQUIVALENT = "equivalent"


@dataclass(frozen=True)
class Result:
    """`by` is the test that noticed the mutant; `tests` is how many were to run."""

    mutant: Mutant
    outcome: Outcome
    by: str
    tests: int
    seconds: float


@dataclass(frozen=True)
class _Round:
    tests: Sequence[str]
    seconds: float
    plain: bool


def copied(project: Path, into: Path) -> Path:
    """A copy of the project's files in a new folder `tree`; nothing is ever changed in the project itself."""
    return shutil.copytree(project, into / "tree", ignore=_LEFT_OUT, symlinks=True)


class Trials:
    """Runs mutants in a copy of the project.

    Args:
        tree: the copy.
        compiled: which tests reach which lines.
        plain: the same with the compiler switched off; None if no compiled code is to be changed.
    """

    def __init__(self, tree: Path, compiled: Reach, plain: Reach | None) -> None:
        self._tree = tree
        self._compiled = compiled
        self._plain = plain
        self._stamp = time.time()
        self._slowness = 1.0
        warm_up()

    def meet(self, mutant: Mutant) -> Result:
        """Put the mutant in place, run tests until one notices it, and put the module back."""
        began = time.monotonic()
        place = self._tree / mutant.path
        original = place.read_text(encoding="utf-8")
        compiled_before = set(self._tree.rglob("*.nb[ic]"))
        outcome, by, count = Outcome.UNREACHED, "", 0
        try:
            for each in self._rounds(mutant, original):
                count += len(each.tests)
                outcome, by = self._run(each, place, (original, mutant.mutated))
                if outcome is not Outcome.SURVIVED:
                    break
        finally:
            self._write(place, original)
            if mutant.path.startswith(_COMPILED):  # what was compiled of it is of no further use
                for path in set(self._tree.rglob("*.nb[ic]")) - compiled_before:
                    path.unlink()
        return Result(mutant, outcome, by, count, time.monotonic() - began)

    def _rounds(self, mutant: Mutant, source: str) -> Iterator[_Round]:
        first = {name: line for name, line, _ in functions_of(source)}.get(mutant.function, 0)
        reaching = self._compiled.tests_of(mutant, first)
        if mutant.path.startswith(_COMPILED) and self._plain is not None:
            yield from self._within(self._plain.tests_of(mutant, first), self._plain, _BUDGET_PLAIN_S, True)
            loop = self._compiled.closed_loop
            rest = [*reaching, *(test for test in loop if test not in reaching)]
            yield from self._within(rest, self._compiled, _BUDGET_LOOP_S, False)
            return
        done = 0
        for budget_s in _BUDGETS_S:
            for each in self._within(reaching[done:], self._compiled, budget_s, False):
                done += len(each.tests)
                yield each

    @staticmethod
    def _within(tests: Sequence[str], reach: Reach, budget_s: float, plain: bool) -> Iterator[_Round]:
        """The first tests that fit into the budget, at least one if there is any."""
        taken: list[str] = []
        seconds = 0.0
        for test in tests:
            if taken and seconds + reach.seconds[test] > budget_s:
                break
            taken.append(test)
            seconds += reach.seconds[test]
        if taken:
            yield _Round(taken, seconds, plain)

    def _run(self, each: _Round, place: Path, texts: tuple[str, str]) -> tuple[Outcome, str]:
        """Meet a mutant with tests; `texts` are the module as it is and mutated.

        Tests that do not end in time get another chance with twice the time. If they do not end without the
        mutant either, it is the machine that is slow, and all get twice the time from then on.
        """
        original, mutated = texts
        patience = 1.0
        while True:
            self._write(place, mutated)
            code, text = self._tests(each, patience)
            if code is not None:
                break
            self._write(place, original)
            if self._tests(each, patience)[0] is None:
                self._slowness *= 2.0
            elif patience > 1.0:
                return Outcome.TIMED_OUT, ""
            else:
                patience = 2.0
        if code == 0:
            return Outcome.SURVIVED, ""
        found = _FAILED.search(text)
        return Outcome.NOTICED, found[1] if found else f"pytest ended with {code}"

    def _tests(self, each: _Round, patience: float) -> tuple[int | None, str]:
        limit_s = patience * self._slowness * (_START_S + _PATIENCE * each.seconds)
        arguments = ("-x", "-rfE", "--tb=no", "-p", "no:cacheprovider", *each.tests)
        return run_pytest(self._tree, arguments, limit_s, plain=each.plain)

    def _write(self, place: Path, text: str) -> None:
        """Write a module with a time of its own, or Python might take another version's bytecode for it."""
        place.write_text(text, encoding="utf-8")
        self._stamp += 2.0
        os.utime(place, (self._stamp, self._stamp))
