"""Scatter of the peak-to-peak of a ripple beside slow lines."""

import math

import numpy as np
import pytest

from benchmarks.coverage.noise import coloured
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


def test_a_size_that_periods_remember_makes_both_extremes_and_is_normal() -> None:
    """By exponential tails the largest of a few normal sizes seemed to scatter twice as much as it does."""
    random, periods, rows = np.random.default_rng(5), 200, 24
    begin, counts = np.arange(0, periods * rows, rows), np.full(periods, rows)
    wave = np.tile(np.cos(2.0 * np.pi * np.arange(rows) / rows), periods)
    values, stated = [], []
    for _ in range(60):
        size = 1.0 + 0.2 * coloured(random.standard_normal(periods + 100), 0.8)[100:]
        samples = np.repeat(size, rows) * wave + 0.01 * random.standard_normal(len(wave))
        values.append(float(np.ptp(samples)))
        stated.append(extremes_of_ripple(samples, samples, begin, Tails.of(samples, begin, counts)))
    assert 0.7 < float(np.median(stated)) / float(np.std(values)) < 1.5
