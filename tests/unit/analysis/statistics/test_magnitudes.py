"""Magnitudes and roots of powers of which noise may be all."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.statistics.magnitudes import added_by_noise, standard_of_root


@pytest.mark.parametrize("size", [0.0, 1.0, 2.0, 4.0, 8.0])
def test_a_magnitude_in_noise_is_within_two_standard_uncertainties(size: float) -> None:
    random = np.random.default_rng(3)
    found = np.abs(size + random.standard_normal(4000) + 1j * random.standard_normal(4000))
    standard = np.array([math.hypot(1.0, added_by_noise(each, 1.0)) for each in found])
    relative = (found - size) / standard
    assert float(np.mean(np.abs(relative) < 2.0)) > 0.94
    assert 0.7 < float(np.sqrt(np.mean(relative**2))) < 1.2


def test_a_noise_that_is_not_known_adds_nothing() -> None:
    assert added_by_noise(2.0, math.nan) == 0.0


def test_of_a_root_far_above_zero_the_deviation_is_propagated_and_at_zero_its_root() -> None:
    assert standard_of_root(4.0, 0.01) == pytest.approx(0.0025, rel=0.05)
    assert standard_of_root(0.0, 0.02) == pytest.approx(0.1, rel=0.05)
    assert standard_of_root(0.0, 0.0) == 0.0
