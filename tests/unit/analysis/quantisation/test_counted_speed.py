"""A speed by counts: its readings add up to a place that is off by one of them at most."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.counted_speed import (
    covariance_of_counts,
    is_counted,
    most_of_counts,
    relative_to_rounding,
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


@pytest.mark.parametrize("rows", [1, 2, 5])
def test_what_one_reading_has_too_much_the_next_has_too_little(rows: int) -> None:
    """Errors of differences at each order, of a shaft that passes as many counts in every revolution, against
    those of a converter of the same steps."""
    random, rate_Hz, per_turn, turns, counts = np.random.default_rng(5), 1000.0, 500, 12, 4096
    count_rad = 2.0 * np.pi / counts
    step = count_rad * rate_Hz / rows
    orders = np.arange(1, per_turn // 2)
    swing = np.interp(np.arange(per_turn), np.linspace(0, per_turn, 33), random.uniform(0.0, 9.0, 33))
    each = counts / per_turn * np.arange(per_turn) + swing
    place = np.concatenate([counts * turn + each for turn in range(turns)])
    powers = []
    for offset in random.uniform(size=80):
        errors = np.floor(place + offset) - place - offset
        made = (errors[rows:] - errors[:-rows]) / rows * count_rad * rate_Hz
        powers.append(np.abs(np.fft.fft(made[:per_turn])[orders]) ** 2 / per_turn)
    angle_rad = np.asarray(np.floor(place) * count_rad)
    relative = relative_to_rounding(step, angle_rad, rate_Hz, float(per_turn), orders)
    power = np.mean(powers, axis=0) / (step**2 / 12.0)
    for band in np.array_split(np.arange(len(orders)), 4):
        assert np.mean(power[band]) == pytest.approx(np.mean(relative[band] ** 2), rel=0.25)
    # of other places in each revolution the rounding is noise
    unlike = relative_to_rounding(step, angle_rad, rate_Hz, per_turn + 0.4142, orders)
    assert np.max(unlike) < 0.2 * np.max(relative)


def test_readings_beside_an_angle_that_is_not_theirs_are_rounded_each_by_itself() -> None:
    angle_rad = np.cumsum(np.random.default_rng(6).uniform(0.0, 0.01, 5000))
    for step in (0.0, 0.2):
        assert np.all(relative_to_rounding(step, angle_rad, 1000.0, 100.0, np.arange(1, 9)) == 1.0)
