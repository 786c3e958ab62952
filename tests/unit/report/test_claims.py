"""Claims of a publication against measured numbers: verdicts in both readings, every shipped claim."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pydantic import ValidationError

from benchtool.analysis import Contribution, Measurement, Uncertainty
from benchtool.plan.cases import cases
from benchtool.plan.model import load_plan, plan_names
from benchtool.profile import Claim, Comparison, load_profile
from benchtool.report.claims import Finding, Standing, claims_table, finding, literal, verdict

EXACT = Uncertainty(0.0, "as stated")


def _measured(**values: float) -> list[Measurement]:
    return [
        Measurement(name, value, "Nm", "as defined", uncertainty=EXACT if math.isfinite(value) else None)
        for name, value in values.items()
    ]


FIGURES = {
    "fig": {
        "new": _measured(ripple=1.0, error=-0.5),
        "old": _measured(ripple=3.0, error=math.nan),
        "literal,new": _measured(ripple=2.0, error=-0.1),
        "literal,old": _measured(ripple=1.5),
    },
    "other": {"foc": _measured(ripple=0.5)},
}


def _claim(**comparison: Any) -> Claim:
    given = {"plan": "fig", "case": "new", "measurement": "ripple", **comparison}
    return Claim(claim="it is so", source="Fig. 1", comparisons=(Comparison.model_validate(given),))


def _verdict(claim: Claim) -> str:
    here, letter = (finding(claim, FIGURES, by_the_letter=each) for each in (False, True))
    return verdict(here, letter)


@pytest.mark.parametrize(
    ("comparison", "expected"),
    [
        ({"relation": "below", "value": 2.5}, "yes"),
        ({"relation": "above", "value": 2.5}, "no"),
        ({"relation": "below", "value": 2.0}, "only if improved as here"),
        ({"relation": "above", "value": 1.5}, "only if read literally"),
        ({"relation": "below", "other": {"case": "old"}}, "only if improved as here"),
        ({"relation": "below", "other": {"case": "old"}, "times": 0.5}, "only if improved as here"),
        ({"relation": "above", "other": {"plan": "other", "case": "foc"}}, "yes"),
        ({"relation": "near", "value": 1.4, "times": 1.5}, "yes"),
        ({"relation": "near", "value": 1.4, "times": 1.41}, "only if improved as here"),
        ({"measurement": "error", "relation": "near", "value": 0.5, "times": 9.0}, "no"),
        (
            {"measurement": "error", "relation": "near", "value": -0.5, "times": 2.0},
            "only if improved as here",
        ),
        ({"plan": "other", "case": "foc", "relation": "below", "value": 1.0}, "yes"),
        ({"case": "unknown", "relation": "below", "value": 1.0}, "not measured"),
        ({"case": "old", "measurement": "error", "relation": "below", "value": 1.0}, "not measured"),
        ({"relation": "below", "other": {"measurement": "nothing"}}, "not measured"),
    ],
)
def test_a_claim_holds_in_both_readings_in_one_or_in_none(comparison: dict[str, Any], expected: str) -> None:
    assert _verdict(_claim(**comparison)) == expected


def _with_U(name: str, value: float, U: float, **further: Any) -> Measurement:
    return Measurement(
        name, value, "Nm", "as defined", uncertainty=Uncertainty(U / 1.96, "scatter"), **further
    )


def _standing(claim: Claim, *measured: Measurement, other: Measurement | None = None) -> Standing:
    figures = {"fig": {"new": measured, "old": [other] if other else []}}
    return finding(claim, figures, by_the_letter=False).standing


@pytest.mark.parametrize(
    ("comparison", "standings"),
    [  # of 1 Nm ± U, with U of 0.1, 0.3 and 0.9 Nm
        ({"relation": "below", "value": 1.2}, "yes undecided undecided"),
        ({"relation": "above", "value": 1.2}, "no undecided undecided"),
        ({"relation": "below", "value": 0.5, "times": 4.0}, "yes yes yes"),
        ({"relation": "near", "value": 1.0, "times": 1.5}, "yes yes undecided"),
        ({"relation": "near", "value": 1.4, "times": 1.2}, "no undecided undecided"),
        ({"relation": "near", "value": -1.4, "times": 1.2}, "no no no"),
        ({"relation": "near", "value": -0.1, "times": 9.0}, "no no no"),
    ],
)
def test_a_claim_within_the_uncertainty_is_undecided(comparison: dict[str, Any], standings: str) -> None:
    found = [_standing(_claim(**comparison), _with_U("ripple", 1.0, U)) for U in (0.1, 0.3, 0.9)]
    assert found == standings.split()


@pytest.mark.parametrize(("apart", "expected"), [(0.51, Standing.HOLDS), (0.49, Standing.UNDECIDED)])
def test_the_uncertainties_of_two_numbers_add_as_squares(apart: float, expected: Standing) -> None:
    claim = _claim(relation="below", other={"case": "old"}, times=2.0)
    new, old = _with_U("ripple", 1.0, 0.3), _with_U("ripple", 0.5 * (1.0 + apart), 0.2)
    assert _standing(claim, new, other=old) is expected


def test_what_another_record_differs_by_counts() -> None:
    again = Contribution("another record", "A", 0.2)
    claim = _claim(relation="below", value=1.2)
    assert _standing(claim, _with_U("ripple", 1.0, 0.1, repeatability=again)) is Standing.UNDECIDED


@pytest.mark.parametrize("relation", ["below", "above", "near"])
def test_a_number_without_an_uncertainty_decides_no_claim(relation: str) -> None:
    bare, known = Measurement("ripple", 1.0, "Nm", "as defined"), _with_U("ripple", 1.0, 0.1)
    stated = _claim(relation=relation, value=9.0)
    assert _standing(stated, bare) is Standing.UNDECIDED
    (number,) = finding(stated, {"fig": {"new": [bare]}}, by_the_letter=False).numbers
    assert number.startswith("fig new ripple 1 Nm without U ")
    compared = _claim(relation=relation, other={"case": "old"}, times=9.0)
    assert _standing(compared, known, other=bare) is Standing.UNDECIDED
    assert _standing(compared, bare, other=known) is Standing.UNDECIDED


def test_one_comparison_that_fails_is_enough() -> None:
    undecided, fails = _claim(relation="below", value=1.1), _claim(relation="above", value=1.5)
    both = Claim(claim="both", source="Fig. 1", comparisons=(*undecided.comparisons, *fails.comparisons))
    assert _standing(both, _with_U("ripple", 1.0, 0.3)) is Standing.FAILS
    with_good = Claim(
        claim="both",
        source="Fig. 1",
        comparisons=(*undecided.comparisons, *_claim(relation="below", value=9.0).comparisons),
    )
    assert _standing(with_good, _with_U("ripple", 1.0, 0.3)) is Standing.UNDECIDED


@pytest.mark.parametrize(
    ("here", "letter", "expected"),
    [
        (Standing.UNDECIDED, Standing.UNDECIDED, "undecided"),
        (Standing.HOLDS, Standing.UNDECIDED, "yes if improved as here, undecided if read literally"),
        (Standing.UNDECIDED, Standing.FAILS, "undecided if improved as here, no if read literally"),
    ],
)
def test_each_reading_may_be_undecided(here: Standing, letter: Standing, expected: str) -> None:
    assert verdict(Finding(here, ()), Finding(letter, ())) == expected


def test_a_claim_needs_all_of_its_comparisons() -> None:
    good, bad = _claim(relation="below", value=5.0), _claim(relation="above", value=5.0)
    both = Claim(claim="both", source="Fig. 1", comparisons=(*good.comparisons, *bad.comparisons))
    assert _verdict(both) == "no"


def test_the_table_states_the_numbers_of_both_readings() -> None:
    claims = (
        _claim(relation="below", other={"case": "old"}, times=0.5),
        _claim(plan="other", case="foc", relation="near", value=0.5, times=2.0),
    )
    *_, first, second = claims_table(claims, FIGURES)
    assert first == (
        "| it is so | Fig. 1 | only if improved as here | fig new ripple 1 Nm < 0.5 × old 3 Nm "
        "| fig new ripple 2 Nm ≮ 0.5 × old 1.5 Nm |"
    )
    assert second.endswith("| yes | other foc ripple 0.5 Nm ≈ 0.5 Nm (within a factor of 2) | the same |")


@pytest.mark.parametrize("partners", [{}, {"value": 1.0, "other": {"case": "old"}}])
def test_a_comparison_has_one_partner(partners: dict[str, Any]) -> None:
    with pytest.raises(ValidationError, match="value or with other"):
        _claim(relation="below", **partners)


def test_every_shipped_claim_compares_cases_that_its_plans_run() -> None:
    plans = {name.partition("/")[2]: load_plan(name) for name in plan_names("zhu2011")}
    run = {name: {case.name for case in cases(plan)} for name, plan in plans.items()}
    claims = load_profile("zhu2011").claims
    assert len(claims) > 20
    for claim in claims:
        for each in claim.comparisons:
            assert each.case in run[each.plan], claim.claim
            if each.other is not None:
                assert (each.other.case or each.case) in run[each.other.plan or each.plan], claim.claim


def test_the_figures_of_the_paper_are_run_in_both_readings_at_what_the_choices_say() -> None:
    for number in (4, 5, 6, 7, 8):
        plan = load_plan(f"zhu2011/fig{number}")
        names = {case.name for case in cases(plan)}
        assert {literal(name) for name in names if not name.startswith("literal")} < names
        by_name = {case.name: case for case in cases(plan)}
        assert by_name["literal,tpc"].setup["lambda_reference"] == "start"
        assert by_name["literal,tpc"].setup["flux_comparator"] == "plain"
        u_dc_V = plan.emulator["inverter.u_dc_V"]
        assert plan.setup["u_s_V"] == pytest.approx(2 / 3 * u_dc_V, rel=1e-3)
        assert (u_dc_V == 150.0) == (number >= 6)
