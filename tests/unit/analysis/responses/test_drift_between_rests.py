"""The drift of an output while its input goes from rest to rest."""

from __future__ import annotations

import numpy as np
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
