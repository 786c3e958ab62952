"""Curves between samples that fall at the same places of all periods."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchtool.analysis import percentile_range, torque_ripple, track_angle
from benchtool.analysis.statistics.between_samples import between_samples
from benchtool.block import Block

PERIODS = 40


def ripple(rows: float, begin: float = 0.0, order: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return samples of one order, so many in a period, and where they are, in periods."""
    turns = np.arange(round(PERIODS * rows)) / rows
    return np.cos(2 * np.pi * order * (turns + begin)), turns


@pytest.mark.parametrize("rows", [20.0, 20.5, 20.25])
def test_crests_are_missed_by_what_is_between_places(rows: float) -> None:
    between = between_samples(*ripple(rows, 0.013))

    assert between is not None
    turns = ripple(rows)[1]
    spans = [np.ptp(np.cos(2 * np.pi * (turns + begin))) for begin in np.linspace(0.0, 1.0, 997)]
    expected = math.sqrt(np.mean((2.0 - np.array(spans)) ** 2))
    assert between.error_of(np.ptp) == pytest.approx(expected, rel=0.05)


def test_places_that_are_everywhere_miss_nothing() -> None:
    between = between_samples(*ripple(20.0 + math.sqrt(0.5)))
    assert between is None or between.error_of(np.ptp) < 1e-5


def test_samples_that_move_about_their_places_are_no_noise() -> None:
    samples, turns = ripple(20.5 - 2e-4, 0.013, order=6)
    still = between_samples(*ripple(20.5, 0.013, order=6))
    moved = between_samples(samples + 1e-3 * np.random.default_rng(1).standard_normal(len(turns)), turns)
    assert still is not None
    assert moved is not None
    assert moved.noise == pytest.approx(1e-3, rel=0.1)
    assert moved.error_of(np.ptp) == pytest.approx(still.error_of(np.ptp), rel=0.3)


def test_noise_and_a_drift_are_no_curve() -> None:
    turns = ripple(20.0)[1]
    noise = [
        between_samples(np.random.default_rng(seed).standard_normal(len(turns)), turns) for seed in range(50)
    ]
    assert sum(each is not None for each in noise) <= 1

    samples, turns = ripple(20.0)
    plain, drifting = (between_samples(each, turns) for each in (samples, samples + 0.02 * turns))
    assert plain is not None
    assert drifting is not None
    assert drifting.error_of(np.ptp) == pytest.approx(plain.error_of(np.ptp), rel=0.1)


@pytest.mark.parametrize("name", ["torque_ripple_pp", "torque_ripple_percentile_range"])
def test_extremes_of_coherent_samples_are_known_to_the_curve_between_them(name: str) -> None:
    read, stated = [], []
    for begin in np.random.default_rng(3).uniform(0.0, 1.0, 20):
        samples, turns = ripple(20.0, begin)
        block = Block.from_arrays(8e3, {"torque": "Nm"}, torque=2.0 + 0.1 * samples)
        found = {each.name: each for each in torque_ripple(block, track=track_angle(2 * np.pi * turns, 1))}
        uncertain = found[name].uncertainty
        assert uncertain is not None
        read.append(found[name].value)
        stated.append(uncertain.standard)

    dense = 0.1 * ripple(1000.0)[0]
    true = percentile_range(dense) if "percentile" in name else 0.2
    assert np.sqrt(np.mean((np.array(read) - true) ** 2)) == pytest.approx(np.mean(stated), rel=0.3)
