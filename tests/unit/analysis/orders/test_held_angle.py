"""An angle that stands still: because the rotor does, or because the encoder or its link was lost."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis import order_analysis
from benchtool.analysis.orders import across_gaps, held_angle, unwrapped_angle
from benchtool.block import Block

RATE_HZ, ROWS = 2000.0, 4000
TIME_S = np.arange(ROWS) / RATE_HZ
LOST = slice(3000, 3300)
COURSES = {
    "starts": 100.0 * np.clip((TIME_S - 0.5) / 0.3, 0.0, 1.0),
    "starts at once": np.where(TIME_S < 0.5, 0.0, 100.0 * (1.0 - np.exp(-(TIME_S - 0.5) / 5e-3))),
    "stops": 100.0 * np.clip((1.9 - TIME_S) / 0.2, 0.0, 1.0),
    "rests at a reversal": np.where(
        np.abs(TIME_S - 1.0) < 0.1, 0.0, np.clip(300.0 * (TIME_S - 1.0), -90, 90)
    ),
    "swings": 50.0 * np.sin(4.0 * np.pi * TIME_S + 0.7),
}


@pytest.mark.parametrize("counts", [0, 4096, 65536])
@pytest.mark.parametrize("course", COURSES)
def test_a_rotor_that_rests_is_told_from_an_angle_that_was_lost(course: str, counts: int) -> None:
    theta = np.mod(0.3 + np.cumsum(COURSES[course]) / RATE_HZ, 2.0 * np.pi)
    if counts:
        theta = np.floor(theta * counts / (2.0 * np.pi)) * 2.0 * np.pi / counts
    assert not np.any(held_angle(unwrapped_angle(theta)))
    theta[LOST] = theta[LOST.start]
    rows = np.flatnonzero(held_angle(unwrapped_angle(theta)))
    assert abs(len(rows) - 300) <= 2
    assert abs(rows[0] - 3000) <= 2


@pytest.mark.parametrize("moves", [40, 60, 63, 64, 200])
def test_an_angle_of_few_counts_is_not_lost_between_them(moves: int) -> None:
    step = 2.0 * np.pi / 12
    angle = step * np.floor(moves * np.arange(5000) / 5000 + 0.3)
    assert not np.any(held_angle(angle))
    angle[2000:3500] = angle[2000]
    rows = np.flatnonzero(held_angle(angle))
    assert len(rows) >= 1500


@pytest.mark.parametrize(("first", "lost"), [(700, 8), (700, 40), (700, 200), (0, 40), (0, 200)])
def test_orders_do_without_a_few_rows_of_a_lost_angle(first: int, lost: int) -> None:
    """They were taken for a wobble of the angle: of 40 rows among 2000 u was 57 times as much."""
    random, rows = np.random.default_rng(3), 2000
    theta = 100.0 * np.arange(rows) / RATE_HZ
    torque = 1.0 + 0.1 * np.sin(24.0 * theta) + 0.02 * random.standard_normal(rows)
    read = np.mod(theta, 2.0 * np.pi)
    read[first : first + lost] = read[first]
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm", "theta_m": "rad"}, torque=torque, theta_m=read)
    found = {each.name: each for each in order_analysis(block, "torque", orders=[24]).measurements}
    order = found["torque_order_24"]
    assert order.uncertainty is not None
    assert order.uncertainty.standard < 1e-3
    assert abs(order.value - 0.1) < 3.0 * order.uncertainty.standard


def test_a_gap_of_several_turns_is_no_wobble() -> None:
    """The rows behind it were by whole turns off a track of the angle, and u 500 times as much."""
    random, rows = np.random.default_rng(3), 4000
    theta = 100.0 * np.arange(rows) / RATE_HZ
    i_a = 5.0 * np.sin(4.0 * theta) + 0.02 * random.standard_normal(rows)
    read = np.mod(theta + 1e-5 * random.standard_normal(rows), 2.0 * np.pi)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A", "theta_m": "rad"}, i_a=i_a, theta_m=read)
    missing = np.zeros(rows, dtype=np.bool_)
    missing[1500:1800] = True
    found = {
        each.name: each for each in order_analysis(block.without(missing), "i_a", orders=[4]).measurements
    }
    order = found["i_a_order_4"]
    assert order.uncertainty is not None
    assert order.uncertainty.standard < 2e-3
    assert abs(order.value - 5.0) < 3.0 * order.uncertainty.standard


def test_turns_in_gaps_are_those_of_the_speed_beside_them() -> None:
    times = np.delete(np.arange(1000.0), np.s_[300:500])
    angle = 0.05 * times + 1e-4 * times**2
    wrapped = np.mod(angle, 2.0 * np.pi)
    assert np.allclose(across_gaps(np.unwrap(wrapped), times), angle)
    assert np.array_equal(across_gaps(angle, times), angle)
