"""Distributions and lengths of transforms against scipy's, which come from other formulas."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import fft, special

from benchtool.analysis.distributions import fisher_above, normal_below, student_below, student_quantile
from benchtool.analysis.fast_lengths import next_fast_length, previous_fast_length

DOF = (1.0, 1.01, 1.5, 2.0, 2.7, 4.0, 10.0, 33.3, 254.8, 9999.0, 1e4, 1e6, 1e9, 1e12)


@pytest.mark.parametrize("dof", DOF)
def test_students_quantile(dof: float) -> None:
    for probability in (0.6, 0.84, 0.975, 0.995):
        assert student_quantile(dof, probability) == pytest.approx(
            special.stdtrit(dof, probability), rel=1e-12
        )


@given(st.floats(0.0, 7.0).map(lambda x: 10.0**x), st.floats(-40.0, 40.0))
def test_students_distribution(dof: float, t: float) -> None:
    assert student_below(dof, t) == pytest.approx(special.stdtr(dof, t), abs=1e-12)


@given(st.floats(-1.0, 5.0), st.floats(-0.5, 6.0), st.floats(-3.0, 3.0))
def test_fishers_distribution(one: float, other: float, deviation: float) -> None:
    dof, below = 10.0**one, 10.0**other
    ratio = math.exp(deviation / math.sqrt(min(dof, below)))
    # 1e-10: the tail far out is the exponential of a logarithm of some 1e6
    assert fisher_above(dof, below, ratio) == pytest.approx(special.fdtrc(dof, below, ratio), abs=1e-10)


def test_ends_of_the_distributions() -> None:
    assert student_below(3.0, math.inf) == 1.0
    assert student_below(3.0, -math.inf) == 0.0
    assert normal_below(math.inf) == 1.0
    assert fisher_above(2.0, 4.0, 0.0) == 1.0
    assert fisher_above(2.0, 4.0, math.inf) == 0.0


def test_normal_distribution() -> None:
    for x in np.linspace(-8.0, 8.0, 33):
        assert normal_below(float(x)) == pytest.approx(special.ndtr(x), rel=1e-13)


def test_lengths_of_transforms() -> None:
    random = np.random.default_rng(1)
    for count in [*range(1, 300), *random.integers(300, 10**7, 100).tolist()]:
        assert next_fast_length(count) == fft.next_fast_len(count, real=True)
        assert previous_fast_length(count) == fft.prev_fast_len(count)
