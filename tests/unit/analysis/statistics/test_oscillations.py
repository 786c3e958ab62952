"""The mean of a record that holds oscillations, against that of lines of known cycles."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.statistics.oscillations import mean_moved_by_oscillations
from benchtool.analysis.statistics.scatter import error_of_record

ROWS, LOWEST = 1500, 5


def line(cycles: float, begin: float) -> np.ndarray:
    return np.sin(2.0 * np.pi * (cycles * np.arange(ROWS) / ROWS + begin))


@pytest.mark.parametrize("cycles", [6.5, 17.5, 23.2, 40.05, 133.3])
@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_it_is_the_scatter_of_the_means_of_records_that_begin_anywhere(cycles: float, noise: float) -> None:
    random, begins = np.random.default_rng(1), np.arange(0.025, 1.0, 0.05)
    scatter = float(np.std([np.mean(line(cycles, begin)) for begin in begins]))
    for begin in begins[::4]:
        record = line(cycles, begin) + noise * random.standard_normal(ROWS)
        assert mean_moved_by_oscillations(record, LOWEST) == pytest.approx(scatter, rel=0.1 + 3.0 * noise)


def test_whole_cycles_move_no_mean_wherever_they_begin() -> None:
    """Also where noise has a maximum beside the line."""
    random, found, stated = np.random.default_rng(2), [], []
    for begin in np.arange(0.0, 1.0, 0.1):
        record = line(40.0, begin) + 1e-3 * random.standard_normal(ROWS)
        found.append(mean_moved_by_oscillations(record, LOWEST))
        stated.append(error_of_record(record).standard)
    assert max(found) < 1e-5
    assert 0.5e-3 < float(np.median(stated)) * np.sqrt(ROWS) < 2e-3


def test_of_noise_any_part_of_a_cycle_is_as_likely() -> None:
    noise = np.random.default_rng(3).standard_normal((20, ROWS))
    found = [mean_moved_by_oscillations(each, LOWEST) for each in noise]
    # the density 1 / n of each bin, times the sum of 1 / (pi k)^2 from the lowest on
    expected = np.sqrt(np.sum(1.0 / np.arange(LOWEST, ROWS // 2) ** 2) / np.pi**2 / ROWS)
    assert float(np.sqrt(np.mean(np.square(found)))) == pytest.approx(expected, rel=0.15)


def test_of_two_lines_each_has_its_own_cycles() -> None:
    record = line(40.0, 0.2) + 0.1 * line(60.5, 0.4)
    assert mean_moved_by_oscillations(record, LOWEST) == pytest.approx(
        0.1 / np.sqrt(2.0) / (np.pi * 60.5), rel=0.05
    )
