"""Differences between runs: sizes, significance, and which direction is good."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import stats

from benchtool.analysis import Correction, Measurement, analyze_step
from benchtool.analysis.measurement import Basis, measurements_from_json, measurements_to_json
from benchtool.analysis.statistics.scatter import error_of_series
from benchtool.analysis.uncertainty import (
    Contribution,
    InstrumentError,
    Uncertainty,
    combined,
    of_difference,
)
from benchtool.block import Block, Channel
from benchtool.plan.limits import Limit, Verdict
from benchtool.results.assessment import Assessment
from benchtool.results.comparison import Comparison, compare_cases
from benchtool.results.delta import Delta, deltas
from tests.at_length import at_length

BLOCK = Block((Channel("torque", "Nm"),), 0, 1, 1e-4, np.zeros((1, 1)))


def result(
    case: str = "a", *, limit: Limit | None = None, **values: tuple[float, float | None]
) -> Assessment:
    measurements = tuple(
        Measurement(
            name, value, "Nm", "", uncertainty=None if standard is None else Uncertainty(standard, "")
        )
        for name, (value, standard) in values.items()
    )
    limits = {} if limit is None else {"x": limit}
    return Assessment(case, Path("bundle"), measurements, (), limits, {}, BLOCK, None, None)


def test_a_difference_is_the_other_less_the_reference() -> None:
    (delta,) = deltas(result(x=(-2.0, None)), result(x=(-3.0, None)))
    assert (delta.absolute, delta.percent, delta.exceeds) == (-1.0, -50.0, None)


@pytest.mark.parametrize(("other", "exceeds"), [(1.0 + 0.97e-1, False), (1.0 + 0.99e-1, True), (0.5, True)])
def test_it_exceeds_the_expanded_uncertainty_of_both(other: float, exceeds: bool) -> None:
    (delta,) = deltas(result(x=(1.0, 0.03)), result(x=(other, 0.04)))
    assert delta.exceeds is exceeds


def test_the_repeatability_counts_in_a_difference_and_nowhere_else() -> None:
    wander = Contribution("wander", "A", 0.4)
    a, b = (result(x=(value, 0.3)) for value in (1.0, 2.2))
    a = replace(a, measurements=(replace(a.measurements[0], repeatability=wander),))
    (alone,), (wandering,) = deltas(b, b), deltas(a, b)
    assert alone.standard == pytest.approx(0.3 * math.sqrt(2.0))
    assert wandering.standard == pytest.approx(math.sqrt(0.3**2 + 0.3**2 + 0.4**2))
    assert wandering.exceeds is True  # k of two known contributions, 1.96, and 1.14
    (again,) = measurements_from_json(measurements_to_json(a.measurements))
    assert again == a.measurements[0]


@pytest.mark.parametrize(("apart_Hz", "is_one"), [(7.9, True), (8.1, False)])
def test_the_largest_lines_of_two_spectra_are_compared_where_they_are_one(
    apart_Hz: float, is_one: bool
) -> None:
    def at(line_Hz: float) -> Assessment:
        found = result(x=(line_Hz, 0.1))
        basis = Basis(duration_s=0.5, line_Hz=line_Hz)
        return replace(found, measurements=(replace(found.measurements[0], basis=basis),))

    (delta,) = deltas(at(100.0), at(100.0 + apart_Hz))
    assert (delta.exceeds, delta.reason == "") == ((True, True) if is_one else (None, False))


def test_amplitudes_of_two_largest_orders_are_not_compared() -> None:
    def at(order: int) -> Assessment:
        found = result(x=(0.01 * order, 0.001))
        return replace(found, measurements=(replace(found.measurements[0], basis=Basis(order=order)),))

    (same,), (other,) = deltas(at(24), at(24)), deltas(at(24), at(72))
    assert (same.exceeds, same.reason) == (False, "")
    assert (other.exceeds, other.uncertainty) == (None, None)
    assert "24 in the reference and 72 here" in other.reason


@pytest.mark.parametrize(("added", "is_compared"), [(0.01, True), (1.0, False)])
def test_a_number_that_alone_is_corrected_is_not_compared_silently(added: float, is_compared: bool) -> None:
    plain = result(x=(1.0, 0.1))
    correction = Correction(added, "bandwidth of 300 Hz of torque")
    number = replace(plain.measurements[0], value=1.0 + added, correction=correction)
    corrected = replace(plain, measurements=(number,))
    (alike,), (alone,) = deltas(corrected, corrected), deltas(plain, corrected)
    assert (alike.exceeds, alike.reason) == (False, "")
    assert (alone.exceeds, alone.reason == "") == ((False, True) if is_compared else (None, False))
    assert is_compared or "this alone is corrected, by 1 " in alone.reason


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.floats(0, 10), st.floats(0, 10))
def test_the_two_directions_agree(one: float, two: float, u_one: float, u_two: float) -> None:
    a, b = result(x=(one, u_one), limit=Limit(max=1.0)), result(x=(two, u_two))
    (there,), (back,) = deltas(a, b), deltas(b, a)
    assert there.absolute == -back.absolute
    assert there.exceeds is back.exceeds
    assert {there.judgement, back.judgement} in ({""}, {"better", "worse"})


@pytest.mark.parametrize(
    ("limit", "less"),
    [(Limit(max=1.0), "better"), (Limit(min=0.0), "worse"), (Limit(min=0.0, max=1.0), ""), (None, "")],
)
def test_a_limit_tells_which_direction_is_good(limit: Limit | None, less: str) -> None:
    (delta,) = deltas(result(x=(0.5, 0.01), limit=limit), result(x=(0.4, 0.01)))
    assert delta.judgement == less


@pytest.mark.parametrize("standards", [(None, None), (0.01, None), (None, 0.01)])
def test_a_difference_without_uncertainty_is_not_judged(standards: tuple[float | None, float | None]) -> None:
    one, two = standards
    reference, other = result(x=(0.5, one), limit=Limit(max=1.0)), result(x=(0.4, two))
    (delta,) = deltas(reference, other)
    assert (delta.exceeds, delta.judgement) == (None, "")
    told = {
        (None, None): "it has no uncertainty",
        (0.01, None): "here, it has no uncertainty",
        (None, 0.01): "in the reference, it has no uncertainty",
    }[standards]
    assert delta.uncertainty_reason == delta.to_json()["uncertainty_reason"] == told
    assert Comparison.of("", {"A": reference, "B": other}).without_uncertainty == {told: ("x",)}


def test_the_uncertainties_of_both_are_combined() -> None:
    (delta,) = deltas(result(x=(1.0, 0.03)), result(x=(2.0, 0.04)))
    assert delta.standard == pytest.approx(0.05)
    assert delta.to_json()["standard_uncertainty"] == delta.standard
    assert delta.text == "+1.000 ± 0.098"
    assert (delta.percent_text, delta.marked_percent(" %")) == ("+100.0", "+100.0 %*")
    (delta,) = deltas(result(x=(2.0e-7, 3e-9)), result(x=(1.0e-7, 4e-9)))
    assert delta.text == "(−1.000 ± 0.098) × 10⁻⁷"
    (delta,) = deltas(result(x=(1.0e-7, 3e-9)), result(x=(2.0e-7, 4e-9)))
    assert delta.text == "(+1.000 ± 0.098) × 10⁻⁷"
    (delta,) = deltas(result(x=(1.0, None)), result(x=(2.5, 0.04)))
    assert (delta.text, delta.marked_percent()) == ("+1.50", "+150")


def test_k_comes_from_the_degrees_of_freedom_of_both() -> None:
    one, two = Uncertainty(0.03, "", dof=4.0), Uncertainty(0.04, "", dof=9.0)
    both = of_difference(one, two)
    assert both.dof == pytest.approx(0.05**4 / (0.03**4 / 4.0 + 0.04**4 / 9.0))
    assert both.expanded == pytest.approx(stats.t.ppf(0.975, both.dof) * 0.05)
    derived = of_difference(Uncertainty(0.03, "", half_width=0.05), Uncertainty(0.04, "", half_width=0.12))
    assert derived.expanded == pytest.approx(0.13)
    assert of_difference(Uncertainty(0.0, ""), Uncertainty(0.0, "")).expanded == 0.0


@pytest.mark.parametrize("dof", [(9.0, 3.0), *at_length(((2.0, 2.0),), ((4.0, 4.0),), ((math.inf, 4.0),))])
def test_false_alarms_are_as_many_as_stated(dof: tuple[float, float]) -> None:
    """Two normal results of the same truth with estimated uncertainties: 5 % are to exceed, 2 u lets more."""
    random = np.random.default_rng(3)
    runs = 20_000
    u = [
        np.full(runs, 1.0) if math.isinf(each) else np.sqrt(random.chisquare(each, runs) / each)
        for each in dof
    ]
    difference = random.standard_normal(runs) - random.standard_normal(runs)
    alarms = sum(
        abs(d) > of_difference(Uncertainty(a, "", dof[0]), Uncertainty(b, "", dof[1])).expanded
        for d, a, b in zip(difference.tolist(), u[0].tolist(), u[1].tolist(), strict=True)
    )
    by_two = float(np.mean(np.abs(difference) > 2.0 * np.hypot(*u)))
    assert 0.03 < alarms / runs < 0.06
    assert alarms / runs < by_two - 0.005


@pytest.mark.parametrize("count", [5, 20, *at_length(9)])
def test_means_of_few_values_raise_as_many_false_alarms_as_stated(count: int) -> None:
    """Student's deviation is in u and his factor in U: both together would raise half a per cent for five."""
    random, runs = np.random.default_rng(11), 2000
    values = random.standard_normal((2 * runs, count))
    found = [combined([error_of_series(each).line("scatter")], "") for each in values]
    within = [
        abs(float(np.mean(each))) <= u.expanded
        for each, u in zip(values, found, strict=True)
        if u is not None
    ]
    assert 0.93 < np.mean(within) < 0.98
    means = np.mean(values, axis=1)
    alarms = [
        abs(means[k] - means[k + 1]) > of_difference(one, two).expanded
        for k in range(0, 2 * runs, 2)
        if (one := found[k]) is not None and (two := found[k + 1]) is not None
    ]
    assert 0.02 < np.mean(alarms) < 0.065


