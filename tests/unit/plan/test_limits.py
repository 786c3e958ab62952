"""Decision rules after JCGM 106:2012: guard bands, probability of conformance, limits over repetitions."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, strategies as st
from pydantic import ValidationError
from scipy import stats

from benchtool.analysis import Measurement, Uncertainty
from benchtool.plan.judged import JudgedLimit, Missed
from benchtool.plan.limits import Limit, Verdict, worst
from tests.at_length import at_length

ITEMS = 100_000


def _U(expanded: float) -> Uncertainty:
    return Uncertainty(expanded / 2.0, "test", half_width=expanded)


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (1.75, Verdict.PASS),
        (1.76, Verdict.UNDECIDED),
        (2.0, Verdict.UNDECIDED),
        (2.25, Verdict.UNDECIDED),
        (2.26, Verdict.FAIL),
        (1.25, Verdict.PASS),
        (0.75, Verdict.UNDECIDED),
        (0.74, Verdict.FAIL),
        (None, Verdict.FAIL),
        (math.nan, Verdict.FAIL),
    ],
)
def test_a_guard_band_lies_on_both_sides_of_each_bound(value: float | None, verdict: Verdict) -> None:
    assert Limit(min=1.0, max=2.0, margin="U").judge(value, _U(0.25)) is verdict


@pytest.mark.parametrize("unknown", [None, Uncertainty(math.nan, ""), Uncertainty(math.inf, "")])
def test_a_guard_band_of_unknown_width_fails(unknown: Uncertainty | None) -> None:
    assert Limit(max=2.0, margin="U").judge(0.0, unknown) is Verdict.FAIL
    assert Limit(max=2.0).judge(0.0, unknown) is Verdict.PASS  # simple acceptance asks for none
    assert Limit(max=2.0).conformance(0.0, unknown) is None
    measured = Measurement("x", 0.0, "Nm", "", uncertainty=unknown)
    told = JudgedLimit.of("x", Limit(max=2.0, margin="U"), measured).missed
    assert 'its uncertainty is not known, which margin = "U" of its limit ≤ 2 Nm needs' in str(told)


def test_what_lacks_for_a_probability_is_said_with_the_reason_and_without() -> None:
    """Where the measurement's own reason is printed as well, it stood there twice."""
    limit = Limit(max=2.0)
    for measured, lacks, why in (
        (
            Measurement("x", 0.0, "V", "", uncertainty_reason="no step"),
            "its uncertainty is not known",
            "no step",
        ),
        (Measurement.undefined("x", "V", "", "no line"), "it is undefined", "no line"),
    ):
        held = JudgedLimit.of("x", limit, measured)
        assert held.conformance_reason == f"{lacks} ({why})"
        assert held.without_conformance == lacks
    assert JudgedLimit.of("x", limit, None).without_conformance == "it was not measured"


@given(st.floats(-10, 10), st.floats(0, 3), st.floats(1, 50))
def test_a_guard_band_never_reverses_simple_acceptance(value: float, standard: float, dof: float) -> None:
    uncertainty = Uncertainty(standard, "", dof)
    simple = Limit(min=-1.0, max=4.0).judge(value)
    guarded = Limit(min=-1.0, max=4.0, margin="U").judge(value, uncertainty)
    assert guarded in (simple, Verdict.UNDECIDED)


@pytest.mark.parametrize("dof", [4.0, math.inf, *at_length(30.0)])
def test_of_items_at_a_limit_a_guard_band_passes_one_in_forty(dof: float) -> None:
    """Of items at the limit at most 2.5 % pass, for any degrees of freedom."""
    random = np.random.default_rng(7)
    value = 1.0 + 0.1 * random.standard_normal(ITEMS)
    share = np.ones(ITEMS) if math.isinf(dof) else random.chisquare(dof, ITEMS) / dof
    standard = 0.1 * np.sqrt(share)
    limit = Limit(max=1.0, margin="U")
    verdicts = [
        limit.judge(one, Uncertainty(u, "", dof))
        for one, u in zip(value.tolist(), standard.tolist(), strict=True)
    ]
    assert verdicts.count(Verdict.PASS) / ITEMS == pytest.approx(0.025, abs=0.003)
    assert verdicts.count(Verdict.FAIL) / ITEMS == pytest.approx(0.025, abs=0.003)


def test_probability_of_conformance() -> None:
    limit = Limit(min=12.5, max=16.3)
    assert limit.conformance(13.6, Uncertainty(1.8, "")) == pytest.approx(0.663, abs=5e-4)
    student = limit.conformance(13.6, Uncertainty(1.8, "", dof=5.0))
    expected = stats.t.cdf(2.7 / 1.8, 5) - stats.t.cdf(-1.1 / 1.8, 5)
    assert student == pytest.approx(expected)
    assert Limit(max=1.0).conformance(0.0, Uncertainty(0.0, "")) == 1.0
    assert Limit(max=1.0).conformance(2.0, Uncertainty(0.0, "")) == 0.0
    assert Limit(max=1.0).conformance(math.nan, Uncertainty(0.1, "")) is None


