"""The JSON documents of `acceptance`."""

from __future__ import annotations

from typing import Literal

from docs.generate.json_results import Document, VerdictWord

OutcomeWord = Literal["passed", "waived", "not run", "failed", "error"]


class HeldLimit(Document):
    """A value that a test held against a limit."""

    value: float | None
    """The value; `null` where it was not measured, which fails."""
    below: float | None = None
    """What an amplitude without a value is less than, by which it is judged."""
    unit: str
    """Unit of value and bounds."""
    min: float | None = None
    """Least value allowed."""
    max: float | None = None
    """Greatest value allowed."""
    margin: float | str
    """Margin of the decision rule."""
    rule: str
    """The decision rule in words."""
    verdict: VerdictWord
    """Verdict."""
    conformance: float | None = None
    """Probability that the true value lies within the bounds."""
    conformance_reason: str | None = None
    """Why there is no such probability: value or uncertainty are not known."""


class AcceptanceTest(Document):
    """One test of a session."""

    outcome: OutcomeWord
    """How it ended."""
    reason: str
    """Why it did not pass, or was not run."""
    limits: dict[str, HeldLimit]
    """Values with their limits, by name."""


class Accepted(Document):
    """`acceptance`."""

    verdict: VerdictWord
    """The worst of all tests; those waived or not run do not count."""
    profile: str
    """Profile."""
    link: str
    """Address of the drive."""
    counts: dict[OutcomeWord, int]
    """Number of tests by outcome."""
    requirements: dict[str, OutcomeWord]
    """Worst outcome of the tests of each requirement."""
    tests: dict[str, AcceptanceTest]
    """Tests by name."""


class Score(Document):
    """How well a suite finds faults."""

    caught: int
    """Mutants that were found."""
    mutants: int
    """Mutants that were tried."""
    missed: list[str]
    """Those that were not found, with the profile."""
    clean_runs: int
    """Runs of sound drives."""
    false_failures: int
    """Sound drives that failed."""
    when: str
    """Time of the trial (ISO 8601)."""
    profiles: list[str]
    """Profiles that it was tried with."""
    of: str
    """Hash of the suite."""


class TriedMutant(Document):
    """One mutant."""

    found: bool
    """Whether a test failed."""
    by: list[str]
    """Tests that failed."""


class TriedSuite(Document):
    """`acceptance --mutants`."""

    verdict: Literal["pass", "fail"]
    """Whether 95 % of the mutants were found and no sound drive failed."""
    score: Score
    """The score."""
    mutants: dict[str, TriedMutant]
    """Mutants by name."""
    false_failures: dict[str, dict[str, str]]
    """Of sound drives that failed, by seed: tests and reasons."""
