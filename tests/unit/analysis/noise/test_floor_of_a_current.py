"""The noise floor of a current: what its amplitude does is no noise, and few bins tell a slope."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.coverage.noise import coloured
from benchtool.analysis import CurrentSpectrum, current_spectrum, track_angle
from benchtool.block import Block
from tests.at_length import at_length

Array = NDArray[np.float64]
RATE_HZ = 10e3


def measured(current: Array, frequency_Hz: float) -> tuple[float, float, CurrentSpectrum]:
    """Return the floor of a current of 5 A with an exact angle, its uncertainty, and all else."""
    theta = 2.0 * np.pi * frequency_Hz / RATE_HZ * np.arange(len(current), dtype=np.float64)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=5.0 * np.cos(theta) + current)
    found = current_spectrum(block, "i_a", track_angle(theta, 1))
    floor = next(each for each in found.measurements if each.name == "current_noise_floor")
    assert floor.uncertainty is not None, floor
    return floor.value, floor.uncertainty.standard, found


@pytest.mark.parametrize("swing_Hz", [26.7, *at_length(20.3)])
def test_sidebands_of_an_amplitude_that_swings_fast_are_no_noise(swing_Hz: float) -> None:
    relative = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        time_s = np.arange(2600) / RATE_HZ
        noise = 0.05 * random.standard_normal(len(time_s))
        swing = 0.2 * np.cos(2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi))
        floor, standard, found = measured(swing * np.cos(2 * np.pi * 66.7 * time_s) + noise, 66.7)
        relative.append((floor - 0.1 / np.sqrt(found.spectrum.samples)) / standard)
        assert standard < 0.05 * floor
    assert np.sqrt(np.mean(np.square(relative))) < 1.3


def test_few_bins_of_noise_that_falls_with_frequency_tell_its_slope() -> None:
    """Two whole periods have one bin between two harmonics, thirty in all: half of them are below the least
    tenth of the power, and so is their median."""
    found = []
    for seed in range(60):
        noise = 0.02 * coloured(np.random.default_rng(seed).standard_normal(247), 0.88)
        floor, standard, current = measured(noise, 150.0)
        assert current.spectrum.periods == 2
        found.append((floor, standard))
    floor, standard = np.transpose(found)
    bins = np.arange(1.0, 60.0, 2.0)
    density = (1.0 - 0.88**2) / np.abs(
        1.0 - 0.88 * np.exp(-2j * np.pi * bins / current.spectrum.samples)
    ) ** 2
    truth = 0.04 * np.sqrt(np.mean(density) / current.spectrum.samples)
    relative = (floor - truth) / standard
    assert np.median(np.abs(relative)) < 1.0
    assert np.mean(np.abs(relative) < 2.0) >= 0.8
    assert np.mean(floor) == pytest.approx(truth, rel=0.1)
