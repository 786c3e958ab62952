"""What became of a commissioning: of each step, and of the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from types import MappingProxyType

from benchtool.analysis import Measurement
from benchtool.commission.known import Known
from benchtool.commission.steps.step import Finding
from benchtool.protocol.dictionary import Value


class StepVerdict(StrEnum):
    """What became of a step."""

    PASS = "pass"
    FAIL = "fail"
    SKIPPED = "skipped"


@dataclass(frozen=True)
class StepResult:
    """One step: its verdict with a reason, the parameters that it is for, what it estimated and found.

    `planned_J` is the energy that it was to take, with what was known before it, and `spent_J` that of its
    captures. `resumed`, it was done in an earlier session.
    """

    name: str
    sets: tuple[str, ...]
    verdict: StepVerdict
    reason: str = ""
    estimates: Mapping[str, Measurement] = field(default_factory=lambda: MappingProxyType({}))
    findings: tuple[Finding, ...] = ()
    planned_J: float = 0.0
    spent_J: float = 0.0
    resumed: bool = False


@dataclass(frozen=True)
class Commissioning:
    """What was run, in order.

    Attributes:
        results: of the steps.
        known: the nameplate it began with.
        parameters: what the drive is to hold by it, by the keys of a profile.
        saved: whether the drive has stored them.
        not_saved: why not.
    """

    results: tuple[StepResult, ...]
    known: Known
    parameters: Mapping[str, Value] = field(default_factory=lambda: MappingProxyType({}))
    saved: bool = False
    not_saved: str = ""

    @property
    def passed(self) -> bool:
        """Whether every step that this drive and this shaft allow passed, and nothing was found that is not
        as it should be."""
        verdicts = {each.verdict for each in self.results}
        nothing_wrong = not any(each.findings for each in self.results)
        return StepVerdict.PASS in verdicts and StepVerdict.FAIL not in verdicts and nothing_wrong

    @property
    def estimates(self) -> dict[str, Measurement]:
        """Every estimate by its name; of several of one name, that of the last step."""
        return {name: each for result in self.results for name, each in result.estimates.items()}
