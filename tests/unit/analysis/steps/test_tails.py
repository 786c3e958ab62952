"""The slowest tail of an answer: when noise hides it, and whether samples at rest have it as well."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis import analyze_step
from benchtool.analysis.steps.smoothing import Noise
from benchtool.analysis.steps.tails import Tail, without_course
from benchtool.block import Block

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


RATE_HZ, ROWS, LAST, DECAY, TURN = 5000.0, 850, 125, 21.0, 56.2  # 1/s, rad/s


def test_an_answer_that_rings_in_the_last_rows_is_no_noise_of_them() -> None:
    random = np.random.default_rng(6)
    t = np.arange(ROWS) / RATE_HZ
    ringing = np.exp(-DECAY * t) * np.cos(TURN * t)
    for _ in range(10):
        before, noise = (2e-3 * random.standard_normal(count) for count in (400, ROWS))
        left = without_course(ringing + noise, LAST, before)
        assert left.shape == (LAST,)
        assert Noise.of(left).rms == pytest.approx(2e-3, rel=0.3)


@pytest.mark.parametrize("cycles", [0.3, 1.0, 3.0])
def test_a_ripple_that_stays_is_noise_of_the_last_rows(cycles: float) -> None:
    random = np.random.default_rng(7)
    turned = 2.0 * np.pi * cycles * np.arange(ROWS) / LAST
    ripple = 0.02 * np.cos(turned - turned[-1]) + 2e-3 * random.standard_normal(ROWS)
    assert np.array_equal(without_course(ripple, LAST, 2e-3 * random.standard_normal(400)), ripple[-LAST:])


def test_noise_that_only_the_last_rows_have_stays() -> None:
    random = np.random.default_rng(8)
    walk = np.cumsum(2e-3 * random.standard_normal(ROWS))
    for before in (np.zeros(400), 2e-3 * random.standard_normal(10), 2e-3 * random.standard_normal(400)):
        assert np.array_equal(without_course(walk, LAST, before), walk[-LAST:])


def test_an_overshoot_is_as_certain_in_a_record_that_ends_while_it_rings() -> None:
    random = np.random.default_rng(9)
    t = np.arange(400 + ROWS) / RATE_HZ - 0.08
    ringing = np.exp(-DECAY * t) * (np.cos(TURN * t) + DECAY / TURN * np.sin(TURN * t))
    played = np.where(t >= 0.0, 10.0, 0.0)
    errors, standards = [], []
    for _ in range(10):
        answer = np.where(t >= 0.0, 10.0 - 10.0 * ringing, 0.0) + 0.03 * random.standard_normal(len(t))
        block = Block.from_arrays(RATE_HZ, {"y": "Nm", "r": "Nm"}, y=answer, r=played)
        numbers = {each.name: each for each in analyze_step(block, "y", "r", held=True).measurements}
        found = numbers["overshoot"]
        assert found.uncertainty is not None
        errors.append(found.value - 10.0 * np.exp(-DECAY * np.pi / TURN))
        standards.append(found.uncertainty.standard)
    assert max(standards) < 0.03
    assert np.sqrt(np.mean(np.square(np.array(errors) / standards))) < 1.4
