"""The motion behind counts is known to a small part of one of them."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.counted_motion import CountedMotion, motion_behind
from tests.unit.analysis.quantisation.counted_shaft import RATE_HZ, Shaft

COUNT_RAD = Shaft().count_rad


def off_by(motion: CountedMotion, counts: np.ndarray, places: np.ndarray) -> float:
    """Return the rms, in counts, by which a motion found is off true places."""
    rows = np.arange(len(counts), dtype=np.float64)
    return float(np.std(motion.at(rows, COUNT_RAD * counts) - places))


@pytest.mark.parametrize(
    "shaft",
    [
        Shaft(),
        Shaft(drift=0.3),
        Shaft(speed_rad_s=-42.0),
        Shaft(ripple=()),
        Shaft(speed_rad_s=14.002 * COUNT_RAD * RATE_HZ),  # whose rounding moves slowly from row to row
    ],
)
def test_a_motion_is_known_to_a_hundredth_of_a_count(shaft: Shaft) -> None:
    forwards = Shaft(shaft.turns, abs(shaft.speed_rad_s), shaft.drift, shaft.ripple)
    places = np.sign(shaft.speed_rad_s) * forwards.angle_rad(np.random.default_rng(1)) / COUNT_RAD
    counts = np.floor(places)
    motion = motion_behind(counts, np.arange(len(counts), dtype=np.float64), COUNT_RAD)
    assert off_by(motion, counts, places) < 0.01
    assert motion.shakes < 0.01


def test_a_shaft_that_shakes_is_followed_but_for_that() -> None:
    random = np.random.default_rng(2)
    places = Shaft().angle_rad(random) / COUNT_RAD
    shakes = 0.3 * random.standard_normal(len(places))
    counts = np.floor(places + shakes)
    motion = motion_behind(counts, np.arange(len(counts), dtype=np.float64), COUNT_RAD)
    assert off_by(motion, counts, places) < 0.03
    assert motion.shakes == pytest.approx(0.3, rel=0.1)
    assert motion.edges < 0.1


def test_edges_that_are_off_are_told_from_a_shaft_that_shakes() -> None:
    random, shaft = np.random.default_rng(3), Shaft(counts=2048)
    places = shaft.angle_rad(random) / shaft.count_rad
    edges = (
        np.arange(-2.0, 15.0 * shaft.counts)
        + 0.1 * np.tile(random.standard_normal(shaft.counts), 16)[: 15 * shaft.counts + 2]
    )
    counts = np.searchsorted(np.sort(edges), places).astype(np.float64)
    motion = motion_behind(counts, np.arange(len(counts), dtype=np.float64), shaft.count_rad)
    assert motion.edges == pytest.approx(0.1, rel=0.3)
