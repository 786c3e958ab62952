"""Sizes of a ripple that differ from period to period: what few periods tell of them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import Measurement, torque_ripple, track_angle
from benchtool.analysis.torque.means_of_periods import Periods
from benchtool.analysis.torque.ripple_sizes import is_size_untold
from benchtool.block import Block, Channel

PER_PERIOD = 200
SIZES = (
    "torque_ripple_rms",
    "torque_ripple_pp",
    "torque_ripple_percentile_range",
    "torque_ripple_percent_of_mean",
)
Array = NDArray[np.float64]


def ripple(sizes: Array, random: np.random.Generator) -> Array:
    """Return a ripple of so many sizes, shape (periods,), in noise."""
    count = len(sizes) * PER_PERIOD
    angle = 2 * np.pi * np.arange(count) / PER_PERIOD
    return np.asarray(
        np.repeat(sizes, PER_PERIOD) * np.cos(6.0 * angle) + 0.01 * random.standard_normal(count)
    )


def repeats(periods: int, per_revolution: int = 1) -> Periods:
    return Periods(np.arange(0, periods * PER_PERIOD + 1, PER_PERIOD), per_revolution=per_revolution)


def numbers(samples: Array) -> dict[str, Measurement]:
    angle = 2 * np.pi * np.arange(len(samples)) / PER_PERIOD
    block = Block((Channel("torque", "Nm"),), 0, 1, 1e-4, (2.0 + samples)[:, np.newaxis])
    return {each.name: each for each in torque_ripple(block, track=track_angle(angle, 1))}


@pytest.mark.parametrize("periods", [5, 8, 14, 19])
def test_numbers_of_a_ripple_whose_size_wanders_for_few_periods_are_not_known(periods: int) -> None:
    random = np.random.default_rng(periods)
    found = numbers(ripple(0.1 + 0.02 * random.standard_normal(periods), random))
    assert found["torque_mean"].uncertainty is not None
    for name in SIZES:
        assert found[name].uncertainty is None
        assert "record longer" in found[name].uncertainty_reason


def test_numbers_of_a_ripple_whose_size_differs_in_many_periods_are_known() -> None:
    random = np.random.default_rng(2)
    found = numbers(ripple(0.1 + 0.02 * random.standard_normal(40), random))
    assert all(found[name].uncertainty is not None for name in SIZES)


def test_noise_and_a_phase_that_is_not_followed_are_no_size() -> None:
    random = np.random.default_rng(3)
    refused = sum(is_size_untold(ripple(np.full(8, 0.1), random), repeats(8)) for _ in range(100))
    assert refused <= 5
    angle = 2 * np.pi * np.arange(8 * PER_PERIOD) / PER_PERIOD
    wandering = np.cos(6.0 * angle + np.repeat(0.1 * random.standard_normal(8), PER_PERIOD))
    assert not is_size_untold(wandering, repeats(8))


def test_what_every_revolution_repeats_is_no_wander() -> None:
    random = np.random.default_rng(4)
    samples = ripple(np.tile([0.1, 0.12, 0.11, 0.09], 3), random)
    assert is_size_untold(samples, repeats(12))
    assert not is_size_untold(samples, repeats(12, per_revolution=4))
