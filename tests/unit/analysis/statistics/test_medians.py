"""Medians of few values."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.statistics.medians import median, medians


@pytest.mark.parametrize("count", [1, 2, 3, 8, 61, 1770])
def test_it_is_that_of_numpy_and_leaves_the_values_where_they_are(count: int) -> None:
    values = np.random.default_rng(count).standard_normal(count)
    before = values.copy()
    assert median(values) == np.median(values)
    assert np.array_equal(values, before)


@pytest.mark.parametrize("count", [1, 2, 3, 8, 61])
def test_those_of_rows_are_that_of_each(count: int) -> None:
    rows = np.random.default_rng(count).standard_normal((5, count))
    assert medians(rows).tolist() == [median(each) for each in rows]
