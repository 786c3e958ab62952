"""Peaks that a converter reads on one level."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis.steps.tops_on_levels import is_on_level, middle_of_level, read_back, rows_of_level


def test_the_peak_of_a_level_is_told_by_the_level_below() -> None:
    """Peaks that fall faster than they rise, and corners that fall at once, on steps of a twentieth."""
    random, missed = np.random.default_rng(8), []
    for number in range(200):
        place = 40.0 + random.uniform()
        at, ahead = np.arange(80.0) - place, random.uniform(5.0, 30.0)
        if number % 2:
            values = 1.0 - (at / 10.0) ** 2 * np.where(at < 0.0, 0.8, 1.0)
        else:
            values = 1.0 - np.where(at < 0.0, -at / ahead, at / 30.0)
        level = np.round((values + random.uniform(0.0, 0.05)) / 0.05)
        top = np.flatnonzero(level == np.max(level))
        found, standard = middle_of_level(level, int(top[0]))
        assert standard <= len(top) / math.sqrt(12.0)
        missed.append((found - place) / standard)
    assert 0.6 < float(np.sqrt(np.mean(np.square(missed)))) < 1.3


def test_a_level_without_one_below_it_on_both_sides_holds_its_peak_anywhere() -> None:
    for first, last in ((0, 3), (5, 8), (2, 5)):
        values = np.zeros(9)
        values[first : last + 1] = 1.0
        assert middle_of_level(values, first) == (0.5 * (first + last), 4.0 / math.sqrt(12.0))


def test_a_level_that_noise_reads_there_and_back_is_one_level() -> None:
    """A smooth peak on steps of 1 in noise of a seventh of one, of which rows at rest show nothing."""
    random, missed = np.random.default_rng(5), []
    for _ in range(200):
        place = 60.0 + random.uniform()
        at = np.arange(120.0) - place
        level = np.round(
            4.0 * np.cos(at / 20.0) + random.uniform(0.0, 1.0) + 0.15 * random.standard_normal(120)
        )
        found, standard = middle_of_level(level, int(np.argmax(level)))
        missed.append((found - place) / standard)
    assert 0.6 < float(np.sqrt(np.mean(np.square(missed)))) < 1.9


def test_rows_of_a_level_end_where_it_is_left_for_good() -> None:
    assert rows_of_level(np.array([0.0, 1, 2, 1, 2, 2, 2, 1, 2, 1, 0, 1, 2]), 2) == (2, 8)
    assert rows_of_level(np.array([0.0, 1, 2, 2, 1, 1, 1, 1, 2, 1]), 2) == (2, 3)
    assert rows_of_level(np.array([0.0, 1, 2, 2, 0, 2, 2]), 2) == (2, 3)


@pytest.mark.parametrize("noise", [0.02, 0.05, 0.15])
def test_few_rows_that_little_noise_reads_a_level_higher_are_not_the_peak(noise: float) -> None:
    """A smooth peak that ends just below a level in noise that steep flanks do not show."""
    random, rows, missed = np.random.default_rng(3), np.arange(200.0), []
    for _ in range(300):
        place = 100.0 + random.uniform()
        read = np.round(0.49 - (rows - place) ** 2 / 300.0 + noise * random.standard_normal(200))
        top = int(np.argmax(read))
        if np.count_nonzero(read == read[top]) <= 3:
            assert is_on_level(read, top)
            found, standard = middle_of_level(read, top)
            missed.append((found - place) / standard)
    assert len(missed) > 20
    assert 0.35 < float(np.sqrt(np.mean(np.square(missed)))) < 1.3


def test_a_peak_of_one_row_between_others_of_their_own_levels_is_in_that_row() -> None:
    assert not is_on_level(np.array([0.0, 1.0, 2.0, 4.0, 5.0, 4.0, 2.0, 1.0, 0.0]), 4)
    corner = np.round(10.0 - 0.12 * np.abs(np.arange(200.0) - 100.0) + 0.45)
    assert not is_on_level(np.where(np.arange(200) == 100, corner + 1.0, corner), 100)


def test_a_level_is_left_after_as_many_rows_as_noise_reads_on_it() -> None:
    """An answer that creeps over the edge of a level in noise that no row at rest shows."""
    random, rows, missed = np.random.default_rng(6), np.arange(300.0), []
    for _ in range(200):
        place = 150.0 + random.uniform()
        read = np.round(0.5 - 4.0 * np.tanh((rows - place) / 300.0) + 0.1 * random.standard_normal(300))
        last = int(np.flatnonzero(read == 1.0)[-1])
        again, zone = read_back(read, last)
        missed.append(np.array([last + 0.5 - place, last + 0.5 - again - place, math.hypot(1.0, zone)]))
    late, off, wide = np.array(missed).T
    assert np.mean(late) > 5.0
    assert abs(np.mean(off)) < 1.0
    assert 0.4 < float(np.sqrt(np.mean((off / (wide / math.sqrt(12.0))) ** 2))) < 1.4
    assert read_back(np.array([3.0, 2.0, 2.0, 1.0, 1.0]), 2) == (0, 0)
