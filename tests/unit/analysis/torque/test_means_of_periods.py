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


def test_incomplete_revolutions_move_no_mean_by_where_rows_round() -> None:
    """Orders 1 and 2 of 3.07 revolutions of four periods each, whose beginnings are between rows."""
    errors = []
    for per_period in np.linspace(59.3, 63.1, 12):
        turned = 2 * np.pi * np.arange(int(12.3 * per_period)) / per_period
        series = 0.06 * np.cos(turned / 4.0) + 0.03 * np.cos(0.5 * turned + 1.0) + 0.04 * np.cos(6.0 * turned)
        marks = per_period * np.arange(13.0)
        rows = np.ceil(marks - 1e-6).astype(np.int64)
        errors.append(mean_over_periods(series, Periods(rows, per_revolution=4, marks=marks)).mean)
    assert float(np.max(np.abs(errors))) < 3e-5  # 4e-4 by places of rounded rows


def test_rows_are_in_their_periods_where_the_marks_are() -> None:
    marks = np.array([0.0, 3.5, 8.0])
    repeats = Periods(np.array([0, 4, 8]), marks=marks)
    expected = [0.0, 1.0, 2.0, 3.0, 3.5 + 0.5 * 3.5 / 4.5]
    assert repeats.places(5) == pytest.approx(np.array(expected) / 7.0)
    assert repeats.places(10)[8:] == pytest.approx(1.0 + np.array([0.0, 1.0]) / 9.0)
