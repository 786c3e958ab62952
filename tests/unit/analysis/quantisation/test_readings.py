"""What is read of a value on average over noise, against readings of draws of it."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.readings import Readings

SIGNALS = np.linspace(-1.3, 1.7, 301)
OF_DRAWS = 0.02  # of a step: over five standard deviations of a mean of draws
AT_AN_EDGE = 0.06  # of a step: a cell of the table beside a jump


@pytest.mark.parametrize("shape", [-1.0, 0.0, 1.0])
def test_mean_and_variance_of_readings_are_those_of_draws(shape: float) -> None:
    random, size = np.random.default_rng(4), (20_000, 1)
    drawn = {
        -1.0: random.laplace(0.0, np.sqrt(0.5), size),
        0.0: random.standard_normal(size),
        1.0: random.uniform(-np.sqrt(3.0), np.sqrt(3.0), size),
    }[shape]
    noise = {0.4: OF_DRAWS, 0.2: OF_DRAWS, 0.05: AT_AN_EDGE}
    readings = Readings.of(np.array([*noise]), np.full(len(noise), shape))
    mean, variance = readings.at(np.tile(SIGNALS, (len(noise), 1)))
    for place, (rms, within) in enumerate(noise.items()):
        read = np.round(SIGNALS + rms * drawn)
        assert mean[place] == pytest.approx(np.mean(read, axis=0), abs=within)
        assert variance[place] == pytest.approx(np.var(read, axis=0), abs=within)


def test_means_from_place_to_place_are_those_of_many_places_between() -> None:
    theta = 2.0 * np.pi * np.arange(1 << 14) / (1 << 14)
    waveform = 0.3 + 1.4 * np.cos(theta + 0.2) + 0.2 * np.cos(3.0 * theta)
    noise = {0.1: 0.003, 0.005: AT_AN_EDGE}
    readings = Readings.of(np.array([*noise]), np.zeros(len(noise)))
    fine = [each.reshape(len(noise), 128, 128) for each in readings.at(np.tile(waveform, (len(noise), 1)))]
    coarse = readings.from_place_to_place(np.tile(waveform[::128], (len(noise), 1)))
    for many, found in zip(fine, coarse, strict=True):
        for place, within in enumerate(noise.values()):
            assert found[place] == pytest.approx(np.mean(many[place], axis=1), abs=within)
            assert np.mean(found[place]) == pytest.approx(np.mean(many[place]), abs=1e-3)


def test_places_of_a_flat_waveform_are_read_as_it_is() -> None:
    readings = Readings.of(np.array([0.1]), np.zeros(1))
    flat = np.full((1, 8), 0.42)
    for at, between in zip(readings.at(flat), readings.from_place_to_place(flat), strict=True):
        assert between == pytest.approx(at, rel=1e-9)
