"""The noise floor of a current: what its amplitude does is no noise, and few bins tell a slope."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.coverage.noise import coloured
from benchtool.analysis import CurrentSpectrum, Measurement, current_spectrum, track_angle
from benchtool.block import Block
from tests.at_length import at_length

Array = NDArray[np.float64]
RATE_HZ = 10e3


def floor_of(current: Array, frequency_Hz: float) -> tuple[Measurement, CurrentSpectrum]:
    """Return the floor of a current beside one of 5 A with an exact angle, and all else."""
    theta = 2.0 * np.pi * frequency_Hz / RATE_HZ * np.arange(len(current), dtype=np.float64)
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=5.0 * np.cos(theta) + current)
    found = current_spectrum(block, "i_a", track_angle(theta, 1))
    return next(each for each in found.measurements if each.name == "current_noise_floor"), found


def relative_errors(floors: list[Measurement], truth: float) -> Array:
    """Return errors over standard uncertainties of those that are told, shape (told,)."""
    return np.array(
        [(each.value - truth) / each.uncertainty.standard for each in floors if each.uncertainty is not None]
    )


def of_coloured(size: float, memory: float, bins: Array, samples: float) -> float:
    """Return the floor of noise of a memory, rms over bins of a spectrum of so many samples."""
    density = (1.0 - memory**2) / np.abs(1.0 - memory * np.exp(-2j * np.pi * bins / samples)) ** 2
    return float(2.0 * size * np.sqrt(np.mean(density) / samples))


@pytest.mark.parametrize("swing_Hz", [26.7, *at_length(20.3)])
def test_sidebands_of_an_amplitude_that_swings_fast_are_no_noise(swing_Hz: float) -> None:
    relative: list[float] = []
    for seed in range(12):
        random = np.random.default_rng(seed)
        time_s = np.arange(2600) / RATE_HZ
        noise = 0.05 * random.standard_normal(len(time_s))
        swing = 0.2 * np.cos(2 * np.pi * swing_Hz * time_s + random.uniform(0, 2 * np.pi))
        floor, found = floor_of(swing * np.cos(2 * np.pi * 66.7 * time_s) + noise, 66.7)
        relative.extend(relative_errors([floor], 0.1 / np.sqrt(found.spectrum.samples)))
        assert floor.uncertainty is not None
        assert floor.uncertainty.standard < 0.05 * floor.value
    assert np.sqrt(np.mean(np.square(relative))) < 1.3


def test_few_bins_of_noise_that_falls_with_frequency_tell_its_slope() -> None:
    """Two whole periods have one bin between two harmonics, thirty in all: half of them are below the least
    tenth of the power, and so is their median."""
    floors = []
    for seed in range(60):
        noise = 0.02 * coloured(np.random.default_rng(seed).standard_normal(247), 0.88)
        floor, current = floor_of(noise, 150.0)
        assert current.spectrum.periods == 2
        floors.append(floor)
    truth = of_coloured(0.02, 0.88, np.arange(1.0, 60.0, 2.0), current.spectrum.samples)
    relative = relative_errors(floors, truth)
    assert len(relative) >= 58
    assert np.median(np.abs(relative)) < 1.0
    assert np.mean(np.abs(relative) < 2.0) >= 0.8
    assert np.nanmean([each.value for each in floors]) == pytest.approx(truth, rel=0.1)


def test_noise_that_a_fit_may_have_taken_for_a_decaying_dc_has_no_floor() -> None:
    """Of three periods whose noise falls with frequency, such a fit took the bins that hold most of it."""
    floors = []
    for seed in range(8):
        random, row = np.random.default_rng(seed), np.arange(250.0)
        noise = 0.012 * coloured(random.standard_normal(len(row)), 0.95)
        line = 0.11 * np.cos(2 * np.pi * (3.494 * 150.0 / RATE_HZ * row + random.uniform()))
        floor, current = floor_of(noise + line + 1.2 * np.exp(-row / 12.0), 150.0)
        floors.append(floor)
    bins = np.arange(1.0, 0.5 * current.spectrum.samples)
    bins = bins[bins % current.spectrum.periods > 0]
    relative = relative_errors(floors, of_coloured(0.012, 0.95, bins, current.spectrum.samples))
    assert np.max(np.abs(relative)) < 3.0
    assert len(relative) == 7
    assert any("not told from it" in each.reason for each in floors)
