"""Limits on repetitions together in a report: the value that is judged, its requirement, its waiver."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.plan import Limit, Verdict, Waived
from benchtool.report.assembly.front import _judged_together, _not_run, requirements_section
from benchtool.report.assembly.plan import _over_repetitions
from benchtool.report.content import Cell, Grid, Section, Text
from benchtool.results import JudgedTogether, RecordedCase, RecordedRun, Repeated

LIMIT = Limit(max=1.0, requirement="SRS-12", margin="U")
WORST = Measurement("torque_mean", 1.2, "Nm", "worst of 3 repetitions", uncertainty=Uncertainty(0.05, ""))


def _run(limit: Limit) -> RecordedRun:
    run = RecordedRun("", Path(), ())
    judged = JudgedTogether("torque_mean", limit, WORST, 3.2e-5, judge="worst", count=3)
    run.__dict__["repeated"] = {"case": (Repeated("torque_mean", "Nm", 0.9, 0.1, 3, judged=judged),)}
    return run


def _texts(section: Section) -> list[list[str]]:
    (grid,) = (each for each in section.items if isinstance(each, Grid))
    return [[cell.text if isinstance(cell, Cell) else cell for cell in row] for row in grid.rows]


def test_the_value_that_is_judged_stands_beside_the_verdict() -> None:
    """The mean stood there, whatever was judged."""
    (row,) = _texts(_judged_together([_run(LIMIT)]))
    assert row[3] == "1.200 ± 0.098 Nm"
    assert row[6] == "fail"
    over, of_case = _over_repetitions(_run(LIMIT), ["torque_mean"])
    for section, cells in ((over, 1), (of_case, 0)):
        assert isinstance(section, Section)
        grid = section.items[0]
        assert isinstance(grid, Grid)
        assert [column.heading for column in grid.columns][cells:] == [
            *("measurement", "mean ± U (95 %)", "unit", "n"),
            *("worst ± U (95 %)", "limit", "decision rule", "P", "verdict"),
        ]
        assert [cell.text for cell in grid.rows[0]][cells:] == [
            *("torque_mean", "0.90 ± 0.43", "Nm", "3"),
            *("1.200 ± 0.098", "≤\N{NO-BREAK SPACE}1", "guard band U (95 %)", "< 0.001", "fail"),
        ]
    assert isinstance(over, Section)
    assert [each.text for each in over.items if isinstance(each, Text)] == [
        "P is the probability that all 3 repetitions conform, by the measurement alone."
    ]


@pytest.mark.parametrize(
    ("waived", "verdict", "evidence"),
    [
        (None, "fail", "case: torque_mean"),
        (Waived(reason="a prototype", by="ann"), "none", "case: torque_mean (waived)"),
    ],
)
def test_a_requirement_has_the_limits_on_repetitions_as_evidence(
    waived: Waived | None, verdict: str, evidence: str
) -> None:
    run = _run(LIMIT.model_copy(update={"waived": waived}))
    section = requirements_section([run])
    assert section is not None
    assert _texts(section) == [["SRS-12", verdict, evidence]]


def test_a_waived_limit_on_repetitions_is_told_as_such() -> None:
    run = _run(LIMIT.model_copy(update={"waived": Waived(reason="a prototype", by="ann")}))
    ((row),) = _texts(Section("", tuple(_not_run([run], []))))
    assert row[:4] == ["torque_mean", "case", "a prototype", "ann"]
    (judged,) = run.repeated["case"]
    assert judged.judged is not None
    assert judged.judged.missed is None
    assert judged.judged.waived is not None
    assert judged.judged.waived.verdict is Verdict.FAIL


def test_a_requirement_of_the_plan_has_the_limits_on_repetitions_as_evidence() -> None:
    """It had the verdicts of the single repetitions alone: a plan that failed fulfilled it."""
    details = {"plan": {"requirements": ["SRS-1"]}}
    bundle = SimpleNamespace(manifest=SimpleNamespace(details=details))
    case = SimpleNamespace(name="case.1", verdict=Verdict.NONE, bundle=bundle, assessment=None)
    run = RecordedRun("", Path(), (cast(RecordedCase, case),))
    run.__dict__["repeated"] = _run(LIMIT).repeated
    section = requirements_section([run])
    assert section is not None
    assert ["SRS-1", "fail", "case.1, case: torque_mean"] in _texts(section)
