"""When a commissioning has passed."""

from __future__ import annotations

import pytest

from benchtool.commission.known import Known
from benchtool.commission.results import Commissioning, StepResult, StepVerdict
from benchtool.commission.steps.step import Finding
from benchtool.profile import load_profile

P, F, S = StepVerdict.PASS, StepVerdict.FAIL, StepVerdict.SKIPPED


@pytest.mark.parametrize(
    ("verdicts", "passed"),
    [((P, P), True), ((P, S), True), ((P, F), False), ((P, F, S), False), ((S, S), False), ((), False)],
)
def test_what_a_shaft_or_a_drive_does_not_allow_is_no_failure(
    verdicts: tuple[StepVerdict, ...], *, passed: bool
) -> None:
    known = Known(load_profile("zhu2011").motor, 1e-4, 122.6)
    results = tuple(StepResult(f"step {k}", (), each) for k, each in enumerate(verdicts))
    assert Commissioning(results, known).passed is passed
    found = StepResult("found", (), P, findings=(Finding("this", "that", "do", fails=False),))
    assert not Commissioning((*results, found), known).passed
