"""What a line makes of bins, and the search over distances of two lines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.lines import line_models
from benchtool.analysis.lines.close_distances import likely_fits
from benchtool.analysis.spectra import interharmonics

Floats = NDArray[np.float64]
COUNT = 64
PLACES = [10.3, 11.0, 12.5, 13.0 + 1e-7, 63.9]


@pytest.mark.parametrize("place", PLACES)
def test_a_line_makes_of_the_bins_of_whole_periods_what_a_transform_does(place: float) -> None:
    turns = np.exp(2j * np.pi * place * np.arange(COUNT) / COUNT)
    expected = np.fft.fft(turns) / COUNT
    found = interharmonics.dirichlet_kernel(place, np.arange(COUNT), COUNT)
    assert np.max(np.abs(found - expected)) < 1e-13


@pytest.mark.parametrize("place", PLACES)
def test_a_line_is_real_in_the_bins_of_a_hann_window_in_the_middle_of_the_record(place: float) -> None:
    at = (np.arange(COUNT) + 1.0) / COUNT - 0.5
    apart = place - np.arange(float(COUNT))
    expected = np.exp(2j * np.pi * np.outer(apart, at)) @ (1.0 + np.cos(2.0 * np.pi * at)) / COUNT
    assert np.max(np.abs(line_models.hann_kernel(apart, COUNT) - expected)) < 1e-13


@dataclass(frozen=True)
class _Fits:
    apart: Floats
    likely: Floats


@pytest.mark.parametrize(
    ("width", "passes", "last"), [(1e-3, 3, 0.62), (10.0, 1, 1.6)], ids=["sharp", "anywhere"]
)
def test_ever_fewer_distances_are_looked_at_until_all_are_likely(
    width: float, passes: int, last: float
) -> None:
    asked: list[tuple[float, float]] = []

    def fitted(begin: float, end: float) -> _Fits:
        asked.append((begin, end))
        apart = np.linspace(begin, end, 41)
        return _Fits(apart, -(((apart - 0.6) / width) ** 2))

    found = likely_fits(fitted, 0.0, 1.6)
    assert len(asked) == passes
    assert found.apart[0] <= 0.6 <= found.apart[-1] <= last
