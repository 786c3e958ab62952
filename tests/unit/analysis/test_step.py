"""Step responses against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from benchtool.analysis.step import analyze_step
from benchtool.block import Block, Channel
from benchtool.errors import AnalysisError

RATE_HZ = 10_000.0
CHANNELS = (Channel("torque", "Nm"), Channel("torque_reference", "Nm"))


def _block(y: NDArray[np.float64], r: NDArray[np.float64]) -> Block:
    return Block(CHANNELS, 0, 1, 1.0 / RATE_HZ, np.column_stack([y, r]))


def _measured(y: NDArray[np.float64], r: NDArray[np.float64]) -> dict[str, float]:
    response = analyze_step(_block(y, r), "torque", "torque_reference")
    return {each.name: each.value for each in response.measurements}


def _step(before: float, after: float, rows: int = 1000, at: int = 100) -> NDArray[np.float64]:
    return np.where(np.arange(rows) < at, before, after)


@given(st.floats(-5.0, 5.0), st.floats(0.5, 10.0), st.sampled_from([1.0, -1.0]))
def test_a_first_order_lag_in_either_direction(before: float, height: float, sign: float) -> None:
    tau_s = 2e-3
    r = _step(before, before + sign * height)
    since_s = np.maximum(0.0, np.arange(1000) - 100) / RATE_HZ
    found = _measured(before + sign * height * (1.0 - np.exp(-since_s / tau_s)), r)
    assert found["rise_time"] == pytest.approx(tau_s * math.log(9.0), rel=2e-3)
    assert found["reach_time"] == pytest.approx(tau_s * math.log(50.0), rel=2e-3)
    assert found["settling_time"] == pytest.approx(tau_s * math.log(50.0), abs=1.5 / RATE_HZ)
    assert found["overshoot"] == 0.0
    assert found["undershoot"] <= 0.02 * height * (1.0 + 1e-9)


def test_overshoot_of_a_second_order_system() -> None:
    zeta, omega = 0.4, 3000.0
    since_s = np.maximum(0.0, np.arange(2000) - 100) / RATE_HZ
    omega_d = omega * math.sqrt(1.0 - zeta**2)
    decay = np.exp(-zeta * omega * since_s)
    y = 1.0 - decay * (np.cos(omega_d * since_s) + zeta * omega / omega_d * np.sin(omega_d * since_s))
    found = _measured(3.0 * y, _step(0.0, 3.0, 2000))
    peak = math.exp(-zeta * math.pi / math.sqrt(1.0 - zeta**2))
    assert found["overshoot"] == pytest.approx(3.0 * peak, rel=2e-2)
    assert found["undershoot"] == pytest.approx(3.0 * peak**2, rel=5e-2)


def test_a_pulse_is_judged_by_its_plateau_and_by_its_end() -> None:
    rows = np.arange(1000)
    r = np.select([rows < 100, rows < 600], [0.0, 1.0], 0.2)
    y = r.copy()
    y[300] = 1.07
    y[650] = 0.05
    found = _measured(y, r)
    assert found["overshoot"] == pytest.approx(0.07)
    assert found["undershoot"] == pytest.approx(0.15)
    assert found["settling_time"] == pytest.approx(551 / RATE_HZ)


def test_what_is_not_reached_has_no_time_and_says_why() -> None:
    response = analyze_step(_block(0.5 * _step(0.0, 1.0), _step(0.0, 1.0)), "torque", "torque_reference")
    by_name = {each.name: each for each in response.measurements}
    for name in ("rise_time", "reach_time", "undershoot", "settling_time"):
        assert math.isnan(by_name[name].value)
        assert "undefined here" in by_name[name].definition


def test_without_a_step_there_is_no_response() -> None:
    noise = np.sin(np.arange(100.0))
    with pytest.raises(AnalysisError, match="'torque_reference' holds 1 over 100 samples, a step is needed"):
        analyze_step(_block(noise, np.ones(100)), "torque", "torque_reference")
