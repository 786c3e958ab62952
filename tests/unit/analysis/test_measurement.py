"""Measurements in JSON."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest
from scipy import stats

from benchtool.analysis import (
    Basis,
    Contribution,
    Measurement,
    Uncertainty,
    measurements_from_json,
    measurements_to_json,
)
from benchtool.analysis.uncertainty import InstrumentError, combined, sure_of
from benchtool.errors import AnalysisError


def test_measurements_survive_json() -> None:
    written = (
        Measurement("torque_ripple_pp", 0.06, "Nm", "maximum minus minimum"),
        Measurement("torque_mean", -0.65, "Nm", "mean"),
        Measurement("torque_line_amplitude", 0.1, "Nm", "line", below=0.2),
    )

    document = json.loads(json.dumps(measurements_to_json(written), allow_nan=False))

    assert document["torque_ripple_pp"] == {
        "value": 0.06,
        "unit": "Nm",
        "definition": "maximum minus minimum",
    }
    assert measurements_from_json(document) == written


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_json_never_holds_nan_or_infinity(value: float) -> None:
    document = measurements_to_json([Measurement("thd", value, "%", "ratio")])

    assert document["thd"]["value"] is None


def test_an_undefined_measurement_says_why() -> None:
    undefined = Measurement.undefined("thd", "%", "ratio of harmonics", "the fundamental is zero")

    assert math.isnan(undefined.value)
    assert undefined.definition == "ratio of harmonics"
    (read,) = measurements_from_json(measurements_to_json([undefined]))
    assert math.isnan(read.value)
    assert (read.definition, read.reason) == ("ratio of harmonics", "the fundamental is zero")


def test_an_older_bundle_has_the_reason_behind_the_definition_and_no_budget() -> None:
    older = {"value": None, "unit": "%", "definition": "ratio; undefined here: the fundamental is zero"}
    (read,) = measurements_from_json({"thd": older})
    assert (read.definition, read.reason) == ("ratio", "the fundamental is zero")

    number = {
        "value": 1.0,
        "unit": "A",
        "definition": "",
        "uncertainty": {"standard": 0.1, "source": "noise"},
    }
    (read,) = measurements_from_json({"i": number})
    assert read.uncertainty == Uncertainty(0.1, "noise")


def test_an_uncertainty_survives_json_with_its_budget() -> None:
    budget = (Contribution("scatter", "A", 0.3, 4.0), Contribution("resolution", "B", 0.4))
    uncertain = combined(budget, "both")
    assert uncertain is not None
    number = Measurement("torque_mean", 1.0, "Nm", "mean", uncertainty=uncertain)
    document = json.loads(json.dumps(number.to_json(), allow_nan=False))

    assert document["uncertainty"]["standard"] == pytest.approx(0.5)
    # u^4 / (u_1^4 / 4), and the quantile of Student's distribution there
    assert document["uncertainty"]["dof"] == pytest.approx(0.0625 / 0.0081 * 4.0)
    assert document["uncertainty"]["k"] == pytest.approx(stats.t.ppf(0.975, 0.0625 / 0.0081 * 4.0))
    assert document["uncertainty"]["expanded"] == pytest.approx(0.5 * document["uncertainty"]["k"])
    assert document["uncertainty"]["budget"][1]["dof"] is None
    assert measurements_from_json({"torque_mean": document}) == (number,)


def test_what_is_not_known_makes_the_whole_unknown() -> None:
    assert combined([Contribution("noise", "A", math.nan), Contribution("step", "B", 1.0)], "") is None


@pytest.mark.parametrize(
    "entry", [{}, 3, None, {"value": "3", "unit": "A", "definition": ""}, {"value": 1.0, "unit": 1}]
)
def test_a_malformed_measurement_is_refused_by_name(entry: Any) -> None:
    with pytest.raises(AnalysisError, match="measurement 'torque_mean' is"):
        measurements_from_json({"torque_mean": entry})


def test_many_degrees_of_freedom_are_infinitely_many_and_the_others_have_twelve_digits() -> None:
    """10 of a part a thousandth of the whole are 10^13; two alike of 5 are 10, without a rounding."""
    tiny = combined([Contribution("a", "A", 1e-3, 10.0), Contribution("b", "B", 1.0)], "both")
    assert tiny is not None
    assert tiny.dof == math.inf
    assert tiny.to_json()["dof"] is None
    two = combined([Contribution("a", "A", 0.1, 5.0), Contribution("b", "A", 0.1, 5.0)], "both")
    assert two is not None
    assert two.dof == 10.0


def test_u_is_followed_from_what_is_stated() -> None:
    """k = 1.98 stood beside 18 degrees of freedom, of which Student's factor is 2.10."""
    lines = [Contribution("scatter", "A", 0.3, 5.0, of_student=True), Contribution("gain", "B", 0.1)]
    uncertainty = combined(lines, "scatter")
    assert uncertainty is not None
    stated = uncertainty.to_json()
    t, s = stated["student_factor"], stated["experimental"]
    assert t == pytest.approx(stats.t.ppf(0.975, stated["dof"]), rel=1e-6)
    assert s == pytest.approx(math.hypot(0.3 * math.sqrt(3.0 / 5.0), 0.1))
    assert stated["expanded"] == pytest.approx(t * s)
    assert stated["k"] == pytest.approx(stated["expanded"] / stated["standard"])
    derived = Uncertainty(0.3, "extremes", half_width=0.4).to_json()
    assert (derived["student_factor"], derived["expanded"]) == (None, 0.4)


@pytest.mark.parametrize(("dof", "stated"), [(88353.2650888, 88353.27), (16.03212345678, 16.03212)])
def test_degrees_of_freedom_have_no_digits_that_do_not_count(dof: float, stated: float) -> None:
    uncertainty = combined([Contribution("scatter", "A", 0.3, dof)], "scatter")
    assert uncertainty is not None
    assert uncertainty.dof == stated


@pytest.mark.parametrize(
    ("gain", "source"), [(0.1, "scatter, gain of torque"), (0.9, "gain of torque, scatter")]
)
def test_the_source_names_instruments_before_what_is_smaller(gain: float, source: str) -> None:
    """A mean was of its scatter, where gain and offset made all of its uncertainty."""
    error = Contribution(
        "gain of torque; U = 1 %, k = 2", "B", gain, instrument=InstrumentError("gain", "torque")
    )
    assert Uncertainty(0.3, "scatter").with_instruments([error, error]).source == source


def test_samples_are_a_whole_number_in_a_document() -> None:
    """9500.000000148917 samples were used, in whole periods."""
    assert json.dumps(Basis(samples=9500.000000148917, gaps=0).to_json()) == '{"samples": 9500, "gaps": 0}'


@pytest.mark.parametrize("sigmas", [3.0, 6.0])
@pytest.mark.parametrize("dof", [2.0, 9.0, math.inf])
def test_what_contradicts_is_as_unlikely_by_few_observations_as_by_many(sigmas: float, dof: float) -> None:
    unlikely = 2.0 * stats.norm.sf(sigmas)
    factor = sure_of(Uncertainty(0.1, "scatter", dof), sigmas) / 0.1
    assert 2.0 * stats.t.sf(factor, min(dof, 1e12)) == pytest.approx(unlikely, rel=1e-3)
    assert sure_of(None) == 0.0
