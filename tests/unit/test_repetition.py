"""Repetitions of a case, put together."""

from __future__ import annotations

import math

import pytest

from benchtool.analysis import Measurement
from benchtool.experiment.assessment import RunResult
from benchtool.experiment.plan import Plan
from benchtool.experiment.repetition import over_repetitions


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


def test_what_was_never_defined_is_null() -> None:
    measured = {f"u_s_V={u_s}.{n}": _measured(math.nan) for u_s in ("60", "81.65") for n in (1, 2)}
    document = RunResult((), over_repetitions(_plan(2), measured)).to_json()
    expected = {"mean": None, "standard_uncertainty": None, "n": 0, "unit": "Nm"}
    assert document["repeated"]["u_s_V=60"] == {"torque_mean": expected}


def test_one_repetition_says_nothing() -> None:
    assert over_repetitions(_plan(1), {}) == {}
    assert "repeated" not in RunResult(()).to_json()