@pytest.mark.parametrize("dof", [2.0, 4.0, 12.0])
def test_a_result_that_becomes_one_line_keeps_both_standard_uncertainties(dof: float) -> None:
    scatter = Contribution("a", "A", 0.3, dof, of_student=True)
    for budget in ([scatter], [scatter, Contribution("b", "B", 0.2)]):
        whole = combined(budget, "")
        assert whole is not None
        assert whole.line("both", -2.0).standard == whole.line("both", 2.0).standard > 0.0
        again = combined([whole.line("both", -2.0)], "")
        assert again is not None
        assert again.standard == pytest.approx(2.0 * whole.standard)
        assert again.experimental == pytest.approx(2.0 * whole.experimental, rel=1e-3)
        assert 0.99 * whole.expanded < 0.5 * again.expanded < 1.4 * whole.expanded
    raw = Uncertainty(0.3, "", dof=4.0)
    assert combined([raw.line("one")], "") == Uncertainty(0.3, "", 4.0, (Contribution("one", "A", 0.3, 4.0),))


def test_the_power_that_noise_adds_to_both_values_cancels() -> None:
    """Roots of the same power and of noise that is the same, or 1 % more in one, which moves its root."""

    def of(signal: float, noise: float) -> Measurement:
        value = math.hypot(signal, noise)
        bias = Contribution("power of the noise", "B", value - signal, adds_power=True)
        scatter = Contribution("scatter", "A", 0.001)
        width = math.hypot(1.96 * 0.001, bias.standard)
        return Measurement("x", value, "", "", uncertainty=combined([scatter, bias], "", half_width=width))

    def between(one: Measurement, two: Measurement) -> Delta:
        a, b = (replace(result(), measurements=(each,)) for each in (one, two))
        (delta,) = deltas(a, b)
        return delta

    same = between(of(1.0, 0.5), of(1.0, 0.5))
    assert same.standard == pytest.approx(0.001 * math.sqrt(2.0))
    assert same.uncertainty is not None
    assert same.uncertainty.expanded == pytest.approx(1.96 * same.standard, rel=1e-3)
    other = between(of(1.0, 0.5), of(1.0, 0.6))
    assert other.exceeds is False, "the noise explains it"
    assert other.standard == pytest.approx(math.hypot(0.001 * math.sqrt(2.0), other.absolute))
    assert between(of(1.0, 0.5), of(1.02, 0.5)).exceeds is True
    stated = of(1.0, 0.5).uncertainty
    assert stated is not None
    assert [each.name for each in stated.without_power().budget] == ["scatter"]
    alone = Uncertainty(0.1, "")
    assert of_difference(alone, alone, (0.0, 0.0)).standard == pytest.approx(0.1 * math.sqrt(2.0))
    (again,) = measurements_from_json(measurements_to_json([of(1.0, 0.5)]))
    assert again == of(1.0, 0.5)


