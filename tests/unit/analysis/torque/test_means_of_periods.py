"""Means of a series over what repeats in it."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.torque.means_of_periods import Periods, mean_over_periods


@pytest.mark.parametrize("offset", [-10.0, 10.0])
def test_a_course_is_one_of_a_mean_of_either_sign(offset: float) -> None:
    random, number = np.random.default_rng(1), np.arange(4000.0)
    series = offset + np.exp(-number / 1500.0) + 1e-3 * random.standard_normal(len(number))
    found = mean_over_periods(series, Periods(np.arange(0, 4001, 100)))
    assert found.course is not None
    assert found.mean == pytest.approx(float(np.mean(series)))


@pytest.mark.parametrize("growth", [-0.1, 0.1])
def test_the_mean_is_over_the_angle_where_the_speed_drifts(growth: float) -> None:
    """Of a sine, 0 over whole periods of the angle; over the time of 40 whole ones it is 4e-4."""
    number = np.arange(6000.0)
    share = number / len(number)
    turns = 40.3 * (share + 0.5 * growth * share**2) / (1.0 + 0.5 * growth)
    marks = np.interp(np.arange(41), turns, number)
    rows = np.ceil(marks - 1e-6).astype(np.int64)
    series = -np.sin(2 * np.pi * turns)
    whole = float(np.mean(series[: rows[-1]]))
    assert abs(whole) > 3e-4
    assert abs(mean_over_periods(series, Periods(rows, marks=marks)).mean) < 0.2 * abs(whole)


def test_places_go_on_behind_the_last_period_at_its_pace() -> None:
    repeats = Periods(np.array([0, 4, 10, 14]))
    expected = [0.125, 0.375, 0.625, 0.875, *(1.0 + (np.arange(6) + 0.5) / 6), 2.125, 2.375, 2.625, 2.875]
    assert repeats.places(14) == pytest.approx(np.array(expected) / 3.0)
    assert repeats.places(5) == pytest.approx(np.array(expected[:5]) / 3.0)
    assert repeats.places(17)[14:] == pytest.approx(np.array([3.125, 3.375, 3.625]) / 3.0)
