"""Where a machine ran: the mean of what was recorded there, with its uncertainty."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from benchtool.block import Block
from benchtool.plan.operating_point import measure_held


def test_the_scatter_over_parts_has_their_degrees_of_freedom() -> None:
    """100 values are 50 parts, whose mean is that of all; k is Student's for about as many."""
    speed = 100.0 + np.random.default_rng(3).normal(size=100)
    (found,) = measure_held(Block.from_arrays(1e3, {"omega_m": "rad/s"}, omega_m=speed))
    assert found.uncertainty is not None
    assert found.uncertainty.standard == pytest.approx(0.1, rel=0.3)
    assert 10.0 < found.uncertainty.dof < 60.0
    factor = stats.t.ppf(0.975, found.uncertainty.dof)
    assert found.uncertainty.expanded == pytest.approx(factor * found.uncertainty.experimental)
    assert found.uncertainty.experimental < found.uncertainty.standard
    assert math.isfinite(found.uncertainty.expanded)
