"""The slowest tail of an answer: when noise hides it, and whether samples at rest have it as well."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.steps.tails import Tail

AWAY = -0.05 * np.exp(-np.arange(1000.0) / 300.0)
TAIL = Tail.of(AWAY, 0.02)
REST, NOISE = 500, 2e-3


def test_a_tail_is_that_by_which_the_outer_half_of_the_band_is_left() -> None:
    assert TAIL.half == pytest.approx(300.0 * np.log(2.0), abs=1.0)
    assert TAIL.at == pytest.approx(300.0 * np.log(5.0), abs=1.0)
    assert TAIL.away == -0.01
    # a tenth of the noise is left where the tail is 250 times less than at its beginning
    assert TAIL.end(NOISE) == pytest.approx(300.0 * np.log(250.0), abs=5.0)


@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_a_tail_has_no_end_in_no_noise_and_in_more_than_itself(noise: float) -> None:
    assert TAIL.end(noise) == 0


def test_samples_have_the_tail_that_they_are_reached_by() -> None:
    random = np.random.default_rng(2)
    for _ in range(10):
        found = TAIL.goes_on_in(AWAY[REST:] + NOISE * random.standard_normal(1000 - REST), REST)
        assert found is not None
        assert float(np.max(np.abs(found - AWAY[REST:]))) < 4.0 * NOISE / np.sqrt(1000 - REST) * np.sqrt(6.0)


@pytest.mark.parametrize("size", [0.0, -1.0, 0.1, 4.0])
def test_another_course_is_not_the_tail(size: float) -> None:
    random = np.random.default_rng(3)
    for _ in range(10):
        assert TAIL.goes_on_in(size * AWAY[REST:] + NOISE * random.standard_normal(1000 - REST), REST) is None


def test_a_walk_is_mostly_not_the_tail() -> None:
    random = np.random.default_rng(4)
    walks = np.cumsum(2e-4 * random.standard_normal((20, 1000 - REST)), axis=1)
    found = [TAIL.goes_on_in(walk + NOISE * random.standard_normal(len(walk)), REST) for walk in walks]
    assert sum(each is not None for each in found) <= 5


def test_few_samples_and_those_before_it_do_not_tell() -> None:
    assert TAIL.goes_on_in(AWAY[990:], 990) is None
    assert TAIL.goes_on_in(AWAY[100:], 100) is None
