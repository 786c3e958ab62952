"""Windows: what is between two bins of a line under a Hann window."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.spectral_window import hann_response, line_at, spectral_window

COUNT = 4096


@pytest.mark.parametrize("apart", [0.0, 0.3, -0.5, 0.999_999, 1.0, -1.0, 1.000_001, 1.7])
def test_the_response_is_that_of_a_transformed_line(apart: float) -> None:
    window = spectral_window("hann", COUNT)
    middle = np.arange(COUNT) - COUNT / 2
    bins = np.sum(window * np.exp(2j * np.pi * apart * middle / COUNT)) / np.sum(window)
    assert float(hann_response(apart)) == pytest.approx(bins.real, abs=1e-6)


@pytest.mark.parametrize("apart", [0.0, 0.4, 1.0, 1.5])
def test_a_line_is_read_by_the_bins_beside_it_also_from_the_next(apart: float) -> None:
    place, size = line_at(np.array([float(hann_response(apart - k)) for k in (-1, 0, 1)]), 1)
    assert math.isclose(place, apart, abs_tol=1e-5)
    assert math.isclose(size, 1.0, rel_tol=1e-5)
