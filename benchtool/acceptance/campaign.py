"""The suite tried: on mutants, which it should fail, and on sound drives, which it should pass."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Final

from benchtool.acceptance.scores import suite_hash
from benchtool.acceptance.session import run_suite
from benchtool.errors import UsageError
from benchtool.profile import load_profile
from benchtool.results import Outcome, SuiteScore

LINK: Final = "emulated?wire=serial"
_INTERRUPTED: Final = 2  # exit code of pytest
"""Of trials: the wire that takes least time."""


@dataclass(frozen=True)
class Trial:
    """One run of the suite.

    `mutant` is the name of one, empty of a sound drive; `found` are the tests that did not pass, with their
    reasons. A trial of a mutant ends with the first.
    """

    profile: str
    mutant: str
    seed: int
    found: tuple[tuple[str, str], ...] = ()
    ran: int = 0

    @property
    def failed(self) -> bool:
        """Whether a test failed; so did a trial in which none ran."""
        return bool(self.found) or self.ran == 0


@dataclass(frozen=True)
class Campaign:
    """All trials: those of mutants, and those of sound drives."""

    trials: tuple[Trial, ...]

    @property
    def mutants(self) -> tuple[Trial, ...]:
        """Trials of mutants."""
        return tuple(each for each in self.trials if each.mutant)

    @property
    def missed(self) -> tuple[Trial, ...]:
        """Mutants that passed."""
        return tuple(each for each in self.mutants if not each.failed)

    @property
    def clean(self) -> tuple[Trial, ...]:
        """Trials of sound drives."""
        return tuple(each for each in self.trials if not each.mutant)

    @property
    def false_failures(self) -> tuple[Trial, ...]:
        """Sound drives that failed."""
        return tuple(each for each in self.clean if each.failed)

    def score(self, when: str) -> SuiteScore:
        """Return the score, measured at an ISO 8601 time."""
        return SuiteScore(
            caught=len(self.mutants) - len(self.missed),
            mutants=len(self.mutants),
            missed=tuple(f"{each.mutant} ({each.profile})" for each in self.missed),
            clean_runs=len(self.clean),
            false_failures=len(self.false_failures),
            when=when,
            profiles=tuple(dict.fromkeys(each.profile for each in self.trials)),
            of=suite_hash(),
        )


def conduct_campaign(
    profiles: Sequence[str],
    *,
    clean: int,
    jobs: int,
    tell: Callable[[Trial, int, int], None],
    chosen: Sequence[str] = (),
    seed: int = 0,
) -> Campaign:
    """Run the suite on every mutant with the first profile, and on `clean` sound drives of all profiles in
    turn, each with a seed of its own.

    Args:
        profiles: with an emulated bench.
        clean: runs of sound drives.
        jobs: processes.
        tell: takes each trial that is done, how many are, and of how many.
        chosen: names of mutants; all without any.
        seed: of the first trial.

    Raises:
        UsageError: there is no such mutant.
    """
    from benchtool.emulator.mutants import MUTANTS

    names = [each.name for each in MUTANTS]
    if unknown := [each for each in chosen if each not in names]:
        raise UsageError(f"no mutant {', '.join(unknown)}: the mutants are {', '.join(names)}")
    todo = [Trial(profiles[0], name, seed) for name in chosen or names]
    todo += [Trial(profiles[number % len(profiles)], "", seed + number) for number in range(clean)]
    done: list[Trial] = []
    if jobs == 1:
        for each in todo:
            done.append(run_trial(each))
            tell(done[-1], len(done), len(todo))
        return Campaign(tuple(done))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(max_workers=jobs, mp_context=context) as pool:
        try:
            for ended in as_completed([pool.submit(run_trial, each) for each in todo]):
                done.append(ended.result())
                tell(done[-1], len(done), len(todo))
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)  # what waits is not tried any more
            raise
    order = {(each.mutant, each.profile, each.seed): place for place, each in enumerate(todo)}
    return Campaign(tuple(sorted(done, key=lambda each: order[each.mutant, each.profile, each.seed])))


def run_trial(trial: Trial, only: str = "") -> Trial:
    """Run the suite once, and return the trial with what was found.

    Args:
        trial: what to run.
        only: expression of pytest's `-k` that chooses tests.

    Raises:
        KeyboardInterrupt: it was interrupted, of which pytest makes an exit code.
    """
    from benchtool.emulator.mutants import MUTANTS

    mutant = next((each for each in MUTANTS if each.name == trial.mutant), None)
    altered = {} if mutant is None else mutant.alter(load_profile(trial.profile))
    words = ["--bench", trial.profile, "--link", LINK, "--bench-bare", "--bench-seed", str(trial.seed)]
    words += [word for key, value in altered.items() for word in ("--bench-alter", f"{key}={value!r}")]
    words += ["-x"] if mutant is not None else []
    words += ["-k", only] if only else []
    with nullcontext() if mutant is None else mutant.applied():
        code, record = run_suite(words, quiet=True)
    if code == _INTERRUPTED:  # by hand: what was not tried has found nothing
        raise KeyboardInterrupt
    tests = () if record is None else record.tests
    bad = tuple((each.name, each.reason) for each in tests if each.outcome in (Outcome.FAILED, Outcome.ERROR))
    ran = sum(each.outcome is not Outcome.NOT_RUN for each in tests)
    return Trial(trial.profile, trial.mutant, trial.seed, bad, ran)
