"""Scatter of the peak-to-peak of a ripple beside slow lines."""

import math

import numpy as np
import pytest

from benchtool.analysis import torque_ripple, track_angle
from benchtool.analysis.torque.ripple_extremes import Tails, extremes_of_ripple
from benchtool.block import Block


def test_periods_of_a_revolution_are_no_heaps_that_a_record_may_miss() -> None:
    """A torque that repeats in each revolution has its largest period in every one, however little noise
    there is."""
    random, pole_pairs, periods, rows = np.random.default_rng(3), 4, 13, 500
    values, stated = [], []
    for _ in range(5):
        theta_e = 2.0 * np.pi * (np.arange(periods * rows + 200) / rows + random.random())
        once, twice = (np.cos(each * theta_e / pole_pairs + each) for each in (1, 2))
        torque_Nm = 2.0 + 0.1 * np.cos(6.0 * theta_e) + 0.12 * once + 0.06 * twice
        torque_Nm += 1e-4 * random.standard_normal(len(torque_Nm))
        block = Block.from_arrays(10_000.0, {"torque": "Nm"}, torque=torque_Nm)
        track = track_angle(theta_e / pole_pairs, pole_pairs)
        found = {each.name: each for each in torque_ripple(block, track=track, pole_pairs=pole_pairs)}
        measured = found["torque_ripple_pp"]
        assert measured.uncertainty is not None
        values.append(measured.value)
        stated.append(measured.uncertainty.standard)
    assert float(np.std(values)) < 2.0 * float(np.median(stated))
    assert float(np.median(stated)) < 5.0 * float(np.std(values))


@pytest.mark.parametrize(("size", "least", "most"), [(0.01, 0.95, 1.05), (3.0, 1.2, math.inf)])
def test_a_slow_line_leaves_few_periods_the_largest_only_where_it_moves_them(
    size: float, least: float, most: float
) -> None:
    random, periods, rows = np.random.default_rng(4), 200, 20
    rest = random.standard_normal(periods * rows)
    samples = rest + size * np.cos(2.0 * np.pi * 3.0 * np.arange(len(rest)) / len(rest))
    begin, counts = np.arange(0, len(rest), rows), np.full(periods, rows)
    alone = extremes_of_ripple(rest, rest, begin, Tails.of(rest, begin, counts))
    beside = extremes_of_ripple(samples, rest, begin, Tails.of(samples, begin, counts))
    assert least * alone < beside < most * alone
