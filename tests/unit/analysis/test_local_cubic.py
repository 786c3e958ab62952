"""Where values that no parabola follows pass a level, and how far off a cubic is there."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.dynamics.local_cubic import NEAREST, LocalCubic
from benchtool.analysis.dynamics.response_curve import ResponseCurve


@pytest.mark.parametrize("damping", [0.2, 0.35, 0.5, 0.8])
@pytest.mark.parametrize("noise", [1e-6, 1e-4, 1e-2])
def test_the_error_of_a_cubic_is_known_to_its_size(damping: float, noise: float) -> None:
    """-90 degrees of a resonance that exact lines show, wherever it is between them."""
    random = np.random.default_rng(5)
    missed = []
    for _ in range(100):
        corner_Hz = random.uniform(200.0, 240.0)
        frequency_Hz = np.geomspace(20.0, 900.0, 60)
        s = 1j * frequency_Hz / corner_Hz
        phase = np.angle(1.0 / (1.0 + 2.0 * damping * s + s**2))
        error = np.full(len(phase), noise)
        curve = ResponseCurve(
            frequency_Hz, phase + noise * random.standard_normal(len(phase)), error, math.pi / 2
        )
        found = curve.falls_to(-0.5 * math.pi)
        assert found is not None
        missed.append((found.frequency_Hz - corner_Hz) / found.standard_Hz)
    assert 0.6 < math.sqrt(float(np.mean(np.square(missed)))) < 1.3
    assert float(np.mean(np.abs(missed) < 2.0)) > 0.9


def test_a_cubic_passes_a_level_where_it_is() -> None:
    places = np.array([0.0, 0.01, -0.01, 0.02, -0.02, 0.03, -0.03])
    values = 3.0 - 40.0 * (places - 0.004) + 500.0 * (places - 0.004) ** 3
    cubic = LocalCubic.through(places, values, np.full(NEAREST, 1e12), 1.0)
    place, standard = cubic.zero(3.0, 0.0)
    assert place == pytest.approx(0.004, abs=1e-9)
    assert standard < 1e-7
    assert cubic.at_zero()[0] == pytest.approx(float(values[0]), rel=1e-9)
    assert math.isnan(cubic.zero(9.0, 0.0)[0])
    assert cubic.zero(3.0, 0.4)[1] == pytest.approx(0.01, rel=0.1)


@pytest.mark.parametrize("count", [2, 3, 4, 5, 6])
def test_few_values_are_followed_as_far_as_they_go(count: int) -> None:
    places = np.array([0.0, 0.01, -0.01, 0.02, -0.02, 0.03])[:count]
    cubic = LocalCubic.through(places, 1.0 - 2.0 * places, np.ones(count), 1.0)
    assert cubic.zero(1.0, 0.0)[0] == pytest.approx(0.0, abs=1e-9)
