"""The drift of an output while its input goes from rest to rest."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis.responses.drift_between_rests import drift_between_rests

Floats = NDArray[np.float64]

_COUNT = 20_000
_TIME = np.linspace(0.0, 1.0, _COUNT)


def _input(rest: int) -> Floats:
    x = np.zeros(_COUNT)
    x[rest:-rest] = np.sin(np.arange(_COUNT - 2 * rest))
    return x


def _left(course: Floats, seed: int, rest: int = 1000) -> tuple[Floats, Floats]:
    """Return what is left of a drift, and its standard uncertainty, less that at the first row, both (n,)."""
    x = _input(rest)
    random = np.random.default_rng(seed)
    found = drift_between_rests(x, x + course + 0.01 * random.standard_normal(_COUNT))
    left = course - found.course
    doubts = found.doubts - found.doubts[:, :1]
    return left - left[0], np.sqrt(np.sum(doubts**2, axis=0))


def test_a_parabola_is_taken_off() -> None:
    middle = _COUNT // 2
    missed = []
    for seed in range(40):
        left, standard = _left(0.5 * _TIME**2, seed)
        missed.append(left[middle] / standard[middle])
        assert standard[middle] < 0.02
    assert 0.6 < float(np.sqrt(np.mean(np.square(missed)))) < 1.4


def test_short_rests_leave_a_bend_as_large_as_the_drift_open() -> None:
    left, standard = _left(0.5 * _TIME**2, 1, rest=240)
    assert 0.05 < standard[_COUNT // 2] < 0.2
    assert abs(left[_COUNT // 2]) < 2.0 * standard[_COUNT // 2]


def test_no_drift_is_none() -> None:
    for seed in range(20):
        x = _input(1000)
        noise = 0.01 * np.random.default_rng(seed).standard_normal(_COUNT)
        found = drift_between_rests(x, x + noise)
        if not len(found.doubts):
            assert not np.any(found.course)
    assert not len(drift_between_rests(_input(1000), _input(1000)).doubts)


def test_a_line_without_noise_is_taken_off_exactly() -> None:
    x, line = _input(1000), 0.3 * (_TIME - 0.5)
    found = drift_between_rests(x, x + line)
    np.testing.assert_allclose(found.course, line, atol=1e-7)


def test_rests_of_five_rows_tell_no_drift() -> None:
    x = np.zeros(400)
    x[5:-10] = np.sin(np.arange(385))
    drift = np.linspace(0.0, 10.0, 400)
    assert not len(drift_between_rests(x, x + drift).doubts)


def test_an_input_that_hardly_moves_is_at_rest() -> None:
    x, drift = _input(1000), 0.5 * _TIME**2 + 0.01 * np.random.default_rng(2).standard_normal(_COUNT)
    creeping = x.copy()
    creeping[500:1000] += 0.8e-3 * float(np.std(x))
    still, moved = (drift_between_rests(each, x + drift) for each in (x, creeping))
    np.testing.assert_array_equal(still.course, moved.course)


_FEW = np.linspace(0.0, 1.0, 2000)


def _between(begin: int, end: int) -> Floats:
    """Return an input that leaves its rest downwards, after so many rows, and is at rest for the last."""
    x = np.zeros(len(_FEW))
    x[begin : len(x) - end] = -np.hanning(len(x) - begin - end + 2)[1:-1]
    x[begin] = x[len(x) - end - 1] = -0.1
    return x


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize(("begin", "end"), [(300, 120), (100, 500), (16, 32)])
def test_a_line_of_either_sign_is_taken_off_between_unequal_rests(sign: float, begin: int, end: int) -> None:
    line = sign * 0.3 * (_FEW - 0.5)
    # blocks of two rows each hold a whole ripple of them
    ripple = 0.1 * np.resize([1.0, -1.0], len(line)) if begin == 16 else 0.0
    x = _between(begin, end)
    for each in (x, -x):
        np.testing.assert_allclose(drift_between_rests(each, each + line + ripple).course, line, atol=1e-6)


def test_four_blocks_of_two_rows_at_each_end_are_the_fewest() -> None:
    line = 0.3 * (_FEW - 0.5)
    for end, rows in ((16, 3), (12, 0)):
        x = _between(8, end)
        assert len(drift_between_rests(x, x + line).doubts) == rows


def test_an_input_that_never_moves_has_no_rests() -> None:
    found = drift_between_rests(np.ones(len(_FEW)), 5.0 * _FEW)
    assert not len(found.doubts)
    assert not np.any(found.course)


def test_a_drift_of_several_deviations_is_found_and_one_of_few_is_not() -> None:
    x = _between(400, 400)
    noise = [0.01 * np.random.default_rng(seed).standard_normal(len(x)) for seed in range(20)]
    for drift, fewest, most in ((0.0, 0, 0), (0.003, 0, 6), (0.018, 19, 20)):
        found = [len(drift_between_rests(x, x + each + drift * _FEW).doubts) > 0 for each in noise]
        assert fewest <= sum(found) <= most


def test_short_rests_bend_a_line_by_no_more_than_it_goes() -> None:
    x, line = _between(30, 60), 0.3 * (_FEW - 0.5)
    for seed in range(20):
        noise = 0.01 * np.random.default_rng(seed).standard_normal(len(x))
        assert np.max(np.abs(drift_between_rests(x, x + line + noise).course - line)) < 0.15