def test_how_many_would_exceed_by_chance_is_said() -> None:
    one = result(a=(1.0, 0.1), b=(1.0, 0.1), c=(1.0, 0.1), d=(1.0, 0.1), e=(1.0, None))
    two = result(a=(2.0, 0.1), b=(1.0, 0.1), c=(1.0, 0.1), d=(1.0, 0.1), e=(2.0, None))
    comparison = Comparison.of("", {"one": one, "two": two})
    assert comparison.chance.to_json() == {
        "decided": 4,
        "exceeding": 1,
        "expected_by_chance": pytest.approx(0.2),
    }
    assert str(comparison.chance) == (
        "1 of 4 differences exceed their uncertainty; if nothing differed, 0.2 of them would do so by chance "
        "on average."
    )
    assert str(Comparison.of("", {"one": result(x=(1.0, 0.1)), "two": result(x=(2.0, 0.1))}).chance) == ""


def test_runs_of_other_lengths_are_said_to_be() -> None:
    def lasting(duration_s: float | None) -> Assessment:
        number = Measurement("x", 1.0, "Nm", "", Basis(duration_s=duration_s))
        return Assessment("a", Path("bundle"), (number,), (), {}, {}, BLOCK, None, None)

    (said,) = Comparison.of("", {"demo": lasting(0.52), "same": lasting(0.5201), "long": lasting(2.6)}).unlike
    assert "demo over 0.52 s, long over 2.6 s" in said
    assert "same" not in said
    assert Comparison.of("", {"one": lasting(0.52), "two": lasting(0.5201)}).unlike == ()
    assert Comparison.of("", {"one": lasting(None), "two": lasting(None)}).unlike == ()


