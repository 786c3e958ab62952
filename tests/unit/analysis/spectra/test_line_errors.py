"""Errors of lines by the steps of a converter, which fold to a slow wander of the amplitude."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis import current_spectrum, track_angle
from benchtool.block import Block

RATE_HZ, FREQUENCY_HZ = 10_000.0, 23.7  # 421.94 samples a period: places hardly move from one to the next
STEP_A, COUNT = 0.08, 13_249


def of_fundamental(relative_wander: float, seed: int) -> tuple[float, float, float]:
    """Return the error of the fundamental of a current in steps, its standard uncertainty, and what of that
    a wander of the amplitude has."""
    random = np.random.default_rng(seed)
    theta = 2.0 * np.pi * (FREQUENCY_HZ * np.arange(COUNT) / RATE_HZ + random.uniform())
    swing = np.cos(2.0 * np.pi * 2.7 * np.arange(COUNT) / RATE_HZ + random.uniform(0.0, 2.0 * np.pi))
    current = 5.0 * (1.0 + relative_wander * swing) * np.cos(theta) + 0.15 * np.cos(5.0 * theta + 1.0)
    current = STEP_A * np.round(current / STEP_A + random.uniform())
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=current)
    found = current_spectrum(block, "i_a", track_angle(theta / 4, 4)).measurements
    fundamental = next(each for each in found if each.name == "current_fundamental")
    assert fundamental.uncertainty is not None
    wander = [each.standard for each in fundamental.uncertainty.budget if "wander of the ampl" in each.name]
    return fundamental.value - 5.0, fundamental.uncertainty.standard, sum(wander)


def test_errors_of_steps_that_fold_slowly_are_no_wander_of_the_amplitude() -> None:
    relative, wanders = [], []
    for seed in range(8):
        error, standard, wander = of_fundamental(0.0, seed)
        relative.append(error / standard)
        wanders.append(wander)
    assert float(np.median(wanders)) < 0.002 * STEP_A  # of 0.01 as they are
    assert 0.5 < np.sqrt(np.mean(np.square(relative))) < 1.5


@pytest.mark.parametrize("seed", range(2))
def test_a_wander_of_the_amplitude_beyond_the_steps_stays(seed: int) -> None:
    error, standard, _ = of_fundamental(0.02, seed)
    assert abs(error) < 3.0 * standard
