"""Repetitions of a case, put together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError
from scipy import stats

from benchtool.analysis import Measurement, Uncertainty
from benchtool.analysis.uncertainty import Contribution, InstrumentError
from benchtool.plan.cases import cases
from benchtool.plan.limits import Limit, Verdict, Waived
from benchtool.plan.model import Plan, Sweep
from benchtool.results.judged_repetitions import JudgedTogether, _all_conform, limits_together
from benchtool.results.repetitions import Repeated, over_repetitions
from benchtool.results.run_result import RunResult


def _plan(repetitions: int) -> Plan:
    return Plan.model_validate(
        {
            "title": "test",
            "profile": "zhu2011",
            "repetitions": repetitions,
            "sweep": {"setup": {"u_s_V": [60.0, 81.65]}},
            "operating_point": {"omega_m_rad_s": 10.0},
            "record": {"duration_s": 0.1, "channels": ("torque",)},
        }
    )


def _measured(value: float) -> tuple[Measurement, ...]:
    return (Measurement("torque_mean", value, "Nm", "mean"),)


def test_the_mean_and_its_standard_uncertainty() -> None:
    values = {"u_s_V=60.1": 1.0, "u_s_V=60.2": 2.0, "u_s_V=60.3": 6.0}
    values |= {"u_s_V=81.65.1": 5.0, "u_s_V=81.65.2": math.nan, "u_s_V=81.65.3": 7.0}
    found = over_repetitions(_plan(3), {case: _measured(value) for case, value in values.items()})
    assert list(found) == ["u_s_V=60", "u_s_V=81.65"]
    (first,), (second,) = found.values()
    assert (first.name, first.unit, first.mean, first.n) == ("torque_mean", "Nm", 3.0, 3)
    assert first.standard_uncertainty == pytest.approx(math.sqrt(7.0 / 3.0))
    assert (second.mean, second.n) == (6.0, 2)
    assert second.standard_uncertainty == pytest.approx(1.0)


def test_the_document_has_one_standard_uncertainty_of_the_mean() -> None:
    """That of `uncertainty`, with the errors of sensors that all repetitions share, and what few tell of."""
    gain = Contribution("gain", "B", 3.0, instrument=InstrumentError("gain", "torque"))
    together = Repeated("torque_mean", "Nm", 1.0, 4.0, 4, instruments=(gain,)).to_json()
    assert together["standard_uncertainty"] == pytest.approx(math.hypot(math.sqrt(3.0) * 4.0, 3.0))
    assert together["uncertainty"]["standard"] == together["standard_uncertainty"]
    assert together["uncertainty"]["dof"] == pytest.approx(3.0 * (5.0 / 4.0) ** 4)
    assert together["uncertainty"]["expanded"] == pytest.approx(
        5.0 * stats.t.ppf(0.975, 3.0 * (5.0 / 4.0) ** 4)
    )


@pytest.mark.parametrize("repetitions", [3, 4, 5, 10])
def test_twice_the_standard_uncertainty_of_few_repetitions_holds_their_truth(repetitions: int) -> None:
    """Of three, 2 s / sqrt(3) held it in 81 %."""
    random = np.random.default_rng(repetitions)
    values = random.standard_normal((4000, repetitions))
    mean = np.mean(values, axis=1)
    s = np.std(values, axis=1, ddof=1) / math.sqrt(repetitions)
    one = Repeated("torque_mean", "Nm", 0.0, 1.0, repetitions).uncertainty
    assert one is not None
    assert 0.92 < float(np.mean(np.abs(mean) <= 2.0 * one.standard * s)) < 0.98
    assert float(np.mean(np.abs(mean) <= one.expanded * s)) == pytest.approx(0.95, abs=0.015)


def test_what_was_never_defined_is_null() -> None:
    measured = {f"u_s_V={u_s}.{n}": _measured(math.nan) for u_s in ("60", "81.65") for n in (1, 2)}
    document = RunResult((), over_repetitions(_plan(2), measured)).to_json()
    expected = {"mean": None, "standard_uncertainty": None, "n": 0, "unit": "Nm"}
    expected |= {"reason": "no repetition has a value"}
    assert document["repeated"]["u_s_V=60"] == {"torque_mean": expected}


def test_a_mean_of_some_of_the_repetitions_says_so() -> None:
    """One of three had a value: it stood as a mean, without ± and without a word."""
    none = Measurement.undefined("torque_mean", "Nm", "mean", "no line stands out of the noise")
    alone = Measurement("torque_mean", 1.0, "Nm", "mean", uncertainty=Uncertainty(0.1, "noise"))
    names = [case.name for case in cases(_plan(3))[:3]]

    def together(*found: Measurement) -> Repeated:
        measured = {name: (each,) for name, each in zip(names, found, strict=True)}
        (repeated,), *_ = over_repetitions(_plan(3), measured).values()
        return repeated

    one = together(none, alone, none)
    assert one.uncertainty == alone.uncertainty
    why = "the others have none: no line stands out of the noise"
    assert one.remark == one.to_json()["remark"] == f"1 of 3 repetitions has a value, {why}"
    assert together(alone, alone, none).remark == f"2 of 3 repetitions have a value, {why}"
    assert together(alone, alone, alone).remark == together(none, none, none).remark == ""
    unknown = replace(alone, uncertainty=None, uncertainty_reason="no whole periods")
    assert together(none, unknown, none).uncertainty_reason == "no whole periods"


def test_one_repetition_says_nothing() -> None:
    assert Repeated("torque_mean", "Nm", 1.0, math.nan, 1).uncertainty is None
    assert Repeated("torque_mean", "Nm", 1.0, 0.1, 2).uncertainty is not None
    assert over_repetitions(_plan(1), {}) == {}
    assert "repeated" not in RunResult(()).to_json()


def _repeated(judge: str, values: Sequence[float], *, standard: float = 0.0, limit: Limit) -> Repeated:
    plan = Plan.model_validate(
        _plan(len(values)).model_dump() | {"judge": judge, "sweep": {}, "limits": {"torque_mean": limit}}
    )
    uncertainty = Uncertainty(standard, "each")
    measured = {
        case.name: (Measurement("torque_mean", value, "Nm", "mean", uncertainty=uncertainty),)
        for case, value in zip(cases(plan), values, strict=True)
    }
    ((found,),) = over_repetitions(plan, measured).values()
    return found


def _judged(judge: str, values: Sequence[float], *, standard: float = 0.0, limit: Limit) -> JudgedTogether:
    judged = _repeated(judge, values, standard=standard, limit=limit).judged
    assert judged is not None
    return judged


def test_the_mean_of_repetitions_is_judged_with_its_own_uncertainty() -> None:
    values = [0.9, 1.0, 1.1, 1.0]
    found = _judged("mean", values, standard=0.08, limit=Limit(max=1.2, margin="U"))
    u = float(np.std(values, ddof=1)) / 2.0
    assert found.measured is not None
    assert found.measured.uncertainty is not None
    assert found.measured.uncertainty.experimental == pytest.approx(u)
    assert found.measured.uncertainty.dof == 3.0
    assert found.measured.uncertainty.expanded == pytest.approx(3.182 * u, rel=1e-3)
    assert found.verdict is Verdict.PASS
    assert _judged("mean", values, limit=Limit(max=1.1, margin="U")).verdict is Verdict.UNDECIDED
    assert _judged("mean", values, limit=Limit(max=1.05)).verdict is Verdict.PASS  # 1.1 alone would fail
    document = _repeated("mean", values, limit=Limit(max=1.05)).to_json()["limit"]
    assert (document["verdict"], document["rule"]) == ("pass", "simple acceptance")
    assert document["conformance"] == pytest.approx(float(stats.t.cdf(0.05 / u, 3)))


def test_what_the_power_of_noise_adds_to_each_repetition_is_in_their_mean() -> None:
    """49 harmonics of noise alone: every repetition reads 7 of its amplitudes, and none scatters by that."""
    added = Contribution("power that the noise adds", "B", 1.3, adds_power=True)
    scatter = Contribution("noise", "A", 0.1)
    values = (1.30, 1.25, 1.45)
    plan = _plan(3).model_copy(
        update={"judge": "mean", "limits": {"current_thd_f": Limit(max=2.0, margin="U")}}
    )
    measured = {
        case.name: (
            Measurement(
                "current_thd_f",
                value,
                "%",
                "harmonics",
                uncertainty=Uncertainty(math.hypot(1.3, 0.1), "noise", budget=(scatter, added)),
            ),
        )
        for case, value in zip(cases(plan)[:3], values, strict=True)
    }

    found, *_ = over_repetitions(plan, measured).values()

    u = float(np.std(values, ddof=1)) / math.sqrt(3.0)
    assert found[0].uncertainty is not None
    assert found[0].uncertainty.experimental == pytest.approx(math.hypot(1.3, u))
    assert found[0].uncertainty.expanded == pytest.approx(math.hypot(1.3, 4.3027 * u), rel=1e-4)
    assert found[0].uncertainty.without_power().expanded == pytest.approx(4.3027 * u, rel=1e-4)
    assert found[0].judged is not None
    assert found[0].judged.verdict is Verdict.UNDECIDED


def test_the_worst_repetition_is_judged_with_its_own_uncertainty() -> None:
    found = _judged("worst", [0.9, 1.0, 1.1], standard=0.01, limit=Limit(max=1.05))
    assert found.verdict is Verdict.FAIL
    told = "torque_mean is 1.100 ± 0.020 Nm, at most 1.05 Nm is allowed: 0.05 Nm too much"
    assert str(found.missed) == told
    assert _judged("worst", [0.9, 1.0, 1.1], standard=0.01, limit=Limit(min=0.8)).verdict is Verdict.PASS


@pytest.mark.parametrize("shared", [0.0, 0.03, 0.05])
def test_the_worst_conforms_with_the_probability_that_all_do(shared: float) -> None:
    """Of values with an error in common and one of their own: by drawing both."""
    values, own = (0.96, 0.99, 1.01, 0.9), math.sqrt(0.05**2 - shared**2)
    gain = Contribution("gain", "B", shared, instrument=InstrumentError("gain", "torque"))
    known = Uncertainty(0.05, "each", budget=(Contribution("noise", "A", own), gain))
    found = _all_conform(Limit(max=1.05), [_uncertain(value, known) for value in values])
    random = np.random.default_rng(0)
    moved = np.array(values) + own * random.standard_normal((100_000, 4))
    moved += shared * random.standard_normal((100_000, 1))
    assert found == pytest.approx(float(np.mean(np.all(moved <= 1.05, axis=1))), abs=0.006)
    assert (
        _all_conform(Limit(max=1.05), [*(_uncertain(value, known) for value in values), *_measured(1.0)])
        is None
    )


@pytest.mark.parametrize("distance", [0.3, 1.0, 2.5, 3.5])
def test_what_repetitions_have_in_common_alone_conforms_as_the_worst_does(distance: float) -> None:
    """However far the bound is from them: all are beyond it at once."""
    gain = Contribution("gain", "B", 0.05, instrument=InstrumentError("gain", "torque"))
    known = Uncertainty(0.05, "each", budget=(gain,))
    found = _all_conform(Limit(max=1.0 + 0.05 * distance), [_uncertain(each, known) for each in (1.0, 0.99)])
    assert found == pytest.approx(float(stats.norm.cdf(distance)), abs=0.002)
    assert found is not None
    assert found <= float(stats.norm.cdf(distance)) + 1e-9


def _uncertain(value: float, uncertainty: Uncertainty) -> Measurement:
    return Measurement("torque_mean", value, "Nm", "mean", uncertainty=uncertainty)


def test_the_worst_states_the_probability_of_all() -> None:
    limit = Limit(max=1.05, margin="U")
    found = _judged("worst", [0.96, 0.99, 1.01], standard=0.05, limit=limit)
    alone = [float(stats.norm.cdf((1.05 - value) / 0.05)) for value in (0.96, 0.99, 1.01)]
    assert found.conformance == pytest.approx(math.prod(alone), rel=1e-6)
    assert found.to_json()["conformance"] == found.conformance
    assert f"probability that all 3 repetitions conform {found.conformance:.3f}" in str(found.missed)


@pytest.mark.parametrize("other", [None, Uncertainty(math.nan, "")])
@pytest.mark.parametrize("worst", [1.01, 3.0])  # of the second the probability is 0
def test_the_worst_has_no_probability_where_a_repetition_has_no_uncertainty(
    other: Uncertainty | None, worst: float
) -> None:
    plan = _plan(2).model_copy(
        update={"judge": "worst", "sweep": Sweep(), "limits": {"torque_mean": Limit(max=1.05)}}
    )
    known = Uncertainty(0.03, "each")
    first, second = (
        Measurement("torque_mean", value, "Nm", "mean", uncertainty=uncertainty)
        for value, uncertainty in ((0.9, other), (worst, known))
    )
    names = [case.name for case in cases(plan)]
    ((found,),) = over_repetitions(plan, {names[0]: (first,), names[1]: (second,)}).values()
    assert found.judged is not None
    assert found.judged.measured is not None
    assert found.judged.measured.value == worst
    assert found.judged.conformance is None
    document = found.to_json()["limit"]
    assert document["conformance_reason"] == "the uncertainty of a repetition is not known"
    assert "conformance" not in document


@pytest.mark.parametrize("judge", ["mean", "worst"])
def test_a_repetition_without_a_value_fails_the_limit_of_all(judge: str) -> None:
    found = _judged(judge, [0.9, math.nan, 1.1], limit=Limit(max=2.0))
    assert found.verdict is Verdict.FAIL
    assert "1 of 3 repetitions have no value" in str(found.missed)
    assert found.measured is not None
    assert (found.measured.unit, found.measured.definition) == ("Nm", f"{judge} of 3 repetitions")
    plan = Plan.model_validate(_plan(2).model_dump() | {"judge": judge, "limits": {"x": Limit(max=1.0)}})
    assert RunResult((), over_repetitions(plan, {})).verdict is Verdict.FAIL


def test_what_each_repetition_answers_for_is_not_judged_together() -> None:
    limits = {"omega_m_reached": Limit(max=1.0), "capture_rows_missing": Limit(max=0), "x": Limit(max=1)}
    plan = Plan.model_validate(_plan(2).model_dump() | {"judge": "mean", "limits": limits})
    assert list(limits_together(plan, "u_s_V=60")) == ["x"]
    assert limits_together(plan.model_copy(update={"judge": "each"}), "u_s_V=60") == {}
    with pytest.raises(ValidationError, match="judge = 'mean' is over repetitions, of which there is one"):
        Plan.model_validate(_plan(1).model_dump() | {"judge": "mean"})


@pytest.mark.parametrize(
    ("judge", "shaft", "by_transducer"),
    [
        ("mean", (1.30, 1.31), Verdict.FAIL),
        ("worst", (1.05, 1.31), Verdict.FAIL),
        ("mean", (1.10, 1.1001), Verdict.PASS),
        ("mean", (1.30, math.nan), Verdict.PASS),  # without a number in each there is nothing to contradict
    ],
)
def test_a_limit_on_repetitions_is_held_against_the_transducer_too(
    judge: str, shaft: tuple[float, float], by_transducer: Verdict
) -> None:
    plan = _plan(2).model_copy(
        update={"judge": judge, "limits": {"torque_mean": Limit(max=1.2)}, "sweep": Sweep()}
    )
    names = [case.name for case in cases(plan)]
    small = Uncertainty(1e-4, "test")
    measured = {
        name: (
            Measurement("torque_mean", value, "Nm", "mean", uncertainty=small),
            Measurement("transducer_torque_mean", true, "Nm", "mean", uncertainty=small),
        )
        for name, value, true in zip(names, (1.00, 1.001), shaft, strict=True)
    }
    (together,) = over_repetitions(plan, measured).values()
    estimate = next(each for each in together if each.name == "torque_mean")
    assert estimate.judged is not None
    assert estimate.judged.verdict is Verdict.PASS
    assert estimate.judged.verdict_by_transducer is by_transducer
    assert ("disagreement" in estimate.to_json()) == math.isfinite(sum(shaft))
    waived = Limit(max=1.2, waived=Waived(reason="a prototype", by="the client"))
    counted = replace(estimate.judged, limit=waived).verdict_by_transducer
    assert counted is (Verdict.NONE if by_transducer is Verdict.FAIL else by_transducer)


@pytest.mark.parametrize(("in_band", "expected"), [((0.8, 1.0), 0.9), ((0.8, None), None)])
def test_the_mean_has_that_in_the_band_of_a_transducer_where_each_has_it(
    in_band: tuple[float | None, ...], expected: float | None
) -> None:
    plan = _plan(2).model_copy(
        update={"judge": "mean", "limits": {"torque_mean": Limit(max=1.2)}, "sweep": Sweep()}
    )
    measured = {
        case.name: (
            Measurement(
                "torque_mean",
                1.0,
                "Nm",
                "mean",
                in_common_band=None if value is None else Measurement("torque_mean", value, "Nm", "mean"),
            ),
        )
        for case, value in zip(cases(plan), in_band, strict=True)
    }
    ((together,),) = over_repetitions(plan, measured).values()
    assert together.judged is not None
    assert together.judged.measured is not None
    found = together.judged.measured.in_common_band
    assert [each.value for each in (found,) if each is not None] == ([expected] if expected else [])
    assert [each.unit for each in (found,) if each is not None] == (["Nm"] if expected else [])


def test_an_error_that_lowers_every_repetition_lowers_their_mean() -> None:
    """The line keeps its sign, which a difference to what it raises needs."""
    lines = [
        Contribution("gain", "B", 0.2, instrument=InstrumentError("gain", "torque"), sign=-1) for _ in "ab"
    ]
    measured = {
        case.name: (
            Measurement("torque_mean", 1.0, "Nm", "", uncertainty=Uncertainty(0.2, "", budget=(line,))),
        )
        for case, line in zip(
            [each for each in cases(_plan(2)) if each.name.startswith("u_s_V=60")], lines, strict=True
        )
    }
    (found,) = over_repetitions(_plan(2), measured)["u_s_V=60"]
    (line,) = found.instruments
    assert line.standard == pytest.approx(0.2)
    assert line.sign == -1


@pytest.mark.parametrize("values", [(0.97, 1.0, 1.03), (0.7, 1.0, 1.3), (0.0, 1.0, 2.0)])
def test_what_is_of_type_b_in_every_repetition_is_in_their_mean(values: tuple[float, ...]) -> None:
    """Readings that agree by their resolution had U = 0, and what a scatter might show of it was left out."""
    budget = (
        Contribution("noise", "A", 0.02),
        Contribution("resolution", "B", 0.3),
        Contribution("tones nearby", "B", 0.4),
    )
    found = _three(*values, uncertainty=Uncertainty(math.sqrt(0.2504), "test", budget=budget))
    assert [line.name for line in found.type_b] == ["resolution", "tones nearby"]
    scatter = float(np.std(values, ddof=1)) / math.sqrt(3.0)
    assert found.uncertainty is not None
    assert found.uncertainty.experimental == pytest.approx(math.hypot(scatter, 0.5))
    assert found.uncertainty.expanded > 1.95 * 0.5


def _two(
    *values: float, standard: float, dof: float = 20.0, repeatability: Contribution | None = None
) -> Repeated:
    budget = (Contribution("noise", "A", standard, dof),)
    each = Uncertainty(standard, "noise", dof, budget)
    one = Measurement("torque_mean", 0.0, "Nm", "mean", uncertainty=each, repeatability=repeatability)
    measured = {
        case.name: (replace(one, value=value),)
        for case, value in zip(cases(_plan(2))[:2], values, strict=True)
    }
    (found,), *_ = over_repetitions(_plan(2), measured).values()
    return found


def test_two_repetitions_that_agree_by_chance_are_no_better_known_than_their_own_noise_says() -> None:
    """Their U was a 37th of that of each."""
    found = _two(1.0, 1.0 + 1e-4, standard=0.01).uncertainty
    assert found is not None
    assert found.experimental == pytest.approx(0.01 / math.sqrt(2.0))
    assert found.dof == pytest.approx(40.0, rel=0.01)
    assert [(line.name, line.evaluation) for line in found.budget] == [
        ("scatter within each repetition", "A"),
        ("scatter over 2 repetitions", "A"),
    ]
    assert found.source == "scatter within each repetition, scatter over 2 repetitions"


def test_repetitions_that_scatter_by_more_than_their_own_noise_are_known_by_the_scatter_alone() -> None:
    found = _two(1.0, 1.1, standard=0.01).uncertainty
    assert found is not None
    assert [line.name for line in found.budget] == ["scatter over 2 repetitions"]
    assert found.dof == 1.0


def test_the_scatter_of_repetitions_is_at_least_what_each_record_says_of_another() -> None:
    """Of speeds that wander from record to record two that agree by chance had the U of their noise alone."""
    wander = Contribution("wander of the speed", "A", 0.3, 20.0)
    calm, wandering = _two(1.0, 1.01, standard=0.1), _two(1.0, 1.01, standard=0.1, repeatability=wander)
    assert calm.uncertainty is not None
    assert wandering.uncertainty is not None
    assert calm.uncertainty.experimental == pytest.approx(0.1 / math.sqrt(2.0), rel=0.01)
    assert wandering.uncertainty.experimental == pytest.approx(
        math.hypot(0.1, 0.3) / math.sqrt(2.0), rel=0.01
    )


@pytest.mark.parametrize("repetitions", [2, 3, 5])
@pytest.mark.parametrize("between", [0.0, 1.0, 4.0])
def test_the_mean_of_few_repetitions_holds_its_truth(repetitions: int, between: float) -> None:
    """With a scatter of `between` among them beside their own noise of 1."""
    random = np.random.default_rng(repetitions)
    values = math.hypot(1.0, between) * random.standard_normal((400, repetitions))
    names = [case.name for case in cases(_plan(repetitions))[:repetitions]]
    each = Uncertainty(1.0, "noise", 20.0)
    held = 0
    for row in values:
        measured = {
            name: (Measurement("torque_mean", value, "Nm", "mean", uncertainty=each),)
            for name, value in zip(names, row, strict=True)
        }
        (found,), *_ = over_repetitions(_plan(repetitions), measured).values()
        assert found.uncertainty is not None
        held += abs(found.mean) <= found.uncertainty.expanded
    assert 0.88 < held / len(values) <= 1.0


def _three(*values: float, **each: object) -> Repeated:
    measured = {
        case.name: (Measurement("torque_mean", value, "Nm", "mean", **each),)  # type: ignore[arg-type]
        for case, value in zip(cases(_plan(3))[:3], values, strict=True)
    }
    (found,), *_ = over_repetitions(_plan(3), measured).values()
    return found


def test_equal_numbers_tell_no_uncertainty_but_that_of_one() -> None:
    """They had U = 0 and a probability of conformance of 1: a THD less its noise that is 0 three times."""
    found = _three(1.0, 1.0, 1.0)
    assert found.uncertainty is None
    assert math.isnan(found.combined)
    assert found.to_json()["uncertainty_reason"] == "3 repetitions read the same, so that no scatter tells"
    one = Uncertainty(0.1, "test")
    assert _three(0.0, 0.0, 0.0, uncertainty=one).uncertainty == one


def test_the_mean_has_the_sensors_of_repetitions_without_an_uncertainty_from_their_data() -> None:
    gain = Contribution("gain", "B", 0.2, instrument=InstrumentError("gain", "torque"))
    steps = Contribution("resolution", "B", 0.1)
    found = _three(1.0, 1.03, 1.06, of_sensors=(gain, steps))
    assert found.uncertainty is not None
    assert found.uncertainty.experimental == pytest.approx(math.sqrt(0.2**2 + 0.1**2 + 0.03**2 / 3.0))
    lag = Contribution("bandwidth of 100 Hz", "B", math.nan)
    unknown = _three(1.0, 1.1, 1.3, of_sensors=(gain, lag))
    assert unknown.uncertainty is None
    assert unknown.uncertainty_reason == "not known of its sensors: bandwidth of 100 Hz"


@pytest.mark.parametrize(
    ("judge", "bounds", "verdict"),
    [
        ("mean", (1.0, 2.0), Verdict.PASS),
        ("worst", (1.0, 2.0), Verdict.UNDECIDED),
        ("worst", (1.0, 1.5), Verdict.PASS),
        ("mean", (1.0, None), Verdict.FAIL),
    ],
)
def test_repetitions_without_a_line_are_judged_by_the_noise_that_hides_it(
    judge: str, bounds: tuple[float | None, ...], verdict: Verdict
) -> None:
    plan = _plan(2).model_copy(
        update={"judge": judge, "limits": {"torque_mean": Limit(max=1.8)}, "sweep": Sweep()}
    )
    hidden = Measurement.undefined("torque_mean", "Nm", "", "no line stands out of the noise")
    measured = {
        case.name: (replace(hidden, below=below),) for case, below in zip(cases(plan), bounds, strict=True)
    }
    ((together,),) = over_repetitions(plan, measured).values()
    assert together.judged is not None
    assert together.judged.verdict is verdict