def test_runs_at_other_rates_are_said_to_be() -> None:
    def sampled(rate_Hz: float | None) -> Assessment:
        number = Measurement("x", 1.0, "Nm", "", Basis(sample_rate_Hz=rate_Hz))
        return Assessment("a", Path("bundle"), (number,), (), {}, {}, BLOCK, None, None)

    runs = {"demo": sampled(10_000.0), "same": sampled(10_001.0), "fast": sampled(20_000.0)}
    (said,) = Comparison.of("", runs).unlike
    assert said.startswith("Sampled at other rates: demo at 10000 Hz, fast at 20000 Hz. ")
    assert "densities" in said


def test_a_difference_below_one_is_judged_by_its_sign_and_states_its_degrees_of_freedom() -> None:
    one = result(x=(0.5, 0.01), limit=Limit(max=1.0))
    (delta,) = deltas(one, result(x=(0.9, 0.01)))
    assert (delta.judgement, delta.to_json()["dof"]) == ("worse", None)
    few = Measurement("x", 0.9, "Nm", "", uncertainty=Uncertainty(0.01, "", dof=4.0))
    (delta,) = deltas(one, replace(one, measurements=(few,)))
    assert delta.to_json()["dof"] == pytest.approx(16.0)
    (delta,) = deltas(one, result(x=(0.9, None)))
    assert delta.to_json()["dof"] is None


def test_no_difference_is_neither_better_nor_worse() -> None:
    (delta,) = deltas(result(x=(0.5, 0.0), limit=Limit(max=1.0)), result(x=(0.5, 0.0)))
    assert (delta.exceeds, delta.judgement) == (False, "")


def test_what_chance_makes_is_neither_better_nor_worse() -> None:
    (delta,) = deltas(result(x=(0.5, 0.1), limit=Limit(max=1.0)), result(x=(0.4, 0.1)))
    assert (delta.exceeds, delta.judgement) == (False, "")


def test_limits_that_contradict_each_other_tell_nothing() -> None:
    one, two = result(x=(0.5, 0.01), limit=Limit(max=1.0)), result(x=(0.4, 0.01), limit=Limit(min=0.0))
    assert deltas(one, two)[0].judgement == ""


