"""The error of a mean by densities that are continued to zero frequency."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from benchtool.analysis.statistics.lowest_frequencies import slow_noise


def test_a_density_without_corner_that_rises_less_than_1_over_f_is_continued_to_zero() -> None:
    """Its power below any lowest frequency is finite: the variance is the integral of 2 sinc^2(f) f^-a."""
    count, exponent = 4096, 0.6
    number = np.arange(1, count // 2)
    bins = np.zeros(count // 2 + 1, dtype=complex)
    phases_rad = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, len(number))
    bins[1:-1] = number ** (-0.5 * exponent) * np.exp(1j * phases_rad)
    found = slow_noise(np.fft.irfft(bins * count, count))
    parts = (
        quad(lambda f: 2.0 * np.sinc(f) ** 2 * f**-exponent, each, each + 1.0, limit=200)[0]
        for each in range(30)
    )
    assert found is not None
    assert found.standard == pytest.approx(math.sqrt(sum(parts)), rel=0.1)
