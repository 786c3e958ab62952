"""A line that does not stand out of the noise is less than a bound: over repetitions, between runs, in tables
of both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from benchtool.acceptance.measuring import held
from benchtool.analysis import Measurement, Uncertainty
from benchtool.api.comparison import Comparison as ComparisonOfApi
from benchtool.block import Block, Channel
from benchtool.cli.compare import show
from benchtool.cli.output import Output
from benchtool.cli.results import show_repeated
from benchtool.plan import Limit, Verdict, cases
from benchtool.plan.model import Plan
from benchtool.report.assembly.front import _judged_together
from benchtool.report.content import Grid
from benchtool.results import Assessment, RecordedCase, RecordedRun, Repeated, over_repetitions
from benchtool.results.comparison import Comparison
from benchtool.results.delta import Delta, deltas

BLOCK = Block((Channel("torque", "Nm"),), 0, 1, 1e-4, np.zeros((1, 1)))
NAME, REASON = "torque_line_amplitude", "no line stands out of the noise"


def _hidden(below: float | None) -> Measurement:
    return replace(Measurement.undefined(NAME, "Nm", "the largest line", REASON), below=below)


def _line(value: float, U: float | None = 0.2) -> Measurement:
    uncertainty = None if U is None else Uncertainty(U / 2.0, "noise", half_width=U)
    return Measurement(NAME, value, "Nm", "the largest line", uncertainty=uncertainty)


def _result(*measurements: Measurement, case: str = "tpc", limit: Limit | None = None) -> Assessment:
    limits = {} if limit is None else {NAME: limit}
    return Assessment(case, Path("bundle"), measurements, (), limits, {}, BLOCK, None, None)


def _over(*found: Measurement) -> Repeated:
    plan = Plan.model_validate(
        {
            "title": "test",
            "profile": "zhu2011",
            "repetitions": len(found),
            "operating_point": {"omega_m_rad_s": 10.0},
            "record": {"duration_s": 0.1, "channels": ("torque",)},
        }
    )
    names = [case.name for case in cases(plan)]
    ((together,),) = over_repetitions(plan, {n: (m,) for n, m in zip(names, found, strict=True)}).values()
    return together


def test_the_mean_of_repetitions_without_a_line_is_less_than_the_mean_of_their_bounds() -> None:
    """It was a dash, without a reason."""
    found = _over(_hidden(1.0), _hidden(2.0))
    assert found.measured.text == "< 1.5"
    document = found.to_json()
    assert (document["mean"], document["below"], document["reason"]) == (None, 1.5, REASON)
    assert "uncertainty_reason" not in document


def test_there_is_no_mean_of_those_repetitions_alone_in_which_a_line_stands_out() -> None:
    """The mean of the largest of them was given: it is that of amplitudes that noise has raised above it."""
    found = _over(_hidden(1.0), _line(1.8), _line(2.0))
    assert math.isnan(found.mean)
    assert found.uncertainty is None
    assert found.below == pytest.approx((1.0 + 2.0 + 2.2) / 3.0)
    assert found.n_of_count == "2 of 3"
    assert found.measured.reason == found.remark == found.to_json()["reason"]
    assert found.remark == (
        f"2 of 3 repetitions have a value, the others have none: {REASON}; a mean of the former alone would "
        f"be too large"
    )


def test_the_mean_has_no_bound_where_one_repetition_has_none() -> None:
    found = _over(_hidden(1.0), _hidden(None), _line(1.8))
    assert (found.below, found.measured.text) == (None, "–")
    assert "a mean of the former alone would be too large" in found.reason


@pytest.mark.parametrize(
    ("one", "two", "text", "exceeds", "judgement"),
    [
        (_line(1.8), _hidden(1.0), "< −0.60", True, "better"),
        (_line(1.1), _hidden(1.0), "< +0.10", False, ""),
        (_hidden(1.0), _line(1.8), "> +0.60", True, "worse"),
        (_hidden(1.0), _line(1.1), "> −0.10", False, ""),
    ],
)
def test_the_difference_to_a_line_that_is_not_there_is_bounded(
    one: Measurement, two: Measurement, text: str, exceeds: bool, judgement: str
) -> None:
    (delta,) = deltas(_result(one, limit=Limit(max=3.0)), _result(two))
    assert (delta.text, delta.exceeds, delta.judgement) == (text, exceeds, judgement)
    assert (delta.reason, delta.uncertainty_reason) == ("", "")
    document = delta.to_json()
    assert (document["absolute"], document["percent"]) == (None, None)
    assert document.get("above", document.get("below")) == pytest.approx(float(text[2:].replace("−", "-")))


def _delta(one: Measurement, two: Measurement) -> Delta:
    (delta,) = deltas(_result(one), _result(two))
    return delta


def test_what_has_no_difference_has_a_reason() -> None:
    both = _delta(_hidden(1.0), _hidden(1.2))
    assert (both.exceeds, both.text) == (None, "–")
    assert both.reason == "of both no more is known than what they are less than"
    bare = _delta(_hidden(1.0), _line(1.8, None))
    assert (bare.exceeds, bare.uncertainty_reason) == (None, "here, it has no uncertainty")
    assert _delta(_line(1.8), _hidden(None)).reason == f"undefined here: {REASON}"


def test_bounds_are_printed_where_values_are(capsys: pytest.CaptureFixture[str]) -> None:
    both = {"a": _result(_line(1.8)), "b": _result(_hidden(1.0)), "c": _result(_hidden(None))}
    show(Output(as_json=False), Comparison.of("", both))
    printed = " ".join(capsys.readouterr().out.split())
    assert "torque_line_amplitude │ 1.80 │ < 1 │ < −0.60 │ * │ – │ – │ – │ Nm" in printed
    assert f"not compared: torque_line_amplitude: undefined here: {REASON}" in printed
    show_repeated(Output(as_json=False), {"tpc": (_over(_hidden(1.0), _line(1.8)),)})
    printed = " ".join(capsys.readouterr().out.split())
    assert "torque_line_amplitude │ < 1.5 │ 1 of 2 │ Nm" in printed
    assert "a mean of the former alone would be too large" in printed
    text = str(ComparisonOfApi("a", "b", deltas(_result(_line(1.8)), _result(_hidden(1.0)))))
    assert text.splitlines()[1].split("  ") == [
        "torque_line_amplitude",
        "1.800",
        "< 1",
        "< −0.60",
        "*",
        "Nm",
    ]


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 0, 2)])
def test_the_worst_of_several_cases_is_that_with_the_least_room(order: Sequence[int]) -> None:
    """A bound had a room of nan, beside which any other was the worst, or none."""
    found = [
        _result(each, case=str(n), limit=Limit(max=3.0))
        for n, each in enumerate((_line(1.0), _hidden(2.0), _hidden(1.5)))
    ]
    run = RecordedRun("", Path(), ())
    recorded = [cast(RecordedCase, SimpleNamespace(name=found[n].case, assessment=found[n])) for n in order]
    object.__setattr__(run, "cases", tuple(recorded))
    run.__dict__["repeated"] = {}
    (grid,) = _judged_together([run]).items
    assert isinstance(grid, Grid)
    assert [cell.text for cell in grid.rows[0]][3:6] == ["< 2 Nm", "1", "> 1 Nm"]


def test_a_test_of_a_suite_judges_by_the_bound_as_a_plan_does() -> None:
    """It failed whatever its limit was, as what was not measured."""
    for most, verdict in ((1.5, Verdict.PASS), (0.5, Verdict.UNDECIDED)):
        judged = held(NAME, math.nan, "Nm", Limit(max=most), reason=REASON, below=1.0)
        assert judged.judge() is verdict
        assert judged.stated == "< 1.0 Nm"
        assert (judged.complaint == "") is (verdict is Verdict.PASS)