def test_what_has_no_value_has_no_difference() -> None:
    undefined = Measurement.undefined("x", "Nm", "", "no revolution")
    (delta,) = deltas(replace(result(), measurements=(undefined,)), result(x=(1.0, 0.1)))
    assert delta.to_json() == {
        "unit": "Nm",
        "reference": None,
        "value": 1.0,
        "absolute": None,
        "percent": None,
        "standard_uncertainty": None,
        "experimental_uncertainty": None,
        "dof": None,
        "student_factor": None,
        "k": None,
        "expanded_uncertainty": None,
        "exceeds_uncertainty": None,
        "judgement": None,
        "reason": "undefined in the reference: no revolution",
    }
    assert deltas(result(x=(0.0, None)), result(y=(1.0, None))) == ()


@pytest.mark.parametrize(
    ("reference", "reason"),
    [
        ((0.0, None), "the reference is zero"),
        ((0.01, 0.1), "the reference is zero within its U"),
        ((-0.15, 0.1), "the reference is zero within its U"),
        ((-0.25, 0.1), ""),
        ((0.01, None), ""),
    ],
)
def test_a_difference_is_no_percentage_of_what_may_be_zero(
    reference: tuple[float, float | None], reason: str
) -> None:
    """Of a reference of 0.01 ± 0.2 it was 99 000 %."""
    one, two = result(x=reference), result(x=(9.9, 0.1))
    (delta,) = deltas(one, two)
    assert (delta.percent_reason, delta.to_json().get("percent_reason", "")) == (reason, reason)
    assert math.isnan(delta.percent) is bool(reason)
    assert delta.absolute == pytest.approx(9.9 - reference[0])
    if reason:
        assert delta.marked_percent() == ("–" if reference[1] is None else "*")
        assert Comparison.of("", {"A": one, "B": two}).without_percent == {reason: ("x",)}


def test_cases_are_matched_by_name_and_the_others_named() -> None:
    one = [result("a", x=(1.0, None)), result("b", x=(2.0, None)), result("c", x=(3.0, None))]
    two = [result("b", x=(4.0, None)), result("a", x=(5.0, None)), result("d", x=(6.0, None))]
    comparisons, alone = compare_cases({"first": one, "second": two})
    assert [(each.case, each.deltas["second"][0].absolute) for each in comparisons] == [
        ("a", 4.0),
        ("b", 2.0),
    ]
    assert alone == ("first: c", "second: d")


def test_single_runs_are_compared_whatever_they_are_called_and_cases_of_one_run_with_its_first() -> None:
    (single,), alone = compare_cases(
        {"A": [result("tpc", x=(1.0, None))], "B": [result("foc", x=(3.0, None))]}
    )
    assert single.deltas["B"][0].absolute == 2.0
    assert alone == ()
    cases = [result("a", x=(1.0, None)), result("b", x=(2.0, None), y=(1.0, None))]
    (within,), _ = compare_cases({"run": cases})
    assert within.deltas["b"][0].absolute == 1.0
    assert within.names == ("x", "y")
    assert Comparison.of("", {"a": cases[0]}).deltas == {}


def test_what_is_not_compared_is_said_once_for_each_run() -> None:
    def at(order: int) -> Assessment:
        found = result(x=(0.01, 0.001))
        return replace(found, measurements=(replace(found.measurements[0], basis=Basis(order=order)),))

    (said,) = Comparison.of("", {"one": at(24), "two": at(72), "three": at(24)}).not_compared
    assert said.startswith("x: the largest order is 24 in the reference and 72 here")
    assert said.endswith("are not compared.")


def test_fewer_than_one_degree_of_freedom_counts_as_one() -> None:
    assert Uncertainty(1.0, "", dof=0.3).expanded == pytest.approx(stats.t.ppf(0.975, 1.0))
    assert Uncertainty(1.0, "", dof=0.3).probability_within(-1.0, 1.0) == pytest.approx(0.5)
    assert of_difference(Uncertainty(1.0, "", dof=0.3), Uncertainty(1.0, "", dof=0.3)).dof == pytest.approx(
        2.0
    )


def test_the_verdict_by_the_transducer_takes_its_number_where_it_contradicts() -> None:
    of = {"x": Limit(max=1.0)}
    numbers = tuple(
        Measurement(name, value, "Nm", "", uncertainty=Uncertainty(0.001, ""))
        for name, value in (("torque_ripple_pp", 0.05), ("transducer_torque_ripple_pp", 0.16), ("x", 0.5))
    )
    of["torque_ripple_pp"] = Limit(max=0.06)
    both = replace(result(), measurements=numbers, limits=of, transducer=BLOCK)
    assert (both.verdict, both.verdict_by_transducer) == (Verdict.PASS, Verdict.FAIL)
    (told,) = both.disagreements
    assert told.to_json()["verdict_by_transducer"] == "fail"
    assert replace(both, limits={}).disagreements[0].to_json()["verdict_by_transducer"] is None
    assert replace(both, transducer=None).verdict_by_transducer is None
    agreed = tuple(replace(each, value=0.05) for each in numbers)
    assert replace(both, measurements=agreed).verdict_by_transducer is Verdict.PASS


