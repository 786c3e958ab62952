"""Verdicts and probabilities of conformance against Monte-Carlo trials (JCGM 106:2012; JCGM 101:2008)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Contribution, Measurement, Uncertainty, combined
from benchtool.analysis.statistics.scatter import error_of_series
from benchtool.plan.cases import cases
from benchtool.plan.limits import Limit, Verdict
from benchtool.plan.model import Plan
from benchtool.results.repetitions import over_repetitions

TRIALS = 200_000
BOUNDS = [(None, 1.0), (-1.0, None), (-1.0, 1.0), (0.3, 0.4)]
Floats = NDArray[np.float64]


def draws(uncertainty: Uncertainty, value: float, seed: int = 5) -> Floats:
    """True values by the distributions of the budget, each drawn by itself: Student's for few values."""
    random = np.random.default_rng(seed)
    true = np.full(TRIALS, value)
    for line in uncertainty.budget:
        if math.isfinite(line.dof):
            true += line.experimental * random.standard_t(line.dof, TRIALS)
        else:
            true += line.standard * random.standard_normal(TRIALS)
    return true


@pytest.mark.parametrize("value", [-1.3, 0.35, 0.8, 1.0, 1.2])
@pytest.mark.parametrize(("least", "greatest"), BOUNDS)
@pytest.mark.parametrize("of_student", [True, False])
def test_the_probability_of_conformance_is_that_of_trials(
    least: float | None, greatest: float | None, value: float, of_student: bool
) -> None:
    for budget in (
        [Contribution("a", "A", 0.2, 4.0, of_student=of_student)],
        [Contribution("a", "A", 0.2, 6.0, of_student=of_student), Contribution("b", "B", 0.15)],
    ):
        uncertainty = combined(budget, "")
        assert uncertainty is not None
        true = draws(uncertainty, value)
        share = np.mean(
            (true >= (-math.inf if least is None else least))
            & (true <= (math.inf if greatest is None else greatest))
        )
        stated = Limit(min=least, max=greatest).conformance(value, uncertainty)
        # of several lines Welch and Satterthwaite's Student distribution is close, not exact
        assert stated == pytest.approx(share, abs=0.004 if len(budget) == 1 else 0.015)


def test_of_machines_at_a_limit_means_of_few_values_pass_one_in_forty() -> None:
    """What the analyses state of five values, against the guard band on either side."""
    random, runs = np.random.default_rng(2), 6000
    limit, verdicts = Limit(max=1.0, margin="U"), []
    for values in 1.0 + 0.1 * random.standard_normal((runs, 5)):
        stated = combined([error_of_series(values).line("scatter")], "")
        verdicts.append(limit.judge(float(np.mean(values)), stated))
    assert 0.015 < verdicts.count(Verdict.PASS) / runs < 0.035
    assert 0.015 < verdicts.count(Verdict.FAIL) / runs < 0.035


@pytest.mark.parametrize(("least", "greatest"), BOUNDS)
@pytest.mark.parametrize("margin", [0.0, 0.04, "U"])
def test_verdicts_by_the_rule_written_out(
    least: float | None, greatest: float | None, margin: float | str
) -> None:
    limit = Limit.model_validate({"min": least, "max": greatest, "margin": margin})
    random = np.random.default_rng(3)
    for value, U in zip(
        random.uniform(-2, 2, 500).tolist(), random.uniform(0, 0.3, 500).tolist(), strict=True
    ):
        low, high = -math.inf if least is None else least, math.inf if greatest is None else greatest
        inside = low <= value <= high
        if margin == "U":
            surely = value - low >= U and high - value >= U
            never = value < low - U or value > high + U
            expected = Verdict.PASS if surely else Verdict.FAIL if never else Verdict.UNDECIDED
        else:
            room = float(margin)
            near = value - low < room or high - value < room
            expected = Verdict.FAIL if not inside else Verdict.MARGINAL if near else Verdict.PASS
        assert limit.judge(value, Uncertainty(U / 2.0, "", half_width=U)) is expected


def repeated(judge: str, limit: Limit, values: Floats, standard: float | None) -> Verdict:
    """The verdict over repetitions of one case whose torque_mean has these values."""
    plan = Plan.model_validate(
        {
            "title": "test",
            "profile": "zhu2011",
            "repetitions": len(values),
            "judge": judge,
            "limits": {"torque_mean": limit.model_dump(exclude_none=True)},
            "operating_point": {"omega_m_rad_s": 10.0},
            "record": {"duration_s": 0.1, "channels": ("torque",)},
        }
    )
    uncertainty = None if standard is None else Uncertainty(standard, "")
    measured = {
        case.name: (Measurement("torque_mean", value, "Nm", "", uncertainty=uncertainty),)
        for case, value in zip(cases(plan), values.tolist(), strict=True)
    }
    ((found,),) = over_repetitions(plan, measured).values()
    assert found.judged is not None
    return found.judged.verdict


def test_means_of_repetitions_at_a_limit_pass_one_time_in_forty() -> None:
    random, runs, limit = np.random.default_rng(8), 1500, Limit(max=1.0, margin="U")
    verdicts = [repeated("mean", limit, 1.0 + 0.1 * random.standard_normal(4), None) for _ in range(runs)]
    assert 0.01 < verdicts.count(Verdict.PASS) / runs < 0.045
    assert 0.01 < verdicts.count(Verdict.FAIL) / runs < 0.045


@pytest.mark.parametrize("margin", [0.0, 0.05, "U"])
def test_the_worst_of_repetitions_has_the_verdict_of_the_worst_one(margin: float | str) -> None:
    random, order = np.random.default_rng(8), list(Verdict)
    limit = Limit.model_validate({"min": 0.6, "max": 1.0, "margin": margin})
    for values in 0.8 + 0.15 * random.standard_normal((60, 3)):
        alone = [limit.judge(value, Uncertainty(0.03, "")) for value in values.tolist()]
        assert repeated("worst", limit, values, 0.03) is max(alone, key=order.index)


@pytest.mark.parametrize("judge", ["mean", "worst"])
def test_a_repetition_without_a_value_fails(judge: str) -> None:
    assert repeated(judge, Limit(max=1.0), np.array([0.1, math.nan, 0.1]), 0.1) is Verdict.FAIL
    assert repeated(judge, Limit(max=1.0), np.array([0.1, 0.2, 0.1]), None) is Verdict.PASS
    unknown = repeated(judge, Limit(max=1.0, margin="U"), np.array([0.1, 0.1001, 0.1]), None)
    assert unknown is (Verdict.PASS if judge == "mean" else Verdict.FAIL), "the mean has its own scatter"
