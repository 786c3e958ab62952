"""Measurements in JSON."""

from __future__ import annotations

import json
import math
from typing import Any

import pytest

from benchtool.analysis import Measurement, measurements_from_json, measurements_to_json
from benchtool.errors import AnalysisError


def test_measurements_survive_json() -> None:
    written = (
        Measurement("torque_ripple_pp", 0.06, "Nm", "maximum minus minimum"),
        Measurement("torque_mean", -0.65, "Nm", "mean"),
    )

    document = json.loads(json.dumps(measurements_to_json(written), allow_nan=False))

    assert document["torque_ripple_pp"] == {
        "value": 0.06,
        "unit": "Nm",
        "definition": "maximum minus minimum",
    }
    assert measurements_from_json(document) == written


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_json_never_holds_a_number_that_is_none(value: float) -> None:
    document = measurements_to_json([Measurement("thd", value, "%", "ratio")])

    assert document["thd"]["value"] is None


def test_an_undefined_measurement_says_why() -> None:
    undefined = Measurement.undefined("thd", "%", "ratio of harmonics", "the fundamental is zero")

    assert math.isnan(undefined.value)
    assert undefined.definition == "ratio of harmonics; undefined here: the fundamental is zero"
    (read,) = measurements_from_json(measurements_to_json([undefined]))
    assert math.isnan(read.value)
    assert read.definition == undefined.definition


@pytest.mark.parametrize(
    "entry", [{}, 3, None, {"value": "3", "unit": "A", "definition": ""}, {"value": 1.0, "unit": 1}]
)
def test_a_malformed_measurement_is_refused_by_name(entry: Any) -> None:
    with pytest.raises(AnalysisError, match="measurement 'torque_mean' is"):
        measurements_from_json({"torque_mean": entry})
