"""Steps of a running machine: the stimulus is added to the setpoint, and the answer counts from there."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from benchtool.block import Block
from benchtool.plan import Plan
from benchtool.results.case_assessment import assess
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR

_RATE_HZ, _LAG_S, _BEGIN, _ROWS = 1000.0, 0.02, 100, 500


def _plan(quantity: str, signal: str, point: dict[str, object], amplitude: float) -> Plan:
    suffix = {"speed": "rad_s", "torque": "Nm"}[quantity]
    return Plan.model_validate(
        {
            "title": "step",
            "profile": "zhu2011",
            "operating_point": point,
            "record": {"duration_s": 0.5, "pretrigger_s": 0.1, "channels": [signal, "stimulus"]},
            "stimulus": {
                "quantity": quantity,
                "shape": "step",
                f"amplitude_{suffix}": amplitude,
                "duration_s": 1.0,
            },
            "analyses": {"steady": False, "step": {"signal": signal, "reference": "stimulus"}},
        }
    )


@pytest.mark.parametrize("setpoint", [0.0, 100.0, -100.0, 2.0])
@pytest.mark.parametrize("amplitude", [5.0, -5.0])
@pytest.mark.parametrize(("quantity", "signal"), [("speed", "omega_m"), ("torque", "torque")])
def test_the_answer_to_a_step_is_that_from_standstill(
    quantity: str, signal: str, setpoint: float, amplitude: float
) -> None:
    point: dict[str, object] = {"omega_m_rad_s": setpoint}
    if quantity == "torque":
        point = {"mode": "torque", "torque_Nm": setpoint, "hold_speed_rad_s": 10.0}
    played = np.repeat([0.0, amplitude], [_BEGIN, _ROWS - _BEGIN])
    t_s = np.maximum(0.0, np.arange(_ROWS) - _BEGIN) / _RATE_HZ
    noise = np.random.default_rng(1).normal(0.0, 0.001 * abs(amplitude), _ROWS)
    answer = setpoint + amplitude * (1.0 - np.exp(-t_s / _LAG_S)) + noise
    unit = {"speed": "rad/s", "torque": "Nm"}[quantity]
    block = Block.from_arrays(
        _RATE_HZ, {signal: unit, "stimulus": unit}, **{signal: answer, "stimulus": played}
    )
    plan = _plan(quantity, signal, point, amplitude)
    found = assess(plan, "", EXAMPLE_MOTOR, Path(), block, None).found
    rise = found["rise_time"]
    assert rise.uncertainty is not None
    assert abs(rise.value - _LAG_S * math.log(9.0)) < 2.0 * rise.uncertainty.expanded, rise
    assert rise.value == pytest.approx(_LAG_S * math.log(9.0), rel=0.05)
    assert found["overshoot_percent"].value < 0.5
    assert abs(found["plateau_mean"].value - setpoint - amplitude) < 0.02 * abs(amplitude)