@given(st.floats(-5, 5), st.floats(0.01, 3), st.floats(1, 100))
def test_conformance_is_975_permille_at_the_edge_of_the_guard_band(
    bound: float, standard: float, dof: float
) -> None:
    uncertainty = Uncertainty(standard, "", dof)
    inside = Limit(max=bound).conformance(bound - uncertainty.expanded, uncertainty)
    assert inside == pytest.approx(0.975, abs=1e-6)
    assert Limit(min=bound).conformance(bound, uncertainty) == pytest.approx(0.5)


def test_the_rule_is_stated() -> None:
    measured = Measurement("x", 1.95, "Nm", "", uncertainty=Uncertainty(0.05, ""))
    document = JudgedLimit.of("x", Limit(max=2.0, margin="U"), measured).to_json()
    assert (document["margin"], document["verdict"]) == ("U", "undecided")
    assert document["rule"] == "guard band U (95 %)"
    assert document["conformance"] == pytest.approx(stats.norm.cdf(1.0))
    assert JudgedLimit.of("x", Limit(max=2.0), None).to_json() == {
        "max": 2.0,
        "margin": 0.0,
        "rule": "simple acceptance",
        "verdict": "fail",
        "conformance_reason": "it was not measured",
    }
    assert Limit(max=2.0, margin=0.1).rule == "marginal within 0.1"
    assert str(JudgedLimit.of("x", Limit(max=2.0, margin="U"), measured).missed) == (
        "x is 1.950 ± 0.098 Nm, 0.05 Nm inside its limit ≤ 2 Nm, less than its U; "
        "probability of conformance 0.841"
    )


@pytest.mark.parametrize("margin", ["u", "", -0.1, True, math.nan, math.inf])
def test_other_margins_are_refused(margin: object) -> None:
    with pytest.raises(ValidationError, match='"U" for the expanded uncertainty'):
        Limit.model_validate({"max": 1.0, "margin": margin})


def test_what_is_undecided_is_not_met() -> None:
    assert [verdict.met for verdict in Verdict] == [True, True, True, False, False]
    assert worst([Verdict.MARGINAL, Verdict.UNDECIDED]) is Verdict.UNDECIDED
    assert worst([Verdict.UNDECIDED, Verdict.FAIL]) is Verdict.FAIL


@pytest.mark.parametrize(
    ("limit", "text"),
    [
        (Limit(min=1.0, max=2.5), "≥ 1, ≤ 2.5"),
        (Limit(max=2.5), "≤ 2.5"),
        (Limit(min=3205130000.0, max=3205130000.0), "= 3205130000"),
        # of one size in one style
        (Limit(min=1e-4 * (1.0 - 1e-5), max=1e-4 * (1.0 + 1e-5)), "≥ 0.99999 × 10⁻⁴, ≤ 1.00001 × 10⁻⁴"),
        (Limit(min=-1e-5, max=2e-4), "≥ −0.1 × 10⁻⁴, ≤ 2 × 10⁻⁴"),
        (Limit(min=0.0, max=1e-5), "≥ 0, ≤ 1 × 10⁻⁵"),
        (Limit(min=1e-7, max=3.0), "≥ 1 × 10⁻⁷, ≤ 3"),
        # what was written, and what was computed
        (Limit(max=0.123456789), "≤ 0.123456789"),
        (Limit(min=15.71 * 0.95, max=1.0 / 3.0 + 15.71), "≥ 14.9245, ≤ 16.04333"),
    ],
)
def test_bounds_in_words(limit: Limit, text: str) -> None:
    assert limit.bounds == text


def test_a_key_states_the_unit_and_no_two_may_differ() -> None:
    limit = Limit.model_validate({"min_Nm": 0.5, "max_Nm": 1.0})
    assert (limit.min, limit.max, limit.unit) == (0.5, 1.0, "Nm")
    assert Limit.model_validate({"max_Nm": 1.0, "unit": "Nm"}).unit == "Nm"
    for table in ({"max_Nm": 1.0, "unit": "A"}, {"min_A": 0.5, "max_Nm": 1.0}):
        with pytest.raises(ValidationError, match="in one limit, one is expected"):
            Limit.model_validate(table)
    with pytest.raises(ValidationError, match="each states the same: leave one out"):
        Limit.model_validate({"max": 1.0, "max_Nm": 1.0})


@pytest.mark.parametrize(
    ("measured", "reason"),
    [
        (None, "it was not measured"),
        (Measurement.undefined("x", "Nm", "", "no sinusoid"), "it is undefined (no sinusoid)"),
        (
            Measurement("x", 1.0, "Nm", "", uncertainty_reason="too few periods"),
            "its uncertainty is not known (too few periods)",
        ),
        (Measurement("x", 1.0, "Nm", ""), "its uncertainty is not known"),
    ],
)
@pytest.mark.parametrize("margin", [0.0, "U"])
def test_a_limit_without_a_probability_says_why(
    measured: Measurement | None, reason: str, margin: float | Literal["U"]
) -> None:
    document = JudgedLimit.of("x", Limit(max=2.0, margin=margin), measured).to_json()
    assert document["conformance_reason"] == reason
    assert "conformance" not in document


