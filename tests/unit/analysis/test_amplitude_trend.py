"""A ramp, a step and a swing of an amplitude are told from one that wanders at random."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np
import pytest
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.spectra.amplitude_trend import amplitude_trend
from benchtool.analysis.spectra.harmonics import line_errors
from benchtool.analysis.spectra.modulation import phase_noise_rad
from benchtool.analysis.spectra.phase_following import wander
from benchtool.analysis.spectra.spectrum import FIRST_ROW, coherent_samples, spectrum_of

Array = NDArray[np.float64]
PERIODS, PER_PERIOD = 40, 200
PLACE = (np.arange(PERIODS) + 0.5) / PERIODS
CURVES: dict[str, Callable[[Array], Array]] = {
    "ramp": lambda place: 0.05 * (place - 0.5),
    "parabola": lambda place: 0.05 * (place - 0.4) ** 2,
    "warming up": lambda place: 0.03 * (np.exp(-3.0 * place) - 0.3167),
    "step": lambda place: np.asarray(0.01 * (place > 0.55)),
    "swing": lambda place: np.asarray(0.02 * np.cos(2 * np.pi * 6.6 * place + 1.0)),
}


@pytest.mark.parametrize("name", CURVES)
def test_the_sidebands_of_a_course_are_its_fourier_coefficients(name: str) -> None:
    curve = CURVES[name]
    noise = 1e-5 * np.random.default_rng(1).standard_normal(PERIODS)
    found = amplitude_trend(3.0 * (1.0 + curve(PLACE) + noise), 8)
    assert found is not None
    fine = (np.arange(40_000) + 0.5) / 40_000
    course = curve(fine)
    for offset, own in enumerate(found.sidebands, 1):
        expected = np.mean(course * np.exp(-2j * np.pi * offset * fine))
        assert own == pytest.approx(expected, abs=4e-4 * (1.0 if name == "step" else 0.2))


def test_a_walk_is_no_trend() -> None:
    random = np.random.default_rng(2)
    walks = 1.0 + 1e-3 * np.cumsum(random.standard_normal((60, PERIODS)), axis=1)
    assert sum(amplitude_trend(walk, 8) is not None for walk in walks) <= 1  # by chance one in two hundred


def test_the_mean_of_a_ramp_is_known_as_well_as_that_of_a_constant() -> None:
    random, relative = np.random.default_rng(3), []
    count = (PERIODS + 1) * PER_PERIOD
    theta = 2 * np.pi * np.arange(count) / PER_PERIOD
    track = PhaseTrack(Polynomial([0.0, 2 * np.pi / PER_PERIOD]), count, "as it was made")
    for _ in range(12):
        ramp = 1.0 + 0.05 * (np.arange(count) / (count - 1) - 0.5)
        signal = ramp * np.cos(theta + random.uniform(0, 6)) + 1e-3 * random.standard_normal(count)
        coherent = coherent_samples(signal, 10e3, track)
        seen, spectrum = wander(coherent), spectrum_of(coherent)
        turns = (np.arange(count, dtype=np.float64) - FIRST_ROW) * (spectrum.periods / spectrum.samples)
        errors = line_errors(spectrum, 8, 0.0, 0.0, seen.amplitude, seen.phase_rad, turns)
        assert errors.standard[0] < 5e-4  # of 4e-3 as noise
        relative.append((spectrum.fundamental - 1.0) / errors.standard[0])
    assert 0.5 < np.sqrt(np.mean(np.square(relative))) < 1.3


def test_jitter_is_seen_where_the_signal_is_steep() -> None:
    random = np.random.default_rng(4)
    row = np.arange((PERIODS + 1) * PER_PERIOD, dtype=np.float64)
    track = PhaseTrack(Polynomial([0.0, 2 * np.pi / PER_PERIOD]), len(row), "as it was made")
    jitter = 0.1 * random.standard_normal(len(row))
    noise = 1e-3 * random.standard_normal(len(row))
    for times, expected in ((row, 0.0), (row + jitter, 0.1 * 2 * np.pi / PER_PERIOD)):
        signal = np.cos(2 * np.pi * times / PER_PERIOD) + noise
        found = phase_noise_rad(coherent_samples(signal, 10e3, track))
        assert found == pytest.approx(expected, rel=0.1)


def test_the_memory_that_a_trend_takes_is_proportional_to_the_periods() -> None:
    periods = 8_000
    amplitudes = 1.0 + 1e-3 * np.random.default_rng(5).standard_normal(periods)
    tracemalloc.start()
    amplitude_trend(amplitudes, 8)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < 5_000 * periods  # bytes
