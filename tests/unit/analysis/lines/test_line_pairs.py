"""Two lines too close to be two maxima: what noise leaves open of the larger one."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.lines.line_models import hann_kernel
from benchtool.analysis.lines.line_pairs import Pair, pair_of

COUNT, PLACE, NOISE = 10_000, 1000.3, 0.03
NUMBER = np.arange(996, 1006)


def pairs(apart: float, second: complex) -> list[Pair]:
    """Return the pairs that are found in bins of a line of amplitude one and a `second` one beside it."""
    places, found = np.array([PLACE, PLACE + apart]), []
    for seed in range(30):
        random = np.random.default_rng(seed)
        noise = random.standard_normal(COUNT) * NOISE * np.sqrt(COUNT / 12.0)
        window = np.hanning(COUNT)
        bins = np.fft.rfft(noise * window)[NUMBER] * (2.0 / np.sum(window))
        line = hann_kernel(NUMBER[:, np.newaxis] - places, COUNT) @ np.array([1.0, second])
        found.append(pair_of(bins + line, NUMBER, COUNT, PLACE, NOISE))
    return found


def test_two_lines_that_nothing_tells_from_one_are_not_many_times_as_large() -> None:
    found = pairs(0.0, 0.0)
    assert max(each.of_amplitude for each in found) < 0.6
    assert max(each.of_place for each in found) < 0.6


@pytest.mark.parametrize(("apart", "second"), [(0.9, 0.4j), (-0.9, 0.4j), (1.45, 0.6), (0.5, -0.7)])
def test_the_larger_of_two_lines_is_within_its_uncertainty(apart: float, second: complex) -> None:
    found = pairs(apart, second)
    of_amplitude = np.array([(each.amplitude - 1.0) / each.of_amplitude for each in found])
    of_place = np.array([(each.place - PLACE) / each.of_place for each in found])
    for errors in (of_amplitude, of_place):
        assert 0.3 < np.sqrt(np.mean(errors**2)) < 1.6
        assert np.mean(np.abs(errors) < 2.0) > 0.85


def test_what_noise_leaves_beside_two_lines_is_by_chance_and_a_third_line_is_not() -> None:
    assert np.mean([each.by_chance > 0.05 for each in pairs(0.9, 0.4j)]) > 0.85
    places = np.array([PLACE, PLACE + 0.9, PLACE - 2.4])
    bins = hann_kernel(NUMBER[:, np.newaxis] - places, COUNT) @ np.array([1.0, 0.4j, 0.3])
    assert pair_of(bins, NUMBER, COUNT, PLACE, NOISE).by_chance < 1e-3
