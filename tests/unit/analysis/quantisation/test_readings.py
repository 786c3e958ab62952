"""What is read of a value on average over noise, against readings of draws of it."""

from __future__ import annotations

import numpy as np
import pytest

from benchtool.analysis.quantisation.readings import Readings

SIGNALS = np.linspace(-1.3, 1.7, 301)[np.newaxis]


@pytest.mark.parametrize("noise", [0.05, 0.4])
@pytest.mark.parametrize("shape", [-1.0, 0.0, 1.0])
def test_mean_and_variance_of_readings_are_those_of_draws(noise: float, shape: float) -> None:
    random, size = np.random.default_rng(4), (20_000, 1)
    drawn = {
        -1.0: random.laplace(0.0, np.sqrt(0.5), size),
        0.0: random.standard_normal(size),
        1.0: random.uniform(-np.sqrt(3.0), np.sqrt(3.0), size),
    }[shape]
    read = np.round(SIGNALS + noise * drawn)
    mean, variance = Readings.of(np.array([noise]), np.array([shape])).at(SIGNALS)
    assert mean[0] == pytest.approx(
        np.mean(read, axis=0), abs=0.06
    )  # a cell at an edge; 5 sigma of the draws
    assert variance[0] == pytest.approx(np.var(read, axis=0), abs=0.06)


@pytest.mark.parametrize("noise", [0.005, 0.1])
def test_means_from_place_to_place_are_those_of_many_places_between(noise: float) -> None:
    theta = 2.0 * np.pi * np.arange(1 << 14) / (1 << 14)
    waveform = 0.3 + 1.4 * np.cos(theta + 0.2) + 0.2 * np.cos(3.0 * theta)
    readings = Readings.of(np.array([noise]), np.zeros(1))
    fine = [np.mean(each.reshape(128, 128), axis=1) for each in readings.at(waveform[np.newaxis])]
    coarse = readings.from_place_to_place(waveform[np.newaxis, ::128])
    for expected, found in zip(fine, coarse, strict=True):
        assert found[0] == pytest.approx(expected, abs=0.03)
        assert np.mean(found) == pytest.approx(np.mean(expected), abs=0.002)


def test_places_of_a_flat_waveform_are_read_as_it_is() -> None:
    readings = Readings.of(np.array([0.1]), np.zeros(1))
    flat = np.full((1, 8), 0.42)
    for at, between in zip(readings.at(flat), readings.from_place_to_place(flat), strict=True):
        assert between == pytest.approx(at, rel=1e-9)
