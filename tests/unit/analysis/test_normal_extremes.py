"""How much the largest of normal values scatters."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.normal_extremes import is_no_heavier_than_normal, scatter_of_largest_normal


@pytest.mark.parametrize("within", [1, 8, 100])
def test_largest_of_normal_values_scatters_as_stated(within: int) -> None:
    maxima = np.max(np.random.default_rng(4).standard_normal((400, 30, within)), axis=2)
    stated = np.array([scatter_of_largest_normal(each, 1.0) for each in maxima])
    assert np.sqrt(np.mean(stated**2)) == pytest.approx(np.std(np.max(maxima, axis=1)), rel=0.15)


def test_a_tail_heavier_than_normal_is_told_and_without_noise_the_maxima_stand_for_themselves() -> None:
    random = np.random.default_rng(5)
    assert is_no_heavier_than_normal(random.uniform(-1.0, 1.0, 20_000))
    assert not is_no_heavier_than_normal(random.laplace(size=20_000))
    assert not is_no_heavier_than_normal(np.zeros(10))
    assert scatter_of_largest_normal(np.array([1.0, 2.0, 3.0]), 0.0) == pytest.approx(1.0)