@pytest.mark.parametrize(("longer_s", "is_said"), [(1.009, False), (1.01005, False), (1.015, True)])
def test_lengths_that_differ_by_a_hundredth_of_the_longer_are_alike(longer_s: float, is_said: bool) -> None:
    def lasting(duration_s: float) -> Assessment:
        number = Measurement("x", 1.0, "Nm", "", Basis(duration_s=duration_s))
        return replace(result(), measurements=(number,))

    assert bool(Comparison.of("", {"one": lasting(1.0), "two": lasting(longer_s)}).unlike) is is_said


def test_of_a_shared_error_remains_what_it_moves_one_value_more() -> None:
    error = InstrumentError("gain", "torque", serial_number="7")

    def of(standard: float, sign: Literal[-1, 1]) -> Uncertainty:
        line = Contribution("gain", "B", standard, instrument=error, sign=sign)
        return Uncertainty(0.1, "noise").with_instruments([line])

    own = 0.1 * math.sqrt(2.0)
    assert of_difference(of(0.3, 1), of(0.3, 1)).standard == pytest.approx(own)
    assert of_difference(of(0.3, 1), of(0.2, 1)).standard == pytest.approx(math.hypot(own, 0.1))
    assert of_difference(of(0.3, 1), of(0.2, -1)).standard == pytest.approx(math.hypot(own, 0.5))


def test_values_are_shown_to_the_place_of_their_difference() -> None:
    """Four digits of 9.99874 and 10.0039 Hz, 9.999 and 10, contradict a difference of 0.0052."""
    (delta,) = deltas(result(x=(9.99874, 0.0015)), result(x=(10.0039, 0.0015)))
    assert (delta.reference_text, delta.value_text) == ("9.9987", "10.0039")
    (bare,) = deltas(result(x=(9.99874, None)), result(x=(10.0039, None)))
    assert (bare.reference_text, bare.value_text) == ("9.999", "10.00")


@pytest.mark.parametrize("width", ["bin_Hz", "band", "span_s"])
@pytest.mark.parametrize(("by", "is_compared"), [(1.005, True), (1.03, False)])
def test_numbers_of_other_bins_bands_or_times_are_not_compared(
    width: str, by: float, is_compared: bool
) -> None:
    """Noise floors of one machine over 0.5 to 2.5 s differed by more than U in 93 %."""

    def of(value: float) -> Assessment:
        found = result(x=(1.0, 0.1))
        basis = Basis(**{width: value})  # type: ignore[arg-type]
        return replace(found, measurements=(replace(found.measurements[0], basis=basis),))

    (delta,) = deltas(of(1.0), of(by))
    assert (delta.exceeds, delta.reason == "") == ((False, True) if is_compared else (None, False))
    assert is_compared or "1.03 " in delta.reason


def test_plateaus_of_one_answer_over_other_times_are_not_compared() -> None:
    """The mean of a lag from 98 % on is nearer to the step, the longer it is followed: 48 % false alarms."""

    def answered(duration_s: float) -> Assessment:
        time_s = np.arange(-0.1, duration_s, 1e-4) + 5e-5
        noise = 1e-3 * np.random.default_rng(1).standard_normal(len(time_s))
        y = np.where(time_s > 0.0, -np.expm1(-time_s / 0.02), 0.0) + noise
        block = Block.from_arrays(1e4, {"y": "Nm", "r": "Nm"}, y=y, r=np.where(time_s > 0.0, 1.0, 0.0))
        return replace(result(x=(1.0, 0.1)), measurements=analyze_step(block, "y", "r").measurements)

    names = ("plateau_mean", "tracking_error_mean", "tracking_error_max")
    for seconds, is_compared in ((0.3, True), (0.9, False)):
        found = {each.name: each for each in deltas(answered(0.3), answered(seconds))}
        assert [found[name].reason == "" for name in names] == [is_compared] * 3
        assert found["rise_time"].reason == ""
