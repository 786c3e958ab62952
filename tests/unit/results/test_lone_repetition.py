"""One repetition of a case whose limits hold for all repetitions together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchtool.analysis import Measurement
from benchtool.block import Block
from benchtool.plan.limits import Limit, Verdict
from benchtool.plan.model import Plan
from benchtool.results.assessment import Assessment
from benchtool.results.judged_repetitions import LimitsTogether
from benchtool.results.repetitions import over_repetitions
from benchtool.results.run_result import RunResult

BLOCK = Block.from_arrays(1000.0, {"torque": "Nm"}, torque=np.zeros(4))


def _plan(judge: str) -> Plan:
    return Plan.model_validate(
        {
            "title": "test",
            "profile": "zhu2011",
            "repetitions": 3,
            "judge": judge,
            "limits": {"torque_mean": {"max": 1.0, "margin": "U"}, "capture_rows_missing": {"max": 0}},
            "operating_point": {"omega_m_rad_s": 10.0},
            "record": {"duration_s": 0.1, "channels": ("torque",)},
        }
    )


def _repetition(plan: Plan, *, missing: int = 0, torque: float = 0.5) -> Assessment:
    """As it is assessed: limits on its rows are its own."""
    rows = Measurement("capture_rows_missing", missing, "", "rows")
    mean = Measurement("torque_mean", torque, "Nm", "mean")
    own = {"capture_rows_missing": Limit(max=0.0)}
    return Assessment(
        *("case.1", Path("run/case.1"), (mean,), (rows,), own, {}, BLOCK, None, None),
        together=LimitsTogether.of(plan, "case"),
    )


@pytest.mark.parametrize("judge", ["mean", "worst"])
def test_one_repetition_does_not_claim_the_verdict_of_all(judge: str) -> None:
    plan = _plan(judge)
    alone = _repetition(plan)
    assert alone.verdict is Verdict.NONE
    assert alone.together is not None
    assert alone.together.of_one.startswith(
        f"torque_mean ≤ 1 Nm holds for the {judge} of 3 repetitions, of which this is one"
    )
    result = RunResult((alone,))
    assert result.verdict is Verdict.UNDECIDED
    document = result.to_json()
    assert (document["verdict"], document["cases"]["case.1"]["verdict"]) == ("undecided", "none")
    assert document["cases"]["case.1"]["limits_together"] == {
        "judge": judge,
        "repetitions": 3,
        "limits": {"torque_mean": {"max": 1.0, "margin": "U", "rule": "guard band U (95 %)"}},
    }


def test_what_one_repetition_misses_by_itself_all_miss() -> None:
    alone = _repetition(_plan("mean"), missing=3)
    assert alone.verdict is Verdict.FAIL
    assert RunResult((alone,)).verdict is Verdict.FAIL


@pytest.mark.parametrize(("torque", "verdict"), [(0.5, Verdict.PASS), (1.5, Verdict.FAIL)])
def test_together_they_have_it(torque: float, verdict: Verdict) -> None:
    plan = _plan("mean")
    measured = {
        f"case.{each}": (Measurement("torque_mean", torque + 0.001 * each, "Nm", "mean"),)
        for each in (1, 2, 3)
    }
    result = RunResult((_repetition(plan),) * 3, over_repetitions(plan, measured))
    assert result.unjudged == {}
    assert result.verdict is verdict


def test_where_each_is_judged_one_has_its_own_verdict() -> None:
    alone = _repetition(_plan("each"))
    assert alone.together is None
    assert RunResult((alone,)).verdict is Verdict.PASS
    assert "limits_together" not in alone.to_json()
