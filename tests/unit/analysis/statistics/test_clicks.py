"""Clicks are told from a tail, and the largest of a random number of them."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.statistics.clicks import KnownClicks, clicks_apart


def test_clicks_of_one_size_are_apart_and_a_heavy_tail_or_levels_of_a_converter_are_not() -> None:
    random = np.random.default_rng(6)
    values = random.standard_normal(2000)
    values[::200] += 10.0 * random.choice([-1.0, 1.0], 10)
    found = clicks_apart(values)
    assert found is not None
    assert len(found.sizes) == 10
    assert found.probability > 0.9
    assert sum(clicks_apart(random.standard_t(3, 2000)) is not None for _ in range(100)) < 10
    assert clicks_apart(0.5 * np.round(random.standard_normal(2000) / 0.5), 0.5) is None


def test_the_largest_of_a_random_number_of_clicks_scatters_as_stated() -> None:
    random = np.random.default_rng(7)
    largest, stated = [], []
    for _ in range(200):
        values = random.standard_normal(1000)
        hit = random.random(1000) < 0.012
        values[hit] += 12.0
        largest.append(np.max(values))
        found = clicks_apart(values)
        stated.append(np.nan if found is None else found.scatter_of_largest(1.0))
    assert np.count_nonzero(np.isfinite(stated)) > 180
    assert np.sqrt(np.nanmean(np.square(stated))) == pytest.approx(np.std(largest), rel=0.3)


def test_clicks_beside_nothing_may_be_of_any_size() -> None:
    deviations = np.zeros(200)
    deviations[::17] = 1e20
    assert clicks_apart(deviations) is not None


def test_the_greatest_scatters_by_clicks_that_a_record_may_have_there() -> None:
    """Three clicks in 3000 rows, of which any number is in the last 1000, about a course that falls."""
    random, rows, count = np.random.default_rng(8), 3000, 1000
    course = np.exp(-np.arange(count) / 50.0)
    largest, stated = [], []
    for _ in range(300):
        noise = 0.01 * random.standard_normal(rows)
        hit = np.flatnonzero(random.random(rows) < 1e-3)
        heights = random.choice([-1.0, 1.0], len(hit)) * (2.0 + 0.2 * random.standard_normal(len(hit)))
        noise[hit] += heights
        values = course + noise[-count:]
        largest.append(np.max(values))
        known = KnownClicks(heights, hit - (rows - count), rows)
        if known.are_few:
            others = np.delete(values, known.places[known.places >= 0])
            stated.append(known.scatter_of_greatest(np.positive, course, others))
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(np.std(largest), rel=0.3)


def test_the_power_of_clicks_scatters_by_how_many_there_are() -> None:
    random, rows = np.random.default_rng(9), 2000
    sums, stated = [], []
    for _ in range(400):
        hit = np.flatnonzero(random.random(rows) < 2e-3)
        heights = 3.0 * random.standard_normal(len(hit))
        sums.append(np.sum(heights[hit >= rows // 2] ** 2))
        if len(hit):
            stated.append(KnownClicks(heights, hit, rows).scatter_of_sum_of_squares(rows // 2))
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(np.std(sums), rel=0.3)
