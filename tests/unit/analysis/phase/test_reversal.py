"""A current that reverses near its greatest value, without an angle: no line beside a harmonic does that."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import current_spectrum, track_tone
from benchtool.block import Block
from tests.at_length import at_length


@pytest.mark.parametrize("seed", [0, *at_length(2)])
@pytest.mark.parametrize("phase_rad", [0.3, 4.5, *at_length(3.9, 5.7)])
@pytest.mark.parametrize("reverses", [True, False])
def test_harmonics_that_turn_are_no_lines_that_cancel(seed: int, phase_rad: float, reverses: bool) -> None:
    theta = 2.0 * np.pi * np.arange(3700) / 100.3 + 2.0
    at = int(np.searchsorted(theta, 50.0 * np.pi))
    phase = np.where(np.arange(len(theta)) < at, theta, 2.0 * theta[at] - theta) if reverses else theta
    current = 5.0 * np.cos(phase) + 0.15 * np.cos(5.0 * phase + phase_rad)
    current += 0.1 * np.cos(7.0 * phase + phase_rad + 1.0)
    current += 0.02 * np.random.default_rng(seed).standard_normal(len(theta))
    block = Block.from_arrays(1e4, {"i_a": "A"}, i_a=current)
    found = current_spectrum(block, "i_a", track_tone(current, "i_a"))
    thd = next(each for each in found.measurements if each.name == "current_thd_f")
    if reverses:
        assert math.isnan(thd.value)
        assert "turns against the fundamental" in thd.reason
    else:
        assert thd.value == pytest.approx(100.0 * math.hypot(0.03, 0.02), rel=0.03)
