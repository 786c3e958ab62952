"""A speed by counts: its readings add up to a place that is off by one of them at most."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.counted_speed import (
    covariance_of_counts,
    is_counted,
    most_of_counts,
)

STEP = 0.25


def counted(per_row: float, rows: int, shake: float = 0.0) -> np.ndarray:
    """Return readings of a shaft that turns by so many counts in a row and shakes by some, rms."""
    random = np.random.default_rng(3)
    place = per_row * np.arange(rows + 1) + random.uniform() + shake * random.standard_normal(rows + 1)
    return np.asarray(STEP * np.diff(np.floor(place)))


def rounded(level: float, rows: int, noise: float) -> np.ndarray:
    """Return readings of a converter of a level under noise, both in steps."""
    return np.asarray(STEP * np.round(level + noise * np.random.default_rng(4).standard_normal(rows)))


@pytest.mark.parametrize("per_row", [0.3, 6.52, -71.7])
@pytest.mark.parametrize("shake", [0.0, 0.1])
def test_readings_of_a_turning_shaft_are_counted(per_row: float, shake: float) -> None:
    assert is_counted([counted(per_row, 200, shake)], STEP)


@pytest.mark.parametrize(("level", "noise"), [(6.5, 0.1), (6.3, 0.3), (6.0, 0.5), (6.4, 2.0)])
def test_readings_that_are_rounded_each_by_itself_are_not(level: float, noise: float) -> None:
    assert not is_counted([rounded(level, 400, noise)], STEP)


def test_what_does_not_tell_is_not_counted() -> None:
    still, whole, few = counted(0.0, 200), counted(7.0, 200), counted(0.5, 20)
    assert not any(is_counted([each], STEP) for each in (still, whole, few))
    assert not is_counted([], STEP)
    assert not is_counted([counted(6.5, 200)], 0.0)
    assert not is_counted([counted(6.5, 200) + 0.5 * STEP], STEP)  # of a converter with an offset


def test_every_piece_that_tells_has_to_be_counted() -> None:
    shaft, converter, still = counted(6.4, 200), rounded(6.5, 400, 0.3), counted(0.0, 200)
    assert is_counted([still, shaft], STEP)
    assert not is_counted([converter, shaft], STEP)


def test_what_counts_are_off_adds_up_to_no_more_than_that_of_one() -> None:
    at_zero, behind = covariance_of_counts(STEP)
    assert at_zero + 2.0 * behind == pytest.approx(0.0)
    speeds = np.random.default_rng(5).uniform(2.0, 90.0, 400)
    off = np.array([counted(each, 50) - STEP * each for each in speeds])
    assert np.mean(off**2) == pytest.approx(at_zero, rel=0.1)
    assert np.mean(off[:, 1:] * off[:, :-1]) == pytest.approx(behind, rel=0.15)
    assert np.max(np.std(off, axis=1)) <= most_of_counts(STEP)