@pytest.mark.parametrize(
    ("limit", "value", "verdict", "reason"),
    [
        (Limit(max=2.0), None, Verdict.FAIL, "was not measured, ≤ 2 is asked for"),
        (Limit(max=2.0), math.nan, Verdict.FAIL, "is undefined (of x), ≤ 2 Nm is asked for"),
        (
            Limit(max=2.0, margin=0.1),
            *(1.95, Verdict.MARGINAL, "is 1.950 Nm, within 0.1 Nm of its limit ≤ 2 Nm"),
        ),
        (
            Limit(min=1.0, max=2.0, margin=0.1),
            *(1.95, Verdict.MARGINAL, "is 1.950 Nm, within 0.1 Nm of its limit ≥ 1, ≤ 2 Nm"),
        ),
        (Limit(max=2.0), 2.5, Verdict.FAIL, "is 2.500 Nm, at most 2 Nm is allowed: 0.5 Nm too much"),
        (Limit(min=2.0), 1.5, Verdict.FAIL, "is 1.500 Nm, at least 2 Nm is asked for: 0.5 Nm too little"),
        (
            Limit(max=12345678.0),
            *(12355678.0, Verdict.FAIL, "is 12355678 Nm, at most 12345678 Nm is allowed: 10000 Nm too much"),
        ),
        (
            Limit(max=1e-6),
            *(0.5, Verdict.FAIL, "is 0.5000 Nm, at most 1 × 10⁻⁶ Nm is allowed: 0.5 Nm too much"),
        ),
    ],
)
def test_a_limit_that_was_missed_says_by_how_much(
    limit: Limit, value: float | None, verdict: Verdict, reason: str
) -> None:
    measured = None if value is None else Measurement("x", value, "Nm", "of x")
    found = JudgedLimit.of("x", limit, measured).missed
    assert found == Missed("x", verdict, reason)
    assert str(found) == f"x {reason}"


@pytest.mark.parametrize(
    ("limit", "U", "impossible"),
    [
        (Limit(min=1.0, max=1.19, margin="U"), 0.1, True),
        (Limit(min=1.0, max=1.21, margin="U"), 0.1, False),
        (Limit(min=1.0, max=1.01, margin="U"), math.inf, False),
        (Limit(min=1.0, max=1.01), 0.1, False),
        (Limit(max=1.01, margin="U"), 0.1, False),
    ],
)
def test_bounds_closer_than_a_guard_band_on_each_are_said_to_let_nothing_pass(
    limit: Limit, U: float, impossible: bool
) -> None:
    measured = Measurement("x", 1.1, "Nm", "", uncertainty=_U(U))
    judged = JudgedLimit.of("x", limit, measured)
    assert ("no value can pass, as the bounds are closer together than 2 U = 0.20" in str(judged.told)) is (
        impossible
    )
    assert ("remark" in judged.to_json()) is impossible


@pytest.mark.parametrize(("value", "told"), [(1.99, "0.579"), (2.5, "< 0.001")])
def test_a_missed_guard_band_says_a_probability_as_tables_do(value: float, told: str) -> None:
    """It was 0.000 here, and < 0.001 in the table."""
    measured = Measurement("x", value, "Nm", "", uncertainty=_U(0.098))
    found = JudgedLimit.of("x", Limit(max=2.0, margin="U"), measured).missed
    assert str(found).endswith(f"probability of conformance {told}")


def test_a_limit_that_was_met_is_not_missed() -> None:
    assert JudgedLimit.of("x", Limit(max=2.0), Measurement("x", 2.0, "Nm", "")).told is None


def test_a_limit_is_a_table_or_one_already() -> None:
    limit = Limit(max=2.0)
    assert Limit.model_validate(limit) is limit
    with pytest.raises(ValidationError, match="dictionary or instance of Limit"):
        Limit.model_validate("at most 2")


@pytest.mark.parametrize(
    ("limit", "verdict"),
    [
        (Limit(max=2.0), Verdict.PASS),
        (Limit(max=2.0, margin="U"), Verdict.PASS),
        (Limit(max=2.0, margin=0.5), Verdict.PASS),
        (Limit(max=2.0, margin=1.5), Verdict.MARGINAL),
        (Limit(max=0.9), Verdict.UNDECIDED),
        (Limit(min=0.0, max=2.0), Verdict.PASS),  # of an amplitude
        (Limit(min=0.5), Verdict.UNDECIDED),
        (Limit(min=1.5), Verdict.FAIL),
    ],
)
def test_a_line_that_does_not_stand_out_is_judged_by_the_noise_that_hides_it(
    limit: Limit, verdict: Verdict
) -> None:
    """It failed any limit, also one ten times above the noise."""
    hidden = replace(Measurement.undefined("x", "Nm", "", "no line stands out of the noise"), below=1.0)
    held = JudgedLimit.of("x", limit, hidden)
    assert held.verdict is verdict
    assert hidden.in_unit == "< 1 Nm"
    if verdict is Verdict.UNDECIDED:
        assert "x is < 1 Nm (no line stands out of the noise), " in str(held.missed)
