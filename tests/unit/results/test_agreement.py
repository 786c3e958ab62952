"""Limits that were missed, in words, and numbers of the drive that the transducer contradicts."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement, Uncertainty
from benchtool.plan.limits import Limit, Verdict, missed
from benchtool.results.agreement import disagreements


def _number(name: str, value: float, standard: float | None = None) -> Measurement:
    uncertain = None if standard is None else Uncertainty(standard, "test")
    return Measurement(name, value, "Nm", "a number", uncertainty=uncertain)


def test_a_ripple_that_the_shaft_contradicts_is_told_with_the_verdict_there() -> None:
    measured = (
        _number("torque_ripple_pp", 0.0501, 0.0016),
        _number("true_torque_ripple_pp", 0.194, 0.002),
        _number("flux_ripple_pp", 1.0),
        _number("true_torque_ripple_rms", 0.03),
    )
    (found,) = disagreements(measured, {"torque_ripple_pp": Limit(max=0.06)})
    assert found.name == "torque_ripple_pp"
    assert found.verdict is Verdict.FAIL
    assert found.to_json()["transducer"] == 0.194
    assert found.to_json()["standard_uncertainty"] == pytest.approx(math.hypot(0.0016, 0.002))


@pytest.mark.parametrize(
    ("difference", "own", "true", "told"),
    [
        (0.009, 0.003, 0.004, False),  # twice 0.005 is 0.01
        (0.011, 0.003, 0.004, True),
        (0.007, 0.003, None, True),
        (0.005, 0.003, None, False),
        (1e-6, None, None, True),
        (0.0, None, None, False),
        (math.nan, 0.1, 0.1, False),
    ],
)
def test_any_pair_of_names_is_compared(
    difference: float, own: float | None, true: float | None, told: bool
) -> None:
    pair = (_number("anything", 1.0, own), _number("true_anything", 1.0 + difference, true))
    assert bool(disagreements(pair, {})) is told
    assert all(each.verdict is None for each in disagreements(pair, {}))


def test_what_was_missed_says_the_bound_and_by_how_much() -> None:
    limit = Limit(min=1.0, max=2.0, margin=0.1)
    assert missed("x", limit, _number("x", 1.5)) is None
    assert str(missed("x", limit, _number("x", 2.25))) == (
        "x is 2.25 Nm, at most 2 is allowed: 0.25 too much"
    )
    assert str(missed("x", limit, _number("x", 0.5))) == (
        "x is 0.5 Nm, at least 1 is asked for: 0.5 too little"
    )
    assert str(missed("x", limit, _number("x", 1.95))) == "x is 1.95 Nm, within 0.1 of its limit >= 1, <= 2"
    assert str(missed("x", limit, None)) == "x was not measured, >= 1, <= 2 is asked for"
    undefined = Measurement.undefined("x", "Nm", "a number", "nothing tells it")
    assert str(missed("x", limit, undefined)) == (
        "x is undefined (nothing tells it), >= 1, <= 2 is asked for"
    )
