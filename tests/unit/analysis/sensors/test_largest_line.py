"""The largest line of a channel whose sensor takes more off faster ones."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest

from benchtool.block import Block
from benchtool.profile import Bench, Sensor
from benchtool.results import Calibration
from benchtool.results.block_result import BlockResult, analyze_block
from tests.unit.analysis.example_capture import EXAMPLE_MOTOR

_RATE_HZ, _FIRST_HZ = 10_000.0, 12.5

_NAMES = "torque_line_frequency", "torque_line_amplitude", "torque_order_largest_amplitude"


@cache
def _measured(second: float, bandwidth_Hz: float, tolerance_percent: float | None = None) -> BlockResult:
    """Orders 24 (300 Hz), 1, and 48 (600 Hz), `second` behind the sensor."""
    theta = 2.0 * np.pi * _FIRST_HZ * np.arange(10_000) / _RATE_HZ
    torque = 1.0 + np.cos(24 * theta) + second * np.cos(48 * theta + 1.0)
    torque += 1e-3 * np.random.default_rng(1).standard_normal(len(torque))
    block = Block.from_arrays(
        _RATE_HZ,
        {"torque": "Nm", "theta_m": "rad"},
        torque=torque,
        theta_m=np.mod(theta, 2.0 * np.pi),
    )
    sensor = Sensor(bandwidth_Hz=bandwidth_Hz, bandwidth_tolerance_percent=tolerance_percent)
    return analyze_block(block, EXAMPLE_MOTOR, calibration=Calibration(Bench(channels={"torque": sensor})))


@pytest.mark.parametrize("name", _NAMES)
@pytest.mark.parametrize("tolerance_percent", [None, 5.0])
def test_a_line_that_may_be_the_largest_before_the_sensor(name: str, tolerance_percent: float | None) -> None:
    """A lag of 1 kHz leaves 0.96 at 300 Hz and 0.86 at 600 Hz: read as 0.95 of it, it was more."""
    found = _measured(0.95, 1000.0, tolerance_percent)[name]
    assert math.isnan(found.value)
    assert "600 Hz may be the largest before the sensor" in found.reason
    clear = _measured(0.5, 1000.0, tolerance_percent)[name]
    assert math.isfinite(clear.value)
    assert clear.uncertainty is not None
    fast = _measured(0.95, 10_000.0)[name]
    assert fast.uncertainty is not None
