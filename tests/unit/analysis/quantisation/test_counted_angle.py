"""A speed that is a difference of counts is told by these, and how far they make it off."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.counted_angle import CountedAngle, counted_angle
from tests.unit.analysis.quantisation.counted_shaft import RATE_HZ, Shaft, difference


def told(angle_rad: np.ndarray, speed: np.ndarray, kept: np.ndarray | None = None) -> CountedAngle | None:
    """Return the counts of rows of an angle, all of them or those `kept`."""
    rows = np.arange(len(speed), dtype=np.float64)
    kept = np.ones(len(speed), dtype=np.bool_) if kept is None else kept
    return counted_angle(angle_rad[kept], speed[kept], rows[kept], RATE_HZ)


@pytest.mark.parametrize("rows", [1, 2, 8, 16])
@pytest.mark.parametrize("has_gap", [False, True])
def test_what_rounding_adds_to_each_row_is_told(rows: int, has_gap: bool) -> None:
    shaft = Shaft()
    angle_rad = shaft.angle_rad(np.random.default_rng(1))
    read_rad = shaft.read_rad(angle_rad)
    kept = np.ones(len(angle_rad) - rows, dtype=np.bool_)
    kept[4000:5500] = not has_gap
    counted = told(read_rad[rows:], difference(read_rad, rows), kept)
    assert counted is not None
    assert counted.rows == rows
    assert counted.step == pytest.approx(shaft.count_rad * RATE_HZ / rows)
    added = (difference(read_rad, rows) - difference(angle_rad, rows))[kept]
    assert np.sqrt(np.mean((counted.added() - added) ** 2)) < 0.1 * np.std(added)


def test_a_difference_is_told_where_it_is_written_beside_another_row() -> None:
    """Of rows to both sides of each, and of some before it."""
    shaft = Shaft()
    angle_rad = shaft.angle_rad(np.random.default_rng(2))
    read_rad = shaft.read_rad(angle_rad)
    for before, behind in ((1, 1), (9, -3)):
        rows, all_rows = before + behind, np.arange(20, len(angle_rad) - 20)
        speeds = [
            (each[all_rows + behind] - each[all_rows - before]) * (RATE_HZ / rows)
            for each in (read_rad, angle_rad)
        ]
        counted = told(read_rad[all_rows], speeds[0])
        assert counted is not None
        assert counted.rows == rows
        assert np.std(counted.added() - (speeds[0] - speeds[1])) < 0.1 * counted.step


@pytest.mark.parametrize("rows", [1, 8])
def test_numbers_of_32_bits_are_told_as_well(rows: int) -> None:
    shaft = Shaft()
    read = np.mod(shaft.read_rad(shaft.angle_rad(np.random.default_rng(3))), 2.0 * np.pi).astype(np.float32)
    unwrapped = np.unwrap(read).astype(np.float32)
    speed = (unwrapped[rows:] - unwrapped[:-rows]) * np.float32(RATE_HZ / rows)
    counted = told(np.unwrap(read.astype(np.float64))[rows:], speed.astype(np.float64))
    assert counted is not None
    assert counted.rows == rows


def test_what_rounding_may_add_has_the_power_that_other_beginnings_of_the_counts_give() -> None:
    shaft, rows, orders = Shaft(counts=4096), 4, np.arange(1, 60)
    angle_rad = shaft.angle_rad(np.random.default_rng(4))
    turns = np.exp(-1j * np.outer(orders, angle_rad[rows:])) / len(angle_rad)
    made = []
    for begins in np.random.default_rng(5).uniform(0.0, shaft.count_rad, 100):
        read_rad = shaft.read_rad(angle_rad + begins)
        made.append(turns @ (difference(read_rad, rows) - difference(angle_rad, rows)))
    read_rad = shaft.read_rad(angle_rad)
    counted = told(read_rad[rows:], difference(read_rad, rows))
    assert counted is not None
    found = np.concatenate([each @ turns.T for each in counted.may_add()])
    power, predicted = (np.mean(np.abs(each) ** 2, axis=0) for each in (np.array(made), found))
    for band in np.array_split(np.arange(len(orders)), 4):
        assert np.mean(predicted[band]) == pytest.approx(np.mean(power[band]), rel=0.25)


def test_a_speed_that_is_no_difference_of_the_counts_is_not_taken_for_one() -> None:
    random, shaft = np.random.default_rng(6), Shaft()
    angle_rad = shaft.angle_rad(random)
    read_rad, speed = shaft.read_rad(angle_rad), difference(angle_rad, 8)
    step = 0.37 * shaft.count_rad * RATE_HZ
    assert told(read_rad[8:], speed) is None
    assert told(read_rad[8:], step * np.round(speed / step)) is None
    assert told(angle_rad[8:], difference(read_rad, 8)) is None
    assert told(read_rad[8:], difference(read_rad, 8) + 0.3 * random.standard_normal(len(speed))) is None
